// Findings about the times of a recording, and about which points were seen at them.
#ifndef CLOTHID_DATASETS_CHECKING_CHECK_COVERAGE_H_
#define CLOTHID_DATASETS_CHECKING_CHECK_COVERAGE_H_

#include <vector>

#include "datasets/checking/checked_motion.h"
#include "datasets/checking/finding.h"

namespace clothid {

// Frame rate, gaps, missing points.
std::vector<Finding> CheckCoverage(const CheckedMotion& checked);
// All that can be said of clouds without tracked points: frame rate, gaps, time step.
std::vector<Finding> CheckTimes(const CheckedMotion& checked);
// The time step of the scene against the frame rate.
Finding CheckTimeStep(const CheckedMotion& checked);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_CHECKING_CHECK_COVERAGE_H_
