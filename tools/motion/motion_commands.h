// The commands of the program `motion`. Each takes the words behind its name, as many as motion_main.cc says, and
// returns an exit code or throws `Error`.
#ifndef CLOTHID_TOOLS_MOTION_MOTION_COMMANDS_H_
#define CLOTHID_TOOLS_MOTION_MOTION_COMMANDS_H_

#include <string>
#include <vector>

#include "datasets/motion/recorded_motion.h"

namespace clothid {

// What the container holds: tensors, times, points, scene, provenance.
int MotionInfo(const std::vector<std::string>& arguments);

// Findings about the recording, as a table or as JSON (datasets/checking/motion_check.h). Throws `Error` (kBadData),
// after they are printed, where one of them is a problem.
int MotionCheck(const std::vector<std::string>& arguments);

// Writes a page that replays a recording, or the motion of a scene.json with its nominal values
// (identify/view/view_page.h).
int MotionView(const std::vector<std::string>& arguments);

// From any format to any other, as these flags say, which are separated by blanks.
std::string ConvertFlags();
int MotionConvert(const std::vector<std::string>& arguments);

// A motion.bin from a folder of point clouds.
int MotionConvertClouds(const std::vector<std::string>& arguments);

// A motion.bin from the curve of a tensile test, and on stdout what was made of it.
int MotionConvertCurve(const std::vector<std::string>& arguments);

// A motion.bin from the table of a cantilever test, and on stdout the rigidity that its elastica has.
int MotionConvertCantilever(const std::vector<std::string>& arguments);

// Friction from the angles at which specimens slide down a plate.
int MotionFriction(const std::vector<std::string>& arguments);

// A time in s with six digits, more where it takes them to tell 0.1 ms: clocks count from 1970.
std::string TimeText(double seconds);

// How a recording covers time and points, in three lines on stdout.
void PrintCoverage(const RecordedMotion& motion);

// How many points its clouds have, in one line on stdout; nothing where it has none.
void PrintClouds(const RecordedMotion& motion);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_MOTION_MOTION_COMMANDS_H_
