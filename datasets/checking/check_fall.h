// Findings about gravity and the clock, from how the cloth falls: what nothing but gravity moves cannot gain energy,
// and what nothing holds falls with gravity.
//
// Energy: with handles and obstacles at rest, without wind, kinetic energy and that of gravity together never rise
// above those of the start, but for what was stored in a stretched cloth. Per mass, with x the mean over the points:
//   1/2 |dx/dt|^2 - g . (x - x_0) <= 1/2 mean |v_0|^2.
// Fall: as long as nothing is touched, the mean of the points accelerates by g and a pull towards the handles h. So
// across h - x it accelerates by gravity alone, or somewhat less in air. Without handles no point stays where it is.
// Swing: a cloth of length l that hangs from handles swings in about 5.2 sqrt(l/g), a rigid plate in 5.13, a chain in
// 5.22. Times that are wrong by a factor s make all accelerations wrong by 1/s^2, and the period by s.
#ifndef CLOTHID_DATASETS_CHECKING_CHECK_FALL_H_
#define CLOTHID_DATASETS_CHECKING_CHECK_FALL_H_

#include <vector>

#include "datasets/checking/checked_motion.h"
#include "datasets/checking/finding.h"

namespace clothid {

// Empty where handles move, air or other forces do work, or the points are too few to tell. `num_free` counts the
// frames from the first one in which nothing touches an obstacle.
std::vector<Finding> CheckFall(const CheckedMotion& checked, int num_free);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_CHECKING_CHECK_FALL_H_
