#include "datasets/importing/force_file.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "datasets/importing/clock_times.h"
#include "datasets/importing/path_times.h"
#include "sim/base/error.h"
#include "sim/base/npy_file.h"
#include "sim/base/table.h"
#include "sim/base/text_file.h"
#include "sim/mesh/mesh.h"
#include "sim/path/handle_csv.h"
#include "sim/path/number_table.h"

namespace clothid {
namespace {

constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

bool IsNpy(const std::string& path) { return path.size() > 4 && path.compare(path.size() - 4, 4, ".npy") == 0; }

// Where a component stands.
struct ForceColumn {
  std::size_t column = 0;
  int row = 0;  // of the values: 3 group + axis
};

// "x" is a component of one group, "x0" of any.
std::vector<ForceColumn> FindComponents(const Table& table, int num_groups) {
  std::vector<ForceColumn> components;
  for (std::size_t i = 0; i < table.header().size(); ++i) {
    const std::string& name = table.header()[i];
    const bool is_plain = name.size() == 1 && num_groups == 1;
    const std::optional<int> row = ComponentNamed(is_plain ? name + "0" : name);
    if (!row) continue;
    const bool is_known =
        std::any_of(components.begin(), components.end(), [&](const ForceColumn& known) { return known.row == *row; });
    if (*row >= 3 * num_groups || is_known) {
      table.FailOnHeader("column '" + Printable(name) + "': expected the components of " + std::to_string(num_groups) +
                         (num_groups == 1 ? " group of handles" : " groups of handles") + ", each once");
    }
    components.push_back({i, *row});
  }
  if (components.empty()) table.FailOnHeader("expected a column of a component");
  return components;
}

void ReadCsv(const std::string& path, ForceReadings* forces) {
  const int num_groups = forces->num_groups();
  Table table(path, ReadText(path, kMaxHandleCsvBytes), num_groups == 1 ? "time,x,y,z" : "time,x0,y0,z0,x1,..");
  const std::size_t time = table.Require("time");
  const std::vector<ForceColumn> components = FindComponents(table, num_groups);
  std::vector<double> times, values;
  while (table.NextRow()) {
    times.push_back(table.LaterTime(time));
    values.resize(values.size() + 3 * static_cast<std::size_t>(num_groups), kNotMeasured);
    double* const reading = values.data() + values.size() - 3 * num_groups;
    for (const auto& [column, row] : components) reading[row] = table.NumberOrNothing(column, Quantity::kForce);
  }
  if (times.empty()) table.FailWithoutRows();
  const auto count = static_cast<Eigen::Index>(times.size());
  forces->times = Eigen::Map<const Eigen::VectorXd>(times.data(), count);
  forces->values = Eigen::Map<const Eigen::MatrixXd>(values.data(), 3 * num_groups, count);
}

Eigen::VectorXd TimesOfReadings(const ForceFile& file, Eigen::Index num_readings, const Eigen::VectorXd& frames) {
  if (file.times_path.empty()) {
    if (num_readings == frames.size()) return frames;
    FailOnData(file.path, std::to_string(num_readings) + " readings for " + std::to_string(frames.size()) +
                              " frames; expected a file with their times");
  }
  const Eigen::VectorXd times = ReadTimes(file.times_path);
  if (times.size() != num_readings) {
    FailOnData(file.times_path, "holds " + std::to_string(times.size()) + " times; expected one for each of the " +
                                    std::to_string(num_readings) + " readings of " + file.path);
  }
  return times;
}

void ReadArray(const ForceFile& file, const Eigen::VectorXd& frames, ForceReadings* forces) {
  const NpyArray array = ReadNpy(file.path);
  const long long num_groups = forces->num_groups();
  const std::vector<long long>& shape = array.shape;
  const bool is_scalar = shape.size() == 1 && num_groups == 1;
  const bool fits = is_scalar || (shape.size() == 2 && shape[1] == 3 && num_groups == 1) ||
                    (shape.size() == 3 && shape[1] == num_groups && shape[2] == 3);
  if (!fits || shape[0] < 1) {
    FailOnData(file.path, "expected an array of shape (F, " + std::to_string(num_groups) + ", 3)" +
                              (num_groups == 1 ? ", (F, 3) or (F)" : ""));
  }
  if (is_scalar != file.axis.has_value()) {
    throw Error(ErrorKind::kUsage, file.path + (is_scalar ? ": has one component; expected its axis"
                                                          : ": has all components; expected no axis"));
  }
  const auto num_readings = static_cast<Eigen::Index>(shape[0]);
  if (is_scalar) {
    forces->values = Eigen::MatrixXd::Constant(3, num_readings, kNotMeasured);
    forces->values.row(*file.axis) = Eigen::Map<const Eigen::RowVectorXd>(array.values.data(), num_readings);
  } else {
    forces->values = Eigen::Map<const Eigen::MatrixXd>(array.values.data(), 3 * num_groups, num_readings);
  }
  forces->times = TimesOfReadings(file, num_readings, frames);
}

}  // namespace

std::string ForceCsv(const ForceReadings& forces) {
  std::string text = "time";
  const bool has_groups = forces.num_groups() > 1;
  for (int row = 0; row < 3 * forces.num_groups(); ++row) {
    text += std::string(",") + "xyz"[row % 3] + (has_groups ? std::to_string(row / 3) : "");
  }
  text += "\n";
  for (int i = 0; i < forces.num_readings(); ++i) {
    text += ShortestText(forces.times[i]);
    for (const double force : forces.values.col(i)) text += "," + (std::isnan(force) ? "" : ShortestText(force));
    text += "\n";
  }
  return text;
}

void KeepReadingsWithin(const Eigen::VectorXd& times, ForceReadings* forces) {
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < forces->times.size(); ++i) {
    if (forces->times[i] >= times[0] && forces->times[i] <= times[times.size() - 1]) kept.push_back(i);
  }
  forces->times = forces->times(kept).eval();
  forces->values = forces->values(Eigen::all, kept).eval();
  if (forces->moments.size() > 0) forces->moments = forces->moments(Eigen::all, kept).eval();
}

