// A rotation for tests, without the singular values that Eigen's `FromTwoVectors` takes seconds to compile for.
#ifndef CLOTHID_TESTS_SIM_TURN_FROM_Z_H_
#define CLOTHID_TESTS_SIM_TURN_FROM_Z_H_

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace clothid {

// The smallest turn that takes the z axis to `direction`, which is not that of -z.
inline Eigen::Quaterniond TurnFromZ(const Eigen::Vector3d& direction) {
  const Eigen::Vector3d n = direction.normalized();
  return Eigen::Quaterniond(1.0 + n.z(), -n.y(), n.x(), 0.0).normalized();
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_SIM_TURN_FROM_Z_H_
