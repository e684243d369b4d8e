// Findings about the obstacles and the gravity of the scene against the points.
#ifndef CLOTHID_DATASETS_CHECKING_CHECK_SCENE_H_
#define CLOTHID_DATASETS_CHECKING_CHECK_SCENE_H_

#include <vector>

#include "datasets/checking/checked_motion.h"
#include "datasets/checking/finding.h"

namespace clothid {

// The start and contact; `touches` is set where any point touches an obstacle, else left as it is.
std::vector<Finding> CheckContact(const CheckedMotion& checked, bool* touches);
// Where nothing is touched; may have nothing to say.
std::vector<Finding> CheckGravity(const CheckedMotion& checked);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_CHECKING_CHECK_SCENE_H_
