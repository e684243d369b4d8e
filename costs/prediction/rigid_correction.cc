#include "costs/prediction/rigid_correction.h"

#include <Eigen/Geometry>

#include "sim/path/rotation_vector.h"

namespace clothid {
namespace {

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
  const RotationByVector by_vector(turn);
  rotation_ = by_vector.rotation;
  left_jacobian_ = by_vector.left_jacobian;
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
