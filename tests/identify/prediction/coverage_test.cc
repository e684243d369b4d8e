// How far the share inside bands scatters where they are right.
#include "identify/prediction/coverage.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "identify/prediction/bands.h"
#include "identify/prediction/random_streams.h"

namespace clothid::coverage_test {
namespace {

Eigen::MatrixXd Normal(int seed, Eigen::Index rows, Eigen::Index columns) {
  return NormalStream(static_cast<std::uint64_t>(seed), 0, DrawStream::kNoise).Draw(rows, columns);
}

LeaveOneOut CoverageOf(const Eigen::MatrixXd& draws) {
  std::vector<int> numbers(static_cast<std::size_t>(draws.cols()));
  std::iota(numbers.begin(), numbers.end(), 0);
  LeaveOneOut others(static_cast<int>(draws.cols()));
  for (Eigen::Index row = 0; row < draws.rows(); ++row) {
    others.Add(ByOthers(draws.row(row).transpose()), numbers, 2.0);
  }
  return others;
}

TEST(CoverageTest, EachDrawIsJudgedByTheBandsOfTheOthers) {
  for (const int num_draws : {2, 7, 20, 21, 50}) {
    Eigen::VectorXd draws = Normal(num_draws, num_draws, 1);
    draws[1] = draws[0];  // which no order tells apart
    const ByOthers said(draws);
    for (Eigen::Index i = 0; i < num_draws; ++i) {
      Eigen::RowVectorXd others(num_draws - 1);
      others << draws.head(i).transpose(), draws.tail(num_draws - 1 - i).transpose();
      const Eigen::MatrixXd bands = BandsOf(others);
      EXPECT_EQ(said.held[i], bands(0, 0) <= draws[i] && draws[i] <= bands(0, 4) ? 1.0 : 0.0) << num_draws << " " << i;
      EXPECT_EQ(said.missed[i], draws[i] - bands(0, 2)) << num_draws << " " << i;
    }
  }
}

double Binomial(int n, int k, double p) {
  return std::exp(std::lgamma(n + 1.0) - std::lgamma(k + 1.0) - std::lgamma(n - k + 1.0) + k * std::log(p) +
                  (n - k) * std::log(1.0 - p));
}

// The coverage of n independent errors is that of n throws, of 90 % each.
TEST(CoverageTest, IndependentErrorsScatterAsABinomial) {
  constexpr int kRows = 10, kDraws = 1999;  // whose others hold 90 % exactly
  const Eigen::VectorXd shares = CoverageOf(Normal(1, kRows, kDraws)).Shares();
  ASSERT_EQ(shares.size(), kDraws);
  EXPECT_NEAR(shares.mean(), 0.9, 1e-3);
  for (int held = 6; held <= kRows; ++held) {
    const double expected = Binomial(kRows, held, 0.9);
    const auto found = static_cast<double>(((shares.array() * kRows - held).abs() < 0.1).count());
    EXPECT_NEAR(found / kDraws, expected, 4.0 * std::sqrt(expected * (1.0 - expected) / kDraws)) << held;
  }
  const RightRange range =
      RangeOf(CoverageOf(Normal(2, 4000, 50)).Shares());  // .9 -+ 1.645 sqrt(.09/4000), and .002 of ranks
  EXPECT_NEAR(range.low, 0.8922, 0.006);
  EXPECT_NEAR(range.high, 0.9078, 0.006);
}

TEST(CoverageTest, OneErrorThatAllHaveInCommonIsHeldAsAWholeOrNot) {
  const LeaveOneOut others = CoverageOf(Normal(3, 1, 50).replicate(200, 1));
  const Eigen::VectorXd shares = others.Shares();
  EXPECT_EQ((shares.array() == 0.0).count(), 4) << "two of either end";
  EXPECT_EQ((shares.array() == 1.0).count(), 46);
  const RightRange range = RangeOf(shares);
  EXPECT_EQ(range.low, 0.0);
  EXPECT_EQ(range.high, 1.0);
}

// What few draws do to the mean: nothing where p (n + 1) is whole; a Gaussian tail is convex where n = 49 interpolates.
TEST(CoverageTest, FewDrawsMakeNoBias) {
  for (const int num_draws : {20, 40}) {
    EXPECT_NEAR(CoverageOf(Normal(4, 50, num_draws)).Shares().mean(), 0.9, 1e-12) << num_draws;
  }
  const double mean = CoverageOf(Normal(5, 5000, 50)).Shares().mean();
  EXPECT_GT(mean, 0.9);
  EXPECT_LT(mean, 0.907);
}

// Clouds of three common errors and noise, and another draw as the truth: it holds less than it should once in twenty
// times, and is as often nearer than it should, and farther.
TEST(CoverageTest, ARightPredictionIsInItsRangeNineTimesInTen) {
  constexpr int kClouds = 2000, kDraws = 20, kRows = 60;
  int num_below = 0, num_near = 0, num_far = 0, num_usual = 0;
  for (int cloud = 0; cloud < kClouds; ++cloud) {
    const Eigen::MatrixXd numbers = Normal(cloud, kRows, kDraws + 4);
    const Eigen::MatrixXd factors = Normal(kClouds + cloud, 3, kDraws + 1);
    const Eigen::MatrixXd all = numbers.rightCols(3) * factors + 0.3 * numbers.leftCols(kDraws + 1);
    const Eigen::MatrixXd draws = all.leftCols(kDraws), bands = BandsOf(draws);
    const Eigen::ArrayXd truth = all.col(kDraws);
    const double inside =
        static_cast<double>((bands.col(0).array() <= truth && truth <= bands.col(4).array()).count()) / kRows;
    const LeaveOneOut others = CoverageOf(draws);
    const RightRange shares = RangeOf(others.Shares()), errors = RangeOf(others.Errors());
    const double error = 2.0 * std::sqrt((truth.matrix() - bands.col(2)).squaredNorm() / kRows);
    if (inside < shares.low) ++num_below;
    if (error < errors.low) ++num_near;
    if (error > errors.high) ++num_far;
    if (0.8 <= inside && inside <= 0.98) ++num_usual;
  }
  EXPECT_NEAR(num_below / static_cast<double>(kClouds), 0.05, 0.02);
  EXPECT_NEAR(num_near / static_cast<double>(kClouds), 0.05, 0.02);
  EXPECT_NEAR(num_far / static_cast<double>(kClouds), 0.05, 0.02);
  EXPECT_LT(num_usual, kClouds / 2) << "though all of them are right";
}

// Ten errors of standard deviation two, in units of two.
TEST(CoverageTest, ErrorsAreThoseOfTheMedian) {
  const Eigen::VectorXd errors = CoverageOf(Normal(7, 10, 1999)).Errors();
  EXPECT_NEAR(errors.squaredNorm() / 1999.0, 4.0, 0.1);
}

TEST(CoverageTest, WhatIsMissingCountsNowhere) {
  LeaveOneOut others(3);
  EXPECT_EQ(others.Shares().size(), 0);
  ByOthers said(Eigen::Vector2d(1.0, 4.0));
  said.held = Eigen::Array2d(1.0, 0.0);
  others.Add(said, {0, 2}, 1.0);
  said.held = Eigen::Array2d(0.0, 0.0);
  others.Add(said, {0, 2}, 2.0);
  EXPECT_EQ(others.Shares(), Eigen::Vector2d(0.5, 0.0));
  EXPECT_NEAR(others.Errors()[1], 3.0 * std::sqrt(2.5), 1e-12);
}

}  // namespace
}  // namespace clothid::coverage_test
