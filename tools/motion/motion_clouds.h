// motion convert_clouds: a recording from a folder of point clouds; and what motion says of the clouds in one.
#ifndef CLOTHID_TOOLS_MOTION_MOTION_CLOUDS_H_
#define CLOTHID_TOOLS_MOTION_MOTION_CLOUDS_H_

#include <string>
#include <vector>

#include "datasets/motion/recorded_motion.h"

namespace clothid {

// `arguments`: what follows the name of the command; its flags are gflags. Returns an exit code; throws `Error`.
int ConvertClouds(const std::vector<std::string>& arguments);

// One line on stdout about how many points there are; nothing where the recording has no clouds.
void PrintClouds(const RecordedMotion& motion);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_MOTION_MOTION_CLOUDS_H_
