// The flags of motion convert that are about forces at handles.
#ifndef CLOTHID_TOOLS_MOTION_FORCE_FLAGS_H_
#define CLOTHID_TOOLS_MOTION_FORCE_FLAGS_H_

#include <optional>
#include <string>
#include <vector>

#include "datasets/importing/force_file.h"

namespace clothid {

// Nothing without --forces. Throws `Error` (kUsage), naming the flag.
std::optional<ForceFile> ForceFileFromFlags();

// The files that they name, empty names among them.
std::vector<std::string> ForceInputs();

}  // namespace clothid

#endif  // CLOTHID_TOOLS_MOTION_FORCE_FLAGS_H_
