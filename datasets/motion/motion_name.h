// The names of recordings.
#ifndef CLOTHID_DATASETS_MOTION_MOTION_NAME_H_
#define CLOTHID_DATASETS_MOTION_MOTION_NAME_H_

#include <string>

namespace clothid {

// Whether `path` ends in ".bin": a motion.bin, and no other format of `motion convert`.
bool IsMotionName(const std::string& path);

// Throws `Error` (kUsage) unless `path`, to be written as a motion.bin, has such a name or is a device or a pipe: under
// the name of another format it would be read as that.
void ExpectMotionName(const std::string& path);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_MOTION_MOTION_NAME_H_
