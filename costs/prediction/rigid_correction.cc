#include "costs/prediction/rigid_correction.h"

#include <Eigen/Geometry>
#include <cmath>

namespace clothid {
namespace {

// Below this angle the series of the coefficients are exact to rounding, which their closed forms are not.
constexpr double kSmallAngle = 1e-2;

// sin(a)/a, (1 - cos(a))/a^2 and (a - sin(a))/a^3.
struct Coefficients {
  double first = 1.0, second = 0.5, third = 1.0 / 6.0;
};

Coefficients CoefficientsOf(double angle) {
  const double square = angle * angle;
  if (angle < kSmallAngle) {
    return {1.0 - square / 6.0 * (1.0 - square / 20.0), 0.5 - square / 24.0 * (1.0 - square / 30.0),
            1.0 / 6.0 - square / 120.0 * (1.0 - square / 42.0)};
  }
  const double half_sine = std::sin(0.5 * angle);
  return {std::sin(angle) / angle, 2.0 * half_sine * half_sine / square, (angle - std::sin(angle)) / (angle * square)};
}

Eigen::Matrix3d CrossMatrix(const Eigen::Vector3d& w) {
  Eigen::Matrix3d cross;
  cross << 0.0, -w[2], w[1], w[2], 0.0, -w[0], -w[1], w[0], 0.0;
  return cross;
}

// matrix [3 x 3] times every point of every column of [3P x c].
Eigen::MatrixXd TimesPoints(const Eigen::Matrix3d& matrix, const Eigen::MatrixXd& points) {
  Eigen::MatrixXd product(points.rows(), points.cols());
  for (Eigen::Index row = 0; row < points.rows(); row += 3) {
    product.middleRows<3>(row).noalias() = matrix * points.middleRows<3>(row);
  }
  return product;
}

}  // namespace

RigidCorrection::RigidCorrection(const Eigen::Vector3d& turn, const Eigen::Vector3d& shift,
                                 const Eigen::Vector3d& center)
    : is_identity_(turn.isZero(0.0) && shift.isZero(0.0)), center_(center), corrected_center_(center + shift) {
  const Coefficients coefficients = CoefficientsOf(turn.norm());
  const Eigen::Matrix3d cross = CrossMatrix(turn), square = cross * cross, identity = Eigen::Matrix3d::Identity();
  rotation_ = identity + coefficients.first * cross + coefficients.second * square;
  left_jacobian_ = identity + coefficients.second * cross + coefficients.third * square;
}

Eigen::VectorXd RigidCorrection::Apply(const Eigen::VectorXd& points) const {
  Eigen::VectorXd corrected(points.size());
  for (Eigen::Index row = 0; row < points.size(); row += 3) {
    corrected.segment<3>(row) = rotation_ * (points.segment<3>(row) - center_) + corrected_center_;
  }
  return corrected;
}

Eigen::MatrixXd RigidCorrection::Rotate(const Eigen::MatrixXd& changes) const {
  return TimesPoints(rotation_, changes);
}

Eigen::MatrixXd RigidCorrection::RotateBack(const Eigen::MatrixXd& changes) const {
  return TimesPoints(rotation_.transpose(), changes);
}

Eigen::VectorXd RigidCorrection::TurnDerivative(int axis, const Eigen::VectorXd& corrected) const {
  const Eigen::Vector3d direction = left_jacobian_.col(axis);
  Eigen::VectorXd derivative(corrected.size());
  for (Eigen::Index row = 0; row < corrected.size(); row += 3) {
    derivative.segment<3>(row) = direction.cross(Eigen::Vector3d(corrected.segment<3>(row) - corrected_center_));
  }
  return derivative;
}

}  // namespace clothid
