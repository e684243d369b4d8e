// Paths of moving obstacles for tests.
#ifndef CLOTHID_TESTS_SIM_MOVING_PATHS_H_
#define CLOTHID_TESTS_SIM_MOVING_PATHS_H_

#include <Eigen/Core>
#include <memory>

#include "sim/path/rigid_path.h"
#include "sim/path/rotation_vector.h"

namespace clothid {

// Through `place(t)` m and with the rotation vector `turn(t)` rad at `count` times from `begin` to `end`, s.
template <typename Place, typename Turn>
std::shared_ptr<const RigidPath> PathThrough(double begin, double end, int count, const Place& place,
                                             const Turn& turn) {
  const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(count, begin, end);
  Eigen::Matrix3Xd positions(3, count);
  Eigen::Matrix4Xd rotations(4, count);
  for (int i = 0; i < count; ++i) {
    positions.col(i) = place(times[i]);
    rotations.col(i) = ExponentialOf(turn(times[i])).coeffs();
  }
  return std::make_shared<RigidPath>(times, positions, rotations);
}

inline Eigen::Vector3d NoTurn(double) { return Eigen::Vector3d::Zero(); }
inline Eigen::Vector3d NoShift(double) { return Eigen::Vector3d::Zero(); }

}  // namespace clothid

#endif  // CLOTHID_TESTS_SIM_MOVING_PATHS_H_
