// Findings about point clouds against the cloth of the scene.
#ifndef CLOTHID_DATASETS_CHECKING_CHECK_CLOUDS_H_
#define CLOTHID_DATASETS_CHECKING_CHECK_CLOUDS_H_

#include <vector>

#include "datasets/checking/checked_motion.h"
#include "datasets/checking/finding.h"

namespace clothid {

// Their size, their place at the first frame, their distance from the handles. Empty without clouds.
std::vector<Finding> CheckClouds(const CheckedMotion& checked);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_CHECKING_CHECK_CLOUDS_H_
