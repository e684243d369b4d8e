// Quadratics by least squares: exact ones, rough ones, and what is none.
#include "identify/uncertainty/fitted_quadratic.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

namespace clothid::fitted_quadratic_test {
namespace {

using Function = std::function<double(const Eigen::Vector2d&)>;

// 3 x 3 points about the origin.
Eigen::MatrixXd Points(double distance) {
  Eigen::MatrixXd points(2, 9);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) points.col(3 * i + j) = distance * Eigen::Vector2d(i - 1, j - 1);
  }
  return points;
}

std::optional<FittedQuadratic> FitTo(const Function& function, double distance) {
  const Eigen::MatrixXd points = Points(distance);
  Eigen::VectorXd values(points.cols());
  for (Eigen::Index k = 0; k < values.size(); ++k) values[k] = function(points.col(k));
  return FitQuadratic(points, values);
}

const Eigen::Vector2d kMinimum(0.02, -0.01);

Eigen::Matrix2d Hessian() {
  Eigen::Matrix2d hessian;
  hessian << 3.0, 1.0, 1.0, 50.0;
  return hessian;
}

double Smooth(const Eigen::Vector2d& x) {
  const Eigen::Vector2d offset = x - kMinimum;
  return 7000.0 + 0.5 * offset.dot(Hessian() * offset);
}

// Kinks 0.01 apart, a rise of 0.004 each: between them the slope is that of the teeth.
double Rough(const Eigen::Vector2d& x) {
  const auto tooth = [](double u) { return 0.4 * std::abs(u - 0.01 * std::round(u / 0.01)); };
  return Smooth(x) + tooth(x[0] + 0.0031) + tooth(0.7 * x[1] + 0.3 * x[0]);
}

TEST(FittedQuadraticTest, FindsAnExactOneToRounding) {
  const auto quadratic = FitTo(Smooth, 0.1);
  ASSERT_TRUE(quadratic.has_value());
  EXPECT_LT((quadratic->hessian - Hessian()).norm(), 1e-8 * Hessian().norm());
  EXPECT_LT((quadratic->Minimum() - kMinimum).norm(), 1e-10);
  EXPECT_NEAR(quadratic->constant, Smooth(Eigen::Vector2d::Zero()), 1e-10);
  EXPECT_NEAR(quadratic->Value(Eigen::Vector2d(0.3, -0.7)), Smooth(Eigen::Vector2d(0.3, -0.7)), 1e-9);
  EXPECT_EQ(quadratic->num_spare, 3);
  EXPECT_NEAR(quadratic->explained, 1.0, 1e-12);
  EXPECT_LT(quadratic->roughness, 1e-10);
  EXPECT_TRUE(quadratic->is_convex());
  EXPECT_LT(quadratic->MinimumCovariance().norm(), 1e-20);
}

// The scatter of the minimum over many draws of noise is what one of them says.
TEST(FittedQuadraticTest, KnowsHowSureItsMinimumIs) {
  std::mt19937_64 generator(3);
  std::normal_distribution<double> noise(0.0, 2e-4);
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero(), told = Eigen::Matrix2d::Zero();
  constexpr int kDraws = 2000;
  for (int draw = 0; draw < kDraws; ++draw) {
    const auto quadratic = FitTo([&](const Eigen::Vector2d& x) { return Smooth(x) + noise(generator); }, 0.1);
    const Eigen::Vector2d off = quadratic->Minimum() - kMinimum;
    scatter += off * off.transpose() / kDraws;
    told += quadratic->MinimumCovariance() / kDraws;
  }
  EXPECT_NEAR(told(0, 0), scatter(0, 0), 0.15 * scatter(0, 0));
  EXPECT_NEAR(told(1, 1), scatter(1, 1), 0.15 * scatter(1, 1));
  EXPECT_NEAR(told(0, 1), scatter(0, 1), 0.15 * std::sqrt(scatter(0, 0) * scatter(1, 1)));
}

// Of x^3 at -1, 0, 1 over three values of another coordinate the least squares leave nothing (x^3 = x there), of
// x^2 y^2 they leave 4/9, 4/9 times 4 and -2/9 times 4: a quarter of its scatter of 20/9.
TEST(FittedQuadraticTest, ExplainsAShare) {
  const auto cubic = FitTo([](const Eigen::Vector2d& x) { return std::pow(x[0], 3); }, 1.0);
  EXPECT_NEAR(cubic->explained, 1.0, 1e-12);
  const auto quartic = FitTo([](const Eigen::Vector2d& x) { return std::pow(x[0] * x[1], 2); }, 1.0);
  EXPECT_NEAR(quartic->explained, 0.8, 1e-12);
  EXPECT_NEAR(quartic->roughness, std::sqrt(4.0 / 9.0 / 3.0), 1e-12);
}

TEST(FittedQuadraticTest, SeesThroughKinksFromFarEnough) {
  const auto near = FitTo(Rough, 0.003), far = FitTo(Rough, 0.3);
  ASSERT_TRUE(near.has_value() && far.has_value());
  EXPECT_FALSE(near->is_convex() && near->explained >= 0.9);
  ASSERT_TRUE(far->is_convex());
  EXPECT_GT(far->explained, 0.99);
  EXPECT_LT((far->Minimum() - kMinimum).norm(), 0.02);
  EXPECT_LT((far->hessian - Hessian()).norm(), 0.1 * Hessian().norm());
}

TEST(FittedQuadraticTest, IsNotConvexWhereItFallsOrIsFlat) {
  EXPECT_FALSE(FitTo([](const Eigen::Vector2d& x) { return x[0] * x[0] - x[1] * x[1]; }, 1.0)->is_convex());
  EXPECT_FALSE(FitTo([](const Eigen::Vector2d& x) { return x[0] * x[0]; }, 1.0)->is_convex());
}

// (x^2 - 2/3)(y^2 - 2/3) is what no quadratic explains of the nine points: a roughness of 2/sqrt(27) of its factor.
TEST(FittedQuadraticTest, IsNotConvexWhereItHardlyRises) {
  const auto with_roughness = [](double factor) {
    return FitTo(
        [&](const Eigen::Vector2d& x) {
          return x[0] * x[0] + 0.05 * x[1] * x[1] + factor * (x[0] * x[0] - 2.0 / 3.0) * (x[1] * x[1] - 2.0 / 3.0);
        },
        1.0);
  };
  EXPECT_NEAR(with_roughness(0.2)->roughness, 0.2 * 2.0 / std::sqrt(27.0), 1e-12);
  EXPECT_NEAR(with_roughness(0.4)->least_curvature(), 0.1, 1e-12);
  EXPECT_TRUE(with_roughness(0.2)->is_convex());
  EXPECT_FALSE(with_roughness(0.4)->is_convex());
}

TEST(FittedQuadraticTest, NeedsMorePointsThanCoefficients) {
  const Eigen::MatrixXd points = Points(1.0);
  const Eigen::VectorXd values = points.colwise().squaredNorm();
  EXPECT_TRUE(FitQuadratic(points.leftCols(7), values.head(7)).has_value());
  EXPECT_FALSE(FitQuadratic(points.leftCols(6), values.head(6)).has_value());
  // On a line through the origin.
  Eigen::MatrixXd line = points;
  line.row(1) = line.row(0);
  EXPECT_FALSE(FitQuadratic(line, values).has_value());
}

}  // namespace
}  // namespace clothid::fitted_quadratic_test
