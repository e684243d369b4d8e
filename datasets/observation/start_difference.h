// How far the start of a rollout is from what was seen in the first frame.
//
// A scene may say where the cloth starts. Where the first frame is at that time and shows the cloth elsewhere, scene
// and recording do not belong together: another frame of reference, another unit, another order of the nodes. A fit
// hides that in its parameters.
#ifndef CLOTHID_DATASETS_OBSERVATION_START_DIFFERENCE_H_
#define CLOTHID_DATASETS_OBSERVATION_START_DIFFERENCE_H_

#include <Eigen/Core>
#include <limits>
#include <optional>

#include "datasets/motion/recorded_motion.h"

namespace clothid {

struct StartDifference {
  double rms = 0.0;  // m, root mean square distance of the points seen in the first frame; all axes of a point count
  double noise = std::numeric_limits<double>::quiet_NaN();  // m, what sigma alone makes of it; NaN: not known
  double cloth_size = 0.0;                                  // m

  // More than noise, and more than 2 % of the cloth's size: no noise, nor a cloth that is not quite at rest.
  bool is_noticeable() const;
  // More than 10 % of the cloth's size besides: the rollout starts as another cloth than the recorded one.
  bool is_large() const;
};

// Between the start of the scene and the first frame. Absent where there is nothing to compare: the start was taken
// from the first frames, the first frame is not at the start (within half a time step), or it shows no tracked point.
std::optional<StartDifference> DifferenceAtStart(const RecordedMotion& motion);
// The same for the positions [3P, or more rows] m that a fit predicts at the first frame, which may be corrected for a
// frame of reference.
std::optional<StartDifference> DifferenceAtStart(const RecordedMotion& motion, const Eigen::VectorXd& predicted);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_OBSERVATION_START_DIFFERENCE_H_
