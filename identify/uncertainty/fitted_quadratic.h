// A function seen at points as a quadratic, by least squares:
//   f(x) ~ c + g.x + 1/2 x.H.x.
// What is rougher than the distances between the points stays in the residuals.
#ifndef CLOTHID_IDENTIFY_UNCERTAINTY_FITTED_QUADRATIC_H_
#define CLOTHID_IDENTIFY_UNCERTAINTY_FITTED_QUADRATIC_H_

#include <Eigen/Core>
#include <optional>

namespace clothid {

struct FittedQuadratic {
  double constant = 0.0;     // c
  Eigen::VectorXd gradient;  // g [n]
  Eigen::MatrixXd hessian;   // H [n x n]
  double explained = 0.0;    // the share of the scatter of the values, as squares, that it explains: R^2
  double roughness = 0.0;    // the standard deviation of the values about it
  int num_spare = 0;         // values beyond the number of coefficients
  Eigen::VectorXd reach;     // [n] the largest |x_i| of the points
  Eigen::MatrixXd factor;    // R of the monomials of x/reach at the points: 1, x_i, x_i x_j

  double Value(const Eigen::VectorXd& x) const;
  // The least second derivative in any direction, in units of the reach.
  double least_curvature() const;
  // Whether it rises by more than half the roughness from its minimum to the reach, in every direction: about the error
  // of that rise itself.
  bool is_convex() const;
  Eigen::VectorXd Minimum() const;  // [n] of one that is convex
  // [n x n] how sure its place is: the covariance as values scatter about the quadratic, H^-1 Cov(slope there) H^-1.
  Eigen::MatrixXd MinimumCovariance() const;
};

// Its number of coefficients.
constexpr Eigen::Index NumQuadraticCoefficients(Eigen::Index n) { return (n + 1) * (n + 2) / 2; }

// `points` [n x k], a column each, and the values there [k]. Absent where there are no more points than coefficients,
// or they do not determine these.
std::optional<FittedQuadratic> FitQuadratic(const Eigen::MatrixXd& points, const Eigen::VectorXd& values);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_UNCERTAINTY_FITTED_QUADRATIC_H_
