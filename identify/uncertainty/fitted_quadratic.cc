#include "identify/uncertainty/fitted_quadratic.h"

#include <cmath>

#include "sim/matrix/dense.h"

namespace clothid {
namespace {

// Below this share of the largest a diagonal entry of the triangular factor, or a second derivative, is rounding.
constexpr double kDependent = 1e-10;
constexpr double kClearRise = 0.5;  // of the roughness

// [k x coefficients]: 1, x_i, and x_i x_j with the factors of 1/2 x.H.x.
Eigen::MatrixXd Monomials(const Eigen::MatrixXd& points) {
  const Eigen::Index n = points.rows();
  Eigen::MatrixXd columns(points.cols(), NumQuadraticCoefficients(n));
  columns.col(0).setOnes();
  columns.middleCols(1, n) = points.transpose();
  Eigen::Index column = n + 1;
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = i; j < n; ++j) {
      columns.col(column++) = (i == j ? 0.5 : 1.0) * points.row(i).cwiseProduct(points.row(j)).transpose();
    }
  }
  return columns;
}

// From coefficients over x/reach.
void TakeCoefficients(const Eigen::VectorXd& coefficients, FittedQuadratic* quadratic) {
  const Eigen::Index n = quadratic->reach.size();
  quadratic->constant = coefficients[0];
  quadratic->gradient = coefficients.segment(1, n).cwiseQuotient(quadratic->reach);
  quadratic->hessian.resize(n, n);
  Eigen::Index next = n + 1;
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = i; j < n; ++j) {
      quadratic->hessian(i, j) = quadratic->hessian(j, i) =
          coefficients[next++] / (quadratic->reach[i] * quadratic->reach[j]);
    }
  }
}

// The second derivatives along the axes of H in units of the reach, ascending.
Eigen::VectorXd ScaledCurvatures(const FittedQuadratic& quadratic) {
  return SymmetricEigenvalues(quadratic.reach.asDiagonal() * quadratic.hessian * quadratic.reach.asDiagonal());
}

// The slope at x over the coefficients, in their order [n x coefficients].
Eigen::MatrixXd SlopeRows(const Eigen::VectorXd& x) {
  const Eigen::Index n = x.size();
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(n, NumQuadraticCoefficients(n));
  rows.middleCols(1, n).setIdentity();
  Eigen::Index column = n + 1;
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = i; j < n; ++j, ++column) {
      rows(i, column) = x[j];
      rows(j, column) = x[i];
    }
  }
  return rows;
}

}  // namespace

double FittedQuadratic::Value(const Eigen::VectorXd& x) const {
  return constant + gradient.dot(x) + 0.5 * x.dot(hessian * x);
}

double FittedQuadratic::least_curvature() const { return ScaledCurvatures(*this)[0]; }

bool FittedQuadratic::is_convex() const {
  const Eigen::VectorXd curvatures = ScaledCurvatures(*this);
  return curvatures[0] > kDependent * curvatures.cwiseAbs().maxCoeff() && 0.5 * curvatures[0] > kClearRise * roughness;
}

Eigen::VectorXd FittedQuadratic::Minimum() const { return -SymmetricFactor(hessian).SolveOne(gradient); }

Eigen::MatrixXd FittedQuadratic::MinimumCovariance() const {
  const Eigen::MatrixXd rows = SlopeRows(Minimum().cwiseQuotient(reach));
  const Eigen::MatrixXd slopes =
      roughness * factor.triangularView<Eigen::Upper>().transpose().solve(rows.transpose()).transpose();
  const Eigen::MatrixXd influence = SymmetricFactor(hessian).Solve(reach.cwiseInverse().asDiagonal() * slopes);
  return influence * influence.transpose();
}

std::optional<FittedQuadratic> FitQuadratic(const Eigen::MatrixXd& points, const Eigen::VectorXd& values) {
  const Eigen::Index k = points.cols(), num = NumQuadraticCoefficients(points.rows());
  if (k <= num) return std::nullopt;
  FittedQuadratic quadratic;
  quadratic.reach = points.cwiseAbs().rowwise().maxCoeff();
  if (!(quadratic.reach.array() > 0.0).all()) return std::nullopt;
  // [A y] = Q R: the last column of R has what is left of y below the coefficients. Relative to the mean, for a large
  // value that is everywhere the same would cost digits.
  const double mean = values.mean();
  Eigen::MatrixXd system(k, num + 1);
  system << Monomials(quadratic.reach.cwiseInverse().asDiagonal() * points), values.array() - mean;
  const Eigen::MatrixXd factor = UpperFactor(system);
  const Eigen::VectorXd diagonal = factor.diagonal().head(num).cwiseAbs();
  if (!(diagonal.minCoeff() > kDependent * diagonal.maxCoeff())) return std::nullopt;
  quadratic.factor = factor.topLeftCorner(num, num);
  TakeCoefficients(quadratic.factor.triangularView<Eigen::Upper>().solve(factor.col(num).head(num)).eval(), &quadratic);
  quadratic.constant += mean;
  const double left = std::abs(factor(num, num)), scatter = (values.array() - mean).matrix().norm();
  quadratic.explained = scatter > 0.0 ? 1.0 - std::pow(left / scatter, 2) : 0.0;
  quadratic.num_spare = static_cast<int>(k - num);
  quadratic.roughness = left / std::sqrt(static_cast<double>(quadratic.num_spare));
  return quadratic;
}

}  // namespace clothid
