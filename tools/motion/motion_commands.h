// The commands of the program `motion`. Each returns an exit code or throws `Error`.
#ifndef CLOTHID_TOOLS_MOTION_MOTION_COMMANDS_H_
#define CLOTHID_TOOLS_MOTION_MOTION_COMMANDS_H_

#include <string>

#include "datasets/motion/recorded_motion.h"

namespace clothid {

// What the container holds: tensors, times, points, scene, provenance.
int MotionInfo(const std::string& path);

// Findings about the recording, as a table or as JSON (datasets/checking/motion_check.h). Throws `Error` (kBadData),
// after they are printed, where one of them is a problem.
int MotionCheck(const std::string& path);

// From any format to any other, as the flags say.
int MotionConvert(const std::string& input, const std::string& output);

// A time in s with six digits, more where it takes them to tell 0.1 ms: clocks count from 1970.
std::string TimeText(double seconds);

// How a recording covers time and points, in three lines on stdout.
void PrintCoverage(const RecordedMotion& motion);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_MOTION_MOTION_COMMANDS_H_
