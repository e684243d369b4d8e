// From the flags of `landscape` to what is to be scanned.
#ifndef CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_PLAN_H_
#define CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_PLAN_H_

#include <string>

#include "datasets/motion/motion_file.h"
#include "identify/base/fitted_result.h"
#include "identify/landscape/landscape.h"
#include "sim/scene/scene.h"
#include "tools/landscape/landscape_scan.h"
#include "tools/landscape/scene_variant.h"

namespace clothid {

// The text of the flags of these names; empty: not given.
struct LandscapeFlags {
  std::string x, y;         // see `ParseAxis`
  std::string zoom_around;  // NAME=VALUE,NAME=VALUE with the names of both axes
  std::string zoom;         // "0.1,0.03": a window for each of these shares of both axes
  bool zoom_only = false;   // leaves the whole out
  std::string sweep;        // see `ParseSweep`
  std::string contact;      // gap, velocity or both; not given: the scene's own
  bool gradients = false;
};

// Windows by falling zoom. Settings: every variant of the sweep in every contact mode, the mode fastest. Throws `Error`
// (kUsage), naming the flag, also where an axis is part of the other.
LandscapePlan MakeLandscapePlan(const LandscapeFlags& flags, const Scene& scene);

// The plan of `flags`, and in each of its settings the recording that `read` gives with `reading`; of the cost of the
// fit `result`, which may be null. Throws `Error` as `MakeLandscapePlan`, `ReadMotionVariant`, `ScannedFitOf` and
// `FollowFit` do, and (kUsage), naming --sweep, where that changes what is on an axis or held: every cell sets that
// itself.
LandscapeScanOptions SetUpLandscape(const LandscapeFlags& flags, const MotionReader& read,
                                    const ReadMotionOptions& reading, const FittedResult* result = nullptr);

// "I/N" with 0 <= I < N; empty: the whole. Throws `Error` (kUsage), naming --shard.
LandscapeShard ParseShard(const std::string& text);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_LANDSCAPE_LANDSCAPE_PLAN_H_
