// Findings about the measured points alone: noise, order, jumps.
#ifndef CLOTHID_DATASETS_CHECKING_CHECK_POINTS_H_
#define CLOTHID_DATASETS_CHECKING_CHECK_POINTS_H_

#include <vector>

#include "datasets/checking/checked_motion.h"
#include "datasets/checking/finding.h"

namespace clothid {

Finding CheckNoise(const CheckedMotion& checked);
Finding CheckOrder(const CheckedMotion& checked);
// Of the cloth and of points. `left_out`: frames that are known to be wrong.
std::vector<Finding> CheckJumps(const CheckedMotion& checked, const std::vector<int>& left_out);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_CHECKING_CHECK_POINTS_H_
