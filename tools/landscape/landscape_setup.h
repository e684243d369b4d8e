// From flags and a recording to a scan.
#ifndef CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_SETUP_H_
#define CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_SETUP_H_

#include "datasets/motion/motion_file.h"
#include "tools/landscape/landscape_plan.h"
#include "tools/landscape/landscape_scan.h"
#include "tools/landscape/scene_variant.h"

namespace clothid {

// The plan of `flags`, and in each of its settings the recording that `read` gives with `reading`. Throws `Error` as
// `MakeLandscapePlan`, `ReadMotionVariant` and `CheckSweep` do.
LandscapeScanOptions SetUpLandscape(const LandscapeFlags& flags, const MotionReader& read,
                                    const ReadMotionOptions& reading);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_SETUP_H_
