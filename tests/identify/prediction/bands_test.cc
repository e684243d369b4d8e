// Quantiles of draws and their score.
#include "identify/prediction/bands.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>

#include "identify/prediction/random_streams.h"

namespace clothid::bands_test {
namespace {

TEST(BandsTest, QuantilesHoldWhatTheySay) {
  Eigen::MatrixXd draws(2, 19);
  for (int i = 0; i < 19; ++i) draws.col(i) << (7 * i) % 19 + 1, -((5 * i) % 19 + 1);
  const Eigen::MatrixXd bands = BandsOf(draws);
  // Ranks p (D + 1) of 1 .. 19: a new draw is below the first, or above the last, in 5 of 100 cases.
  EXPECT_EQ(bands.row(0), (Eigen::RowVectorXd(5) << 1.0, 5.0, 10.0, 15.0, 19.0).finished());
  EXPECT_EQ(bands.row(1), (Eigen::RowVectorXd(5) << -19.0, -15.0, -10.0, -5.0, -1.0).finished());
}

TEST(BandsTest, QuantilesBetweenDrawsAreInterpolated) {
  Eigen::MatrixXd draws(1, 50);
  std::iota(draws.reshaped().begin(), draws.reshaped().end(), 1.0);
  const Eigen::MatrixXd bands = BandsOf(draws);
  EXPECT_NEAR(bands(0, 0), 2.55, 1e-12);
  EXPECT_NEAR(bands(0, 2), 25.5, 1e-12);
  EXPECT_NEAR(bands(0, 4), 48.45, 1e-12);
}

// int (F(z) - 1[z >= seen])^2 dz, by the midpoint rule.
double ScoreByIntegral(const Eigen::VectorXd& draws, double seen) {
  constexpr int kCells = 400000;
  const double low = std::min(draws.minCoeff(), seen) - 1.0, high = std::max(draws.maxCoeff(), seen) + 1.0;
  const double width = (high - low) / kCells;
  double sum = 0.0;
  for (int i = 0; i < kCells; ++i) {
    const double z = low + (i + 0.5) * width;
    const double below = static_cast<double>((draws.array() <= z).count()) / static_cast<double>(draws.size());
    sum += width * std::pow(below - (z >= seen ? 1.0 : 0.0), 2);
  }
  return sum;
}

TEST(BandsTest, WhatNeverHappensInSomeDrawsIsInfinite) {
  Eigen::MatrixXd draws = Eigen::MatrixXd::Constant(1, 20, std::numeric_limits<double>::infinity());
  draws.leftCols(12).setConstant(2.0);
  const Eigen::MatrixXd bands = BandsOf(draws);
  EXPECT_EQ(bands(0, 0), 2.0);
  EXPECT_EQ(bands(0, 2), 2.0);
  EXPECT_TRUE(std::isinf(bands(0, 3)));
  EXPECT_TRUE(std::isinf(bands(0, 4)));
}

TEST(BandsTest, TheScoreIsItsIntegral) {
  const Eigen::VectorXd draws = NormalStream(1, 0, DrawStream::kNoise).Draw(20, 1);
  for (const double seen : {-3.0, -0.4, 0.0, 0.7, 2.5}) {
    EXPECT_NEAR(RankedScore(draws, seen), ScoreByIntegral(draws, seen), 2e-5) << seen;
  }
}

TEST(BandsTest, TheScoreOfOneDrawIsItsErrorAndMovesWithBoth) {
  EXPECT_EQ(RankedScore(Eigen::VectorXd::Constant(1, 3.0), 1.0), 2.0);
  const Eigen::VectorXd draws = NormalStream(1, 0, DrawStream::kNoise).Draw(50, 1);
  EXPECT_NEAR(RankedScore(3.0 * draws.array() + 5.0, 3.0 * 0.2 + 5.0), 3.0 * RankedScore(draws, 0.2), 1e-12);
}

// That of the normal distribution at its mean is (sqrt 2 - 1)/sqrt pi (Gneiting and Raftery 2007, Eq. 21).
TEST(BandsTest, TheScoreOfManyDrawsIsThatOfTheirDistribution) {
  const Eigen::VectorXd draws = NormalStream(1, 0, DrawStream::kNoise).Draw(200000, 1);
  EXPECT_NEAR(RankedScore(draws, 0.0), (std::sqrt(2.0) - 1.0) / std::sqrt(std::acos(-1.0)), 2e-3);
}

}  // namespace
}  // namespace clothid::bands_test
