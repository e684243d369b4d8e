// The prescribed motion of a rigid body: C1 curves through poses given at increasing times.
#ifndef CLOTHID_SIM_PATH_RIGID_PATH_H_
#define CLOTHID_SIM_PATH_RIGID_PATH_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

namespace clothid {

// x = A p, p in m and axes of the body, x in m and world axes: A = [L | a], L p + a.
using AffineMap = Eigen::Matrix<double, 3, 4>;

inline Eigen::Vector3d Apply(const AffineMap& map, const Eigen::Vector3d& point) {
  return map.leftCols<3>() * point + map.col(3);
}

// A pose and how it changes: A, dA/dt and d2A/dt2.
struct PoseJet {
  AffineMap pose = AffineMap::Identity();
  AffineMap rate = AffineMap::Zero();          // 1/s and m/s
  AffineMap acceleration = AffineMap::Zero();  // 1/s^2 and m/s^2
};

// Positions follow cubics whose slopes are those of a parabola through a pose and its neighbours, as those of handles
// do (handle_path.h). Rotations follow q_i E(w_1 b_1) E(w_2 b_2) E(w_3 b_3) between two poses, E the exponential, with
// the cubics b_1 = 1 - (1 - s)^3, b_2 = s^2 (3 - 2 s), b_3 = s^3 and the angular velocities at both ends in w_1 and
// w_3 (Kim, Kim and Shin, "A general construction scheme for unit quaternion curves with simple high order
// derivatives", 1995): slerp where the rate of turning is constant, and without its jumps where it is not. Before the
// first and after the last pose the body stands still.
class RigidPath {
 public:
  // times [T] s, strictly increasing; positions [3 x T] m of the body's origin; rotations [4 x T] quaternions x, y, z,
  // w from the body's axes to the world's, of a length within 1 % of 1; q and -q are the same. Throws `Error`
  // (kBadData), naming the row from 0 on, for values that are none, and for a path that jumps: more than kMostPathTurn
  // from row to row, or kMostPathSpeed.
  RigidPath(const Eigen::VectorXd& times, const Eigen::Matrix3Xd& positions, const Eigen::Matrix4Xd& rotations);

  const Eigen::VectorXd& times() const { return times_; }
  const Eigen::MatrixXd& positions() const { return positions_; }
  const Eigen::Matrix4Xd& rotations() const { return rotations_; }  // of length 1, none turned over from the one before

  // Derivatives from the right where they jump.
  PoseJet At(double time) const;

 private:
  void SetRotationAt(double time, PoseJet* jet) const;
  Eigen::Quaterniond Rotation(Eigen::Index i) const { return Eigen::Quaterniond(Eigen::Vector4d(rotations_.col(i))); }

  Eigen::VectorXd times_;
  Eigen::MatrixXd positions_;        // [3 x T]
  Eigen::MatrixXd slopes_;           // [3 x T] m/s
  Eigen::Matrix4Xd rotations_;       // [4 x T]
  Eigen::Matrix3Xd angular_slopes_;  // [3 x T] rad/s, in axes of the body
};

inline constexpr double kMostPathTurn = 1.6;    // rad
inline constexpr double kMostPathSpeed = 50.0;  // m/s

}  // namespace clothid

#endif  // CLOTHID_SIM_PATH_RIGID_PATH_H_
