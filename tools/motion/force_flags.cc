#include "tools/motion/force_flags.h"

#include <gflags/gflags.h>

#include "sim/base/error.h"
#include "sim/base/text_file.h"
#include "tools/motion/track_flags.h"

DEFINE_string(forces, "", "convert: file with forces at the handles");
DEFINE_string(force_times, "", "convert: file with the times of a .npy of forces, s");
DEFINE_double(force_sigma, 0.0, "convert, convert_curve: standard deviation of a component of a force, N");
DEFINE_string(force_nodes, "", "convert: the handles that each sensor holds");
DEFINE_string(force_axis, "", "convert: x, y or z, of a .npy of forces with one component");
DEFINE_double(force_scale, 1.0, "convert: factor of forces");
DEFINE_double(force_time_offset, 0.0, "convert: clock of --forces minus that of the recording, s");

namespace clothid {
namespace {

bool IsSet(const char* flag) { return !gflags::GetCommandLineFlagInfoOrDie(flag).is_default; }

std::optional<int> AxisFromFlag() {
  if (!IsSet("force_axis")) return std::nullopt;
  const std::size_t axis = std::string("xyz").find(FLAGS_force_axis);
  if (FLAGS_force_axis.size() != 1 || axis > 2) {
    FailFlag("force_axis", "expected x, y or z, got '" + Printable(FLAGS_force_axis) + "'");
  }
  return static_cast<int>(axis);
}

}  // namespace

std::optional<ForceFile> ForceFileFromFlags() {
  if (!IsSet("forces")) {
    if (IsSet("force_sigma")) FailFlag("force_sigma", "expected with --forces");
    return std::nullopt;
  }
  if (!(FLAGS_force_sigma > 0.0)) FailFlag("force_sigma", "expected with --forces, a number > 0 (N)");
  ForceFile file;
  file.path = FLAGS_forces;
  file.times_path = FLAGS_force_times;
  file.groups = ParseForceGroups(FLAGS_force_nodes, "--force_nodes");
  file.axis = AxisFromFlag();
  file.scale = FLAGS_force_scale;
  file.sigma = FLAGS_force_sigma;
  file.time_offset = FLAGS_force_time_offset;
  return file;
}

std::vector<std::string> ForceInputs() { return {FLAGS_forces, FLAGS_force_times}; }

}  // namespace clothid