ForceReadings ReadForces(const ForceFile& file, const Eigen::VectorXd& times, double time_shift) {
  if (!(file.sigma > 0.0) || !std::isfinite(file.sigma)) {
    throw Error(ErrorKind::kUsage, file.path + ": expected the standard deviation of its forces, a number > 0 (N)");
  }
  if (!std::isfinite(file.scale) || file.scale == 0.0) {
    throw Error(ErrorKind::kUsage, file.path + ": expected a factor other than 0");
  }
  ForceReadings forces;
  forces.groups = file.groups;
  if (IsNpy(file.path)) {
    ReadArray(file, times, &forces);
  } else {
    if (!file.times_path.empty()) throw Error(ErrorKind::kUsage, file.path + ": has times of its own");
    if (file.axis) throw Error(ErrorKind::kUsage, file.path + ": names its components; expected no axis");
    ReadCsv(file.path, &forces);
  }
  ExpectSeconds(forces.times, file.times_path.empty() ? file.path : file.times_path);
  forces.values *= file.scale;
  forces.sigma = Eigen::VectorXd::Constant(forces.num_groups(), file.sigma);
  // Those of the frames are on the clock of the recording, and stay the same to the last bit.
  const bool has_frame_times = IsNpy(file.path) && file.times_path.empty();
  forces.times = (forces.times.array() - file.time_offset) + (has_frame_times ? 0.0 : time_shift);
  const double first = forces.times[0], last = forces.times[forces.times.size() - 1];
  KeepReadingsWithin(times, &forces);
  if (forces.is_empty()) {
    FailOnData(file.path, "is known from " + std::to_string(first) + " s to " + std::to_string(last) +
                              " s on the clock of the recording, which lasts from " + std::to_string(times[0]) +
                              " s to " + std::to_string(times[times.size() - 1]) + " s; expected another time offset");
  }
  return forces;
}

void TurnForces(const Eigen::Matrix3d& rotation, const std::string& source, ForceReadings* forces) {
  if (rotation.isIdentity(0.0)) return;
  for (auto force : forces->values.reshaped(3, forces->values.size() / 3).colwise()) {
    if (force.array().isNaN().all()) continue;
    if (force.hasNaN()) FailOnData(source, "forces of which a component is not known cannot be turned");
    force = (rotation * force).eval();
  }
  auto moments = forces->moments.reshaped(3, forces->moments.size() / 3);
  moments = (rotation * moments).eval();
}

std::vector<std::vector<int>> ParseForceGroups(const std::string& text, const std::string& flag) {
  std::vector<std::vector<int>> groups;
  if (text.empty()) return groups;
  for (const std::string& group : Split(text, ':')) {
    std::vector<int>& nodes = groups.emplace_back();
    for (const std::string& item : Split(group, ',')) {
      const std::optional<long long> node = ParseInteger(item);
      if (!node || *node < 0 || *node >= kMaxNodes) {
        throw Error(ErrorKind::kUsage,
                    flag + ": expected groups of nodes as in 0,1:4,5, got '" + Printable(text) + "'");
      }
      nodes.push_back(static_cast<int>(*node));
    }
  }
  return groups;
}

}  // namespace clothid
