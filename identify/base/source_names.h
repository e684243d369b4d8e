// What results call the sources of what was assumed about a recording.
#ifndef CLOTHID_IDENTIFY_BASE_SOURCE_NAMES_H_
#define CLOTHID_IDENTIFY_BASE_SOURCE_NAMES_H_

#include <string>

#include "datasets/motion/recorded_motion.h"

namespace clothid {

// "unknown", "recorded", "given" or "estimated".
std::string SigmaSourceName(SigmaSource source);

// "scene", "first", "smoothed", "rest", "moving" or, of what is asked for, "estimated".
std::string StartSourceName(StartSource source);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_BASE_SOURCE_NAMES_H_
