// Findings about point clouds against the cloth of the scene.
#ifndef CLOTHID_DATASETS_CHECKING_CHECK_CLOUDS_H_
#define CLOTHID_DATASETS_CHECKING_CHECK_CLOUDS_H_

#include <vector>

#include "datasets/checking/checked_motion.h"
#include "datasets/checking/finding.h"

namespace clothid {

// Places that many of their points have to the last bit; their size, their place at the first frame, their distance
// from the handles. Empty without clouds.
std::vector<Finding> CheckClouds(const CheckedMotion& checked);
// The first of these. Rounded coordinates, and points at rest, are no such places.
std::vector<Finding> CheckRepeatedPlacesOfClouds(const CheckedMotion& checked);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_CHECKING_CHECK_CLOUDS_H_
