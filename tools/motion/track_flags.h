// Flags of motion convert and convert_clouds about clock and frame of reference.
#ifndef CLOTHID_TOOLS_MOTION_TRACK_FLAGS_H_
#define CLOTHID_TOOLS_MOTION_TRACK_FLAGS_H_

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "datasets/importing/clock_times.h"

namespace clothid {

// Of --times, which is given: a file, or the word "names" for those in the names of `files`.
FrameTimes FrameTimesFromFlags(const std::vector<std::string>& files);
// That file, for messages; empty without one.
std::string TimesNameFromFlags();

// --start_at, s. Throws `Error` (kUsage).
std::optional<double> StartFromFlags();

// --transform and --invert_transform.
Eigen::Isometry3d TransformFromFlags();

// Throws `Error` (kUsage): "--flag: message".
[[noreturn]] void FailFlag(const std::string& flag, const std::string& message);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_MOTION_TRACK_FLAGS_H_
