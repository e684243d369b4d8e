// Ranks, their correlation and its p-value against known values.
#include "tools/benchmark/fits/rank_correlation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

namespace clothid {
namespace {

TEST(RankCorrelation, EqualValuesShareTheirRanks) {
  EXPECT_EQ(AverageRanks({3.0, 1.0, 2.0}), (std::vector<double>{3, 1, 2}));
  EXPECT_EQ(AverageRanks({5.0, 1.0, 5.0, 0.0, 5.0}), (std::vector<double>{4, 2, 4, 1, 4}));
  EXPECT_EQ(AverageRanks({7.0, 7.0}), (std::vector<double>{1.5, 1.5}));
}

TEST(RankCorrelation, AGrowingFunctionHasOne) {
  const RankCorrelation up = SpearmanCorrelation({1, 2, 3, 4, 5}, {1, 8, 27, 64, 125});
  EXPECT_EQ(up.rho, 1.0);
  EXPECT_DOUBLE_EQ(up.p_value, 2.0 / 120.0);  // two of 5! orders
  const RankCorrelation down = SpearmanCorrelation({1, 2, 3, 4, 5}, {9, 7, 5, 3, 1});
  EXPECT_EQ(down.rho, -1.0);
  EXPECT_DOUBLE_EQ(down.p_value, 2.0 / 120.0);
}

// Orders of four that are as far: rho = 1 - 6 sum d^2/60, |rho| >= 0.8 for sum d^2 <= 2 or >= 18: 1 + 3 each.
TEST(RankCorrelation, ExactForFewPairs) {
  const RankCorrelation correlation = SpearmanCorrelation({1, 2, 3, 4}, {10, 20, 40, 30});
  EXPECT_DOUBLE_EQ(correlation.rho, 0.8);
  EXPECT_DOUBLE_EQ(correlation.p_value, 8.0 / 24.0);
}

// Ranks (1, 2.5, 2.5, 4) against (1, 2, 3, 4): 4.5/sqrt(4.5 * 5). Four of 24 orders have that |rho|, none more.
TEST(RankCorrelation, ExactWithTies) {
  const RankCorrelation correlation = SpearmanCorrelation({1, 2, 3, 4}, {0, 5, 5, 6});
  EXPECT_NEAR(correlation.rho, 4.5 / std::sqrt(22.5), 1e-15);
  EXPECT_DOUBLE_EQ(correlation.p_value, 4.0 / 24.0);
}

// rho = 1 - 6 * 8/(10 * 99) = 0.951515..; the p-value of R's and SciPy's t approximation, and the odd number of degrees
// of freedom next to it.
TEST(RankCorrelation, StudentBeyond) {
  std::vector<double> x, y;
  for (int i = 0; i < 10; ++i) {
    x.push_back(i);
    y.push_back(i ^ (i < 8 ? 1 : 0));
  }
  const RankCorrelation even = SpearmanCorrelation(x, y);
  EXPECT_NEAR(even.rho, 1.0 - 48.0 / 990.0, 1e-15);
  EXPECT_NEAR(even.p_value, 2.279854920641572e-05, 1e-12);
  x.push_back(10);
  y.push_back(-1);
  const RankCorrelation odd = SpearmanCorrelation(x, y);
  EXPECT_NEAR(odd.p_value, 0.15090149929248559, 1e-12);
}

TEST(RankCorrelation, PerfectOrderBeyondIsNoZero) {
  std::vector<double> x;
  for (int i = 0; i < 12; ++i) x.push_back(i);
  const RankCorrelation correlation = SpearmanCorrelation(x, x);
  EXPECT_EQ(correlation.rho, 1.0);
  EXPECT_NEAR(correlation.p_value * 479001600.0, 2.0, 1e-12);  // 12!
}

TEST(RankCorrelation, NoNumberWithoutAQuestion) {
  EXPECT_TRUE(std::isnan(SpearmanCorrelation({1, 2}, {1, 2}).rho));
  const RankCorrelation constant = SpearmanCorrelation({1, 2, 3, 4}, {5, 5, 5, 5});
  EXPECT_TRUE(std::isnan(constant.rho));
  EXPECT_TRUE(std::isnan(constant.p_value));
  EXPECT_THROW(SpearmanCorrelation({1, 2, 3}, {1, 2}), std::invalid_argument);
  EXPECT_THROW(SpearmanCorrelation({1, 2, 3}, {1, 2, std::numeric_limits<double>::quiet_NaN()}), std::invalid_argument);
}

}  // namespace
}  // namespace clothid
