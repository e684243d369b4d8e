// A small rigid motion of points,  p' = R(w) (p - c) + c + s,  and its derivatives.
// R(w) and its derivative: sim/path/rotation_vector.h.
#ifndef CLOTHID_COSTS_PREDICTION_RIGID_CORRECTION_H_
#define CLOTHID_COSTS_PREDICTION_RIGID_CORRECTION_H_

#include <Eigen/Core>

namespace clothid {

class RigidCorrection {
 public:
  // turn: w, rad; shift: s, m; center: c, m.
  RigidCorrection(const Eigen::Vector3d& turn, const Eigen::Vector3d& shift, const Eigen::Vector3d& center);

  const Eigen::Matrix3d& rotation() const { return rotation_; }
  // Of no turn and no shift: what follows changes nothing, and need not be called.
  bool is_identity() const { return is_identity_; }
  // Every point of the column `points` [3P], m.
  Eigen::VectorXd Apply(const Eigen::VectorXd& points) const;
  // What a change of the points becomes, R d, and its transpose: columns of [3P x c].
  Eigen::MatrixXd Rotate(const Eigen::MatrixXd& changes) const;
  Eigen::MatrixXd RotateBack(const Eigen::MatrixXd& changes) const;
  // d p'/dw_axis [3P] of points that were corrected, `corrected` = p' [3P].
  Eigen::VectorXd TurnDerivative(int axis, const Eigen::VectorXd& corrected) const;

 private:
  bool is_identity_;
  Eigen::Matrix3d rotation_, left_jacobian_;
  Eigen::Vector3d center_, corrected_center_;  // c, c + s
};

}  // namespace clothid

#endif  // CLOTHID_COSTS_PREDICTION_RIGID_CORRECTION_H_
