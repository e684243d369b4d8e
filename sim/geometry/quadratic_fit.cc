#include "sim/geometry/quadratic_fit.h"

#include <algorithm>
#include <cmath>

namespace clothid {
namespace {

constexpr double kUndetermined = 0.02;  // of `quality`, of one derivative: less is none

// Columns that span those of `a`, by Gram and Schmidt.
Eigen::MatrixX3d Orthonormalized(Eigen::MatrixX3d a) {
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < i; ++k) a.col(i) -= a.col(k).dot(a.col(i)) * a.col(k);
    a.col(i).normalize();
  }
  return a;
}

}  // namespace

QuadraticFit::QuadraticFit(const Eigen::Matrix2Xd& points) {
  const Eigen::Vector2d mean = points.rowwise().mean();
  const Eigen::Matrix2Xd p = points.colwise() - mean;
  to_unit_ = InverseSquareRoot(p * p.transpose() / static_cast<double>(p.cols()));
  const Eigen::Matrix2Xd q = to_unit_ * p;
  root_weights_ = ((to_unit_ * points).colwise().squaredNorm().array() + 1.0).inverse();
  const Eigen::ArrayXd q1 = q.row(0), q2 = q.row(1);
  Eigen::MatrixX3d affine(q.cols(), 3), quadratic(q.cols(), 3);
  affine << root_weights_, root_weights_ * q1, root_weights_ * q2;
  quadratic << root_weights_ * q1.square() / 2.0, root_weights_ * q2.square() / 2.0,
      root_weights_ * q1 * q2 / std::sqrt(2.0);
  scale_ = quadratic.squaredNorm();
  quadratic /= std::sqrt(scale_);
  // Twice: once leaves the rounding of what cancels.
  const Eigen::MatrixX3d basis = Orthonormalized(Orthonormalized(affine));
  beyond_affine_ = quadratic - basis * (basis.transpose() * quadratic);
  gram_ = SymmetricSpectrum(Eigen::Matrix3d(beyond_affine_.transpose() * beyond_affine_));
}

double QuadraticFit::quality() const { return std::sqrt(std::max(0.0, gram_.values[0])); }

Eigen::Matrix3Xd QuadraticFit::Weights() const {
  Eigen::Vector3d inverse = Eigen::Vector3d::Zero();
  for (int i = 0; i < 3; ++i) {
    const double value = gram_.values[i];
    if (value > kUndetermined * kUndetermined) inverse[i] = 1.0 / (value * std::sqrt(scale_));
  }
  Eigen::Matrix3Xd in_unit = gram_.vectors * inverse.asDiagonal() * gram_.vectors.transpose() *
                             beyond_affine_.transpose() * root_weights_.matrix().asDiagonal();
  in_unit.row(2) /= std::sqrt(2.0);
  return FromUnit() * in_unit;
}

// H_p = B^T H_q B, of (11, 22, 12).
Eigen::Matrix3d QuadraticFit::FromUnit() const {
  const double a = to_unit_(0, 0), b = to_unit_(0, 1), c = to_unit_(1, 0), d = to_unit_(1, 1);
  return Eigen::Matrix3d{{a * a, c * c, 2.0 * a * c}, {b * b, d * d, 2.0 * b * d}, {a * b, c * d, a * d + b * c}};
}

}  // namespace clothid
