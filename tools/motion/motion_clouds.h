// What `motion` says of the clouds in a recording.
#ifndef CLOTHID_TOOLS_MOTION_MOTION_CLOUDS_H_
#define CLOTHID_TOOLS_MOTION_MOTION_CLOUDS_H_

#include "datasets/motion/recorded_motion.h"

namespace clothid {

// One line on stdout about how many points there are; nothing where the recording has no clouds.
void PrintClouds(const RecordedMotion& motion);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_MOTION_MOTION_CLOUDS_H_
