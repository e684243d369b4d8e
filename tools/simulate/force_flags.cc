#include "tools/simulate/force_flags.h"

#include <gflags/gflags.h>

#include <string>
#include <vector>

#include "datasets/importing/force_file.h"
#include "sim/base/error.h"
#include "sim/base/text_file.h"

DEFINE_bool(forces, false, "the forces at the handles, too");
DEFINE_double(force_sigma, 0.0, "standard deviation of Gaussian noise on every component of a force, N");
DEFINE_double(force_rate, 0.0, "readings of forces per second; 0: one per frame");
DEFINE_string(force_bias, "", "what every sensor of forces is off by, X,Y,Z, N");
DEFINE_string(force_nodes, "", "the handles that each sensor of forces holds");

namespace clothid {
namespace {

Eigen::Vector3d ParseBias() {
  Eigen::Vector3d bias;
  const std::vector<std::string> parts = Split(FLAGS_force_bias, ',');
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::optional<double> value = parts.size() == 3 ? ParseNumber(parts[axis]) : std::nullopt;
    if (!value) {
      throw Error(ErrorKind::kUsage, "--force_bias: expected X,Y,Z in N, got '" + Printable(FLAGS_force_bias) + "'");
    }
    bias[static_cast<Eigen::Index>(axis)] = *value;
  }
  return bias;
}

}  // namespace

std::optional<ForceSensor> ForceSensorFromFlags() {
  if (!FLAGS_forces) return std::nullopt;
  ForceSensor sensor;
  sensor.groups = ParseForceGroups(FLAGS_force_nodes, "--force_nodes");
  sensor.rate = FLAGS_force_rate;
  sensor.sigma = FLAGS_force_sigma;
  if (!FLAGS_force_bias.empty()) sensor.bias = ParseBias();
  return sensor;
}

}  // namespace clothid
