// Rotations by their vectors: the axis times the angle in rad.
//
// R(w) = exp([w]x) = I + sin(a)/a [w]x + (1 - cos(a))/a^2 [w]x^2,  a = |w|  (Rodrigues), [w]x y = w x y.
// Its derivative is that of the left Jacobian of the rotations,
//   J(w) = I + (1 - cos(a))/a^2 [w]x + (a - sin(a))/a^3 [w]x^2,   d(R(w) y)/dw = -[R(w) y]x J(w),
// smooth at w = 0, where R = J = I.
#ifndef CLOTHID_SIM_PATH_ROTATION_VECTOR_H_
#define CLOTHID_SIM_PATH_ROTATION_VECTOR_H_

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace clothid {

// [v]x.
Eigen::Matrix3d CrossMatrix(const Eigen::Vector3d& v);

struct RotationByVector {
  Eigen::Matrix3d rotation, left_jacobian;  // R and J

  explicit RotationByVector(const Eigen::Vector3d& vector);
};

// The same as a quaternion, and its inverse, of a length of at most pi.
inline Eigen::Quaterniond ExponentialOf(const Eigen::Vector3d& vector) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(vector.norm(), vector.normalized()));
}
inline Eigen::Vector3d LogarithmOf(const Eigen::Quaterniond& rotation) {
  const Eigen::AngleAxisd turn(rotation);
  return turn.angle() * turn.axis();
}

}  // namespace clothid

#endif  // CLOTHID_SIM_PATH_ROTATION_VECTOR_H_
