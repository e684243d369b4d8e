#include "identify/repetition/distributions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "identify/uncertainty/correlated_scores.h"

namespace clothid {
namespace {

TEST(DistributionsTest, HasTheTabulatedQuantilesOfStudent) {
  const std::vector<std::pair<int, double>> table = {{1, 12.706205}, {2, 4.302653}, {3, 3.182446},  {4, 2.776445},
                                                     {5, 2.570582},  {9, 2.262157}, {12, 2.178813}, {30, 2.042272}};
  for (const auto& [degrees, quantile] : table) {
    EXPECT_NEAR(StudentHalfWidth95(degrees), quantile, 1e-6) << degrees;
    EXPECT_NEAR(StudentTwoSided(quantile, degrees), 0.05, 1e-7) << degrees;  // as far as six digits tell
  }
  EXPECT_NEAR(StudentHalfWidth95(100000), 1.959964, 1e-4);
}

TEST(DistributionsTest, AgreesWithTheSeriesForFractionalDegrees) {
  for (int degrees = 2; degrees < 200; ++degrees) {
    EXPECT_NEAR(StudentHalfWidth95(degrees), Student95(degrees), 1e-3) << degrees;
  }
}

TEST(DistributionsTest, StudentsTailIsTheIntegralOfItsDensity) {
  for (const int n : {1, 2, 5, 8}) {
    const double norm = std::tgamma(0.5 * (n + 1)) / (std::sqrt(n * 3.14159265358979) * std::tgamma(0.5 * n));
    double within = 0.0;
    constexpr int kSteps = 20000;
    for (int i = 0; i < kSteps; ++i) {
      const double t = 1.7 * (i + 0.5) / kSteps;
      within += 2.0 * 1.7 / kSteps * norm * std::pow(1.0 + t * t / n, -0.5 * (n + 1));
    }
    EXPECT_NEAR(StudentTwoSided(-1.7, n), 1.0 - within, 1e-8) << n;
  }
}

TEST(DistributionsTest, ChiSquareIsTheIntegralOfItsDensity) {
  for (const int n : {1, 2, 3, 4, 7, 12}) {
    // Over the square root of the value, where the density of one degree of freedom is finite.
    const double value = 5.3, norm = 2.0 / (std::pow(2.0, 0.5 * n) * std::tgamma(0.5 * n));
    double below = 0.0;
    constexpr int kSteps = 20000;
    for (int i = 0; i < kSteps; ++i) {
      const double root = std::sqrt(value) * (i + 0.5) / kSteps;
      below += std::sqrt(value) / kSteps * norm * std::pow(root, n - 1) * std::exp(-0.5 * root * root);
    }
    EXPECT_NEAR(ChiSquareAbove(value, n), 1.0 - below, 1e-7) << n;
  }
}

TEST(DistributionsTest, HasTheTabulatedQuantilesOfChiSquare) {
  EXPECT_NEAR(ChiSquareAbove(3.841459, 1), 0.05, 1e-7);
  EXPECT_NEAR(ChiSquareAbove(5.991465, 2), 0.05, 1e-7);
  EXPECT_NEAR(ChiSquareAbove(23.336664, 12), 0.025, 1e-7);
  EXPECT_NEAR(ChiSquareAbove(4.403789, 12), 0.975, 1e-7);
  EXPECT_EQ(ChiSquareAbove(0.0, 3), 1.0);
  EXPECT_EQ(ChiSquareAbove(1e5, 4), 0.0);
}

}  // namespace
}  // namespace clothid
