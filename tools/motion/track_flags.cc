#include "tools/motion/track_flags.h"

#include <gflags/gflags.h>

#include "datasets/importing/transform_file.h"
#include "sim/base/error.h"
#include "sim/base/text_file.h"

DECLARE_string(times);
DECLARE_string(start_at);
DECLARE_string(transform);
DECLARE_bool(invert_transform);

namespace clothid {
namespace {

constexpr char kNames[] = "names";

}  // namespace

FrameTimes FrameTimesFromFlags(const std::vector<std::string>& files) {
  return FLAGS_times == kNames ? TimesOfNames(files) : ReadFrameTimes(FLAGS_times);
}

std::string TimesNameFromFlags() { return FLAGS_times == kNames ? std::string() : FLAGS_times; }

std::optional<double> StartFromFlags() {
  if (FLAGS_start_at.empty()) return std::nullopt;
  const std::optional<double> value = ParseNumber(FLAGS_start_at);
  ExpectUsage(value.has_value(), "--start_at: expected a finite number, got '" + Printable(FLAGS_start_at) + "'");
  return value;
}

Eigen::Isometry3d TransformFromFlags() {
  if (FLAGS_transform.empty()) return Eigen::Isometry3d::Identity();
  const Eigen::Isometry3d transform = ReadTransform(FLAGS_transform);
  return FLAGS_invert_transform ? transform.inverse() : transform;
}

void FailFlag(const std::string& flag, const std::string& message) {
  throw Error(ErrorKind::kUsage, "--" + flag + ": " + message);
}

}  // namespace clothid
