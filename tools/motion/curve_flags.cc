#include "tools/motion/curve_flags.h"

#include <gflags/gflags.h>

#include "sim/base/text_file.h"
#include "tools/motion/track_flags.h"

DEFINE_string(direction, "", "convert_curve, convert_cantilever: along which a strip was cut, warp, weft or bias");

namespace clothid {

bool IsGivenFlag(const char* flag) { return !gflags::GetCommandLineFlagInfoOrDie(flag).is_default; }

PullDirection PullDirectionFromFlag() {
  if (FLAGS_direction == "warp") return PullDirection::kWarp;
  if (FLAGS_direction == "weft") return PullDirection::kWeft;
  if (FLAGS_direction == "bias") return PullDirection::kBias;
  FailFlag("direction", "expected warp, weft or bias, got '" + Printable(FLAGS_direction) + "'");
}

}  // namespace clothid
