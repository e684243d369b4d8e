// Findings about the handles of the scene against the points that are measured there.
#ifndef CLOTHID_DATASETS_CHECKING_CHECK_HANDLES_H_
#define CLOTHID_DATASETS_CHECKING_CHECK_HANDLES_H_

#include <vector>

#include "datasets/checking/checked_motion.h"
#include "datasets/checking/finding.h"

namespace clothid {

// Empty without handles.
std::vector<Finding> CheckHandles(const CheckedMotion& checked);

// How many forces at handles were measured, readings outside of the frames, components that do not change, a sign that
// is that of the force on the gripper, and an offset from the weight that the handles bear. None without forces.
std::vector<Finding> CheckForces(const CheckedMotion& checked);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_CHECKING_CHECK_HANDLES_H_
