// The forces that a sensor at the handles reads during a rollout.
#ifndef CLOTHID_DATASETS_SYNTHETIC_FORCE_SENSOR_H_
#define CLOTHID_DATASETS_SYNTHETIC_FORCE_SENSOR_H_

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "datasets/motion/force_readings.h"
#include "sim/rollout/rollout.h"
#include "sim/scene/scene.h"

namespace clothid {

struct ForceSensor {
  std::vector<std::vector<int>> groups;            // nodes, handles all; empty: all handles are one group
  double rate = 0.0;                               // Hz; 0: a reading per frame
  double sigma = 0.0;                              // N, standard deviation of Gaussian noise on every component
  Eigen::Vector3d bias = Eigen::Vector3d::Zero();  // N, of every group
};

// A sensor without noise says 1e-3 of its largest force for its sigma.
inline constexpr double kNoiselessForceSigma = 1e-3;

// What the sensor reads of `rollout`, which must be ok() and come from `scene`; between steps forces are interpolated
// linearly. `steps` [F]: the times of the readings after the start, in steps (`FrameSteps`). Throws `Error`: kUsage for
// a sensor out of range and a scene without handles, kBadData for groups that are no handles.
ForceReadings ReadForceSensor(const ForceSensor& sensor, const Rollout& rollout, const Scene& scene,
                              const Eigen::VectorXd& steps, std::uint64_t seed);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_SYNTHETIC_FORCE_SENSOR_H_
