// Point clouds as points that have a place each, for pictures of a recording.
#ifndef CLOTHID_IDENTIFY_REPORT_CLOUD_POINTS_H_
#define CLOTHID_IDENTIFY_REPORT_CLOUD_POINTS_H_

#include <Eigen/Core>

#include "datasets/motion/recorded_motion.h"
#include "datasets/observation/observation.h"

namespace clothid {

// `motion` without clouds, the points of which come after its P tracked ones: point j of every frame's cloud is point
// P + j, not seen in frames with fewer. They are observed as if they were some free node: which one says nothing. All
// points are material.
RecordedMotion CloudsAsPoints(const RecordedMotion& motion);

// The prediction [R x T] of a recording with clouds for `CloudsAsPoints` [3(P + C) x T], C the points of its largest
// cloud: what a point of a cloud, or one that is not material, is compared with is the nearest point of the predicted
// surface. NaN where there is none.
Eigen::MatrixXd ClosestPoints(const Observation& observation, const Eigen::MatrixXd& predicted);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_REPORT_CLOUD_POINTS_H_
