// Findings about the first frame, where the simulated cloth starts, against the scene and the frames after it.
#ifndef CLOTHID_DATASETS_CHECKING_CHECK_START_H_
#define CLOTHID_DATASETS_CHECKING_CHECK_START_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "datasets/checking/checked_motion.h"
#include "datasets/checking/finding.h"

namespace clothid {

// Where the scene puts the cloth at the first frame, and where it was measured; points that are off in that frame; the
// start velocity, where it is wrong.
std::vector<Finding> CheckFirstFrame(const CheckedMotion& checked);

// How else the points of a frame would have to be given to stand where they are expected: along other axes, in another
// order of their grid, shifted or turned. Empty where none of these brings them three times nearer. expected, measured
// [3 x P] m (NaN: not seen), `orders` of `GridOrders`.
std::string Explanation(const Eigen::Matrix3Xd& expected, const Eigen::Matrix3Xd& measured,
                        const std::vector<std::vector<int>>& orders);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_CHECKING_CHECK_START_H_
