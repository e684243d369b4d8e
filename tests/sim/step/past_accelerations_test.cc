// Each stage has its own past, and the guess that was the best is made again.
#include "sim/step/past_accelerations.h"

#include <gtest/gtest.h>

namespace clothid::past_accelerations_test {
namespace {

Eigen::VectorXd Single(double value) { return Eigen::VectorXd::Constant(3, value); }

TEST(PastAccelerationsTest, StagesHavePastsOfTheirOwn) {
  PastAccelerations past;
  EXPECT_EQ(past.Guess(Stage::kFirst).size(), 0);
  past.Add(Stage::kFirst, Single(1.0));
  EXPECT_EQ(past.Guess(Stage::kSecond), Single(1.0));  // the last solve is better than none
  past.Add(Stage::kSecond, Single(5.0));
  EXPECT_EQ(past.Guess(Stage::kFirst), Single(1.0));
  EXPECT_EQ(past.Guess(Stage::kSecond), Single(5.0));
  past.Clear();
  EXPECT_EQ(past.Guess(Stage::kFirst).size(), 0);
}

TEST(PastAccelerationsTest, TheBestGuessIsMadeAgain) {
  PastAccelerations past;
  for (const double value : {1.0, 2.0, 3.0}) past.Add(Stage::kOnly, Single(value));
  EXPECT_EQ(past.Guess(Stage::kOnly), Single(4.0));
  past.Add(Stage::kOnly, Single(3.1));  // no further on
  EXPECT_EQ(past.Guess(Stage::kOnly), Single(3.1));
  past.Add(Stage::kOnly, Single(-2.0));  // it changes its sign
  EXPECT_EQ(past.Guess(Stage::kOnly).size(), 0);
}

}  // namespace
}  // namespace clothid::past_accelerations_test
