// Rotations by their vectors: the axis times the angle in rad.
#ifndef CLOTHID_SIM_PATH_ROTATION_VECTOR_H_
#define CLOTHID_SIM_PATH_ROTATION_VECTOR_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

namespace clothid {

// [v]x, with [v]x y = v x y.
inline Eigen::Matrix3d CrossMatrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d matrix;
  matrix << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return matrix;
}

inline Eigen::Quaterniond ExponentialOf(const Eigen::Vector3d& vector) {
  const double half = 0.5 * vector.norm();
  const double share = half < 1e-4 ? 0.5 * (1.0 - half * half / 6.0) : 0.5 * std::sin(half) / half;
  Eigen::Quaterniond result;
  result.w() = std::cos(half);
  result.vec() = share * vector;
  return result;
}

// Of length at most pi.
inline Eigen::Vector3d LogarithmOf(const Eigen::Quaterniond& rotation) {
  const double sign = rotation.w() < 0.0 ? -1.0 : 1.0;
  const double sine = rotation.vec().norm(), cosine = sign * rotation.w();
  const double factor = sine < 1e-8 ? 2.0 / cosine : 2.0 * std::atan2(sine, cosine) / sine;
  return sign * factor * rotation.vec();
}

// J with d exp(v) = [J dv]x exp(v): the left Jacobian, I + (1 - cos a)/a^2 [v]x + (a - sin a)/a^3 [v]x^2, a = |v|.
inline Eigen::Matrix3d LeftJacobian(const Eigen::Vector3d& vector) {
  const double angle = vector.norm();
  const Eigen::Matrix3d cross = CrossMatrix(vector);
  if (angle < 1e-4) return Eigen::Matrix3d::Identity() + 0.5 * cross + cross * cross / 6.0;
  const double square = angle * angle, half_sine = std::sin(0.5 * angle);
  return Eigen::Matrix3d::Identity() + 2.0 * half_sine * half_sine / square * cross +
         (angle - std::sin(angle)) / (square * angle) * cross * cross;
}

}  // namespace clothid

#endif  // CLOTHID_SIM_PATH_ROTATION_VECTOR_H_
