// Flags that commands about tests of a laboratory share.
#ifndef CLOTHID_TOOLS_MOTION_CURVE_FLAGS_H_
#define CLOTHID_TOOLS_MOTION_CURVE_FLAGS_H_

#include "datasets/curves/tensile_recording.h"

namespace clothid {

bool IsGivenFlag(const char* flag);

// --direction; throws `Error` (kUsage) for what is none.
PullDirection PullDirectionFromFlag();

}  // namespace clothid

#endif  // CLOTHID_TOOLS_MOTION_CURVE_FLAGS_H_
