// The noise of a recording is found under motion, gaps, uneven times and jumps.
#include "datasets/motion/noise_estimate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace clothid::noise_estimate_test {
namespace {

constexpr int kPoints = 20, kFrames = 120;
constexpr double kLeast = 1e-9;

// Frames at about 10 Hz, unevenly, with a gap of 0.8 s.
Eigen::VectorXd UnevenTimes(std::mt19937_64* generator) {
  std::uniform_real_distribution<double> interval(0.08, 0.12);
  Eigen::VectorXd times(kFrames);
  times[0] = 5.0;
  for (int i = 1; i < kFrames; ++i) times[i] = times[i - 1] + (i == 40 ? 0.8 : interval(*generator));
  return times;
}

// Points that swing by 10 cm in 3 s, seen with noise of `sigma` [3] per axis.
Eigen::MatrixXd Swinging(const Eigen::VectorXd& times, const Eigen::Vector3d& sigma, std::mt19937_64* generator) {
  std::normal_distribution<double> normal;
  Eigen::MatrixXd positions(3 * kPoints, kFrames);
  for (int i = 0; i < kFrames; ++i) {
    for (int p = 0; p < kPoints; ++p) {
      for (int axis = 0; axis < 3; ++axis) {
        positions(3 * p + axis, i) = 0.1 * std::sin(2.1 * times[i] + p + axis) + sigma[axis] * normal(*generator);
      }
    }
  }
  return positions;
}

TEST(NoiseEstimateTest, FindsTheNoiseUnderTheMotion) {
  std::mt19937_64 generator(1);
  const Eigen::VectorXd times = UnevenTimes(&generator);
  Eigen::MatrixXd positions = Swinging(times, Eigen::Vector3d(4e-3, 4e-3, 1e-3), &generator);
  const double truth = std::sqrt((16.0 + 16.0 + 1.0) / 3.0) * 1e-3;
  EXPECT_NEAR(EstimateSigma(times, positions, kLeast).mean(), truth, 0.1 * truth);
  // A tenth of the points missing, so that the motion between neighbours counts for more, and every thirtieth frame
  // flipped.
  std::bernoulli_distribution drop(0.1);
  for (auto point : positions.reshaped(3, positions.size() / 3).colwise()) {
    if (drop(generator)) point.setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  for (int i = 15; i < kFrames; i += 30) positions.col(i) = positions.col(i).reverse().eval();
  const Eigen::VectorXd sigma = EstimateSigma(times, positions, kLeast);
  EXPECT_NEAR(sigma.mean(), truth, 0.25 * truth);
  EXPECT_LT(sigma.maxCoeff(), 2.0 * truth);
  EXPECT_GT(sigma.minCoeff(), 0.5 * truth);
}

TEST(NoiseEstimateTest, TellsPointsApart) {
  std::mt19937_64 generator(2);
  const Eigen::VectorXd times = UnevenTimes(&generator);
  Eigen::MatrixXd positions = Swinging(times, Eigen::Vector3d::Constant(1e-3), &generator);
  positions.topRows(3) = Swinging(times, Eigen::Vector3d::Constant(8e-3), &generator).topRows(3);
  const Eigen::VectorXd sigma = EstimateSigma(times, positions, kLeast);
  EXPECT_NEAR(sigma[0], 8e-3, 3e-3);
  EXPECT_NEAR(sigma.tail(kPoints - 1).mean(), 1e-3, 2e-4);
}

TEST(NoiseEstimateTest, AddsLittleWhereThereIsNone) {
  std::mt19937_64 generator(3);
  const Eigen::VectorXd times = UnevenTimes(&generator);
  EXPECT_LT(EstimateSigma(times, Swinging(times, Eigen::Vector3d::Zero(), &generator), kLeast).maxCoeff(), 1e-4);
  EXPECT_EQ(EstimateSigma(times, Eigen::MatrixXd::Ones(3, kFrames), kLeast)[0], kLeast);
}

TEST(NoiseEstimateTest, APointSeenRarelyHasTheNoiseOfAll) {
  std::mt19937_64 generator(4);
  const Eigen::VectorXd times = UnevenTimes(&generator);
  Eigen::MatrixXd positions = Swinging(times, Eigen::Vector3d::Constant(2e-3), &generator);
  positions.topRightCorner(3, kFrames - 5).setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_NEAR(EstimateSigma(times, positions, kLeast)[0], 2e-3, 2e-4);
  EXPECT_EQ(EstimateSigma(times.head(2), positions.leftCols(2), kLeast).size(), 0);
}

}  // namespace
}  // namespace clothid::noise_estimate_test
