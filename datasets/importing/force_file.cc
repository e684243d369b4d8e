#include "datasets/importing/force_file.h"

#include <cmath>
#include <limits>
#include <string_view>

#include "sim/base/csv_row.h"
#include "sim/base/error.h"
#include "sim/base/npy_file.h"
#include "sim/base/text_file.h"
#include "sim/mesh/mesh.h"
#include "sim/path/handle_csv.h"

namespace clothid {
namespace {

constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

bool IsNpy(const std::string& path) { return path.size() > 4 && path.compare(path.size() - 4, 4, ".npy") == 0; }

// The rows of the components in a header, after `time`: 3 group + axis.
std::vector<int> ComponentRows(const std::vector<std::string>& header, int num_groups, const std::string& path) {
  std::vector<int> rows;
  for (std::size_t i = 1; i < header.size(); ++i) {
    const std::string& name = header[i];
    const std::size_t axis = name.empty() ? std::string_view::npos : std::string_view("xyz").find(name.front());
    const bool is_plain = name.size() == 1 && num_groups == 1;
    const std::optional<long long> group = is_plain ? 0 : ParseInteger(name.empty() ? name : name.substr(1));
    if (axis == std::string_view::npos || !group || *group < 0 || *group >= num_groups) {
      FailOnData(path + ":1", "column '" + Printable(name) + "': expected " +
                                  (num_groups == 1 ? "x, y or z" : "x0, y0, .. of one of the groups of handles"));
    }
    rows.push_back(3 * static_cast<int>(*group) + static_cast<int>(axis));
  }
  return rows;
}

void AppendCsvRow(const std::vector<std::string>& cells, const std::vector<int>& rows, const std::string& place,
                  std::vector<double>* times, Eigen::MatrixXd* values) {
  if (cells.size() != rows.size() + 1) FailOnData(place, "expected " + std::to_string(rows.size() + 1) + " cells");
  const std::optional<double> time = ParseNumber(Trimmed(cells[0]));
  if (!time) FailOnData(place, "expected a time (s), got '" + Printable(cells[0]) + "'");
  times->push_back(*time);
  if (static_cast<Eigen::Index>(times->size()) > values->cols()) {
    values->conservativeResize(Eigen::NoChange, 2 * values->cols() + 64);
  }
  auto column = values->col(static_cast<Eigen::Index>(times->size()) - 1);
  column.setConstant(kNotMeasured);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::string cell(Trimmed(cells[i + 1]));
    if (cell.empty() || cell == "nan" || cell == "NaN") continue;
    const std::optional<double> value = ParseNumber(cell);
    if (!value) FailOnData(place, "expected a force (N) or nothing, got '" + Printable(cell) + "'");
    column[rows[i]] = *value;
  }
}

void ReadCsv(const std::string& path, ForceReadings* forces) {
  const std::string text = ReadText(path, kMaxHandleCsvBytes);
  std::string_view rest = text;
  std::vector<double> times;
  std::vector<int> rows;
  forces->values.resize(3 * forces->num_groups(), 0);
  for (int number = 1; std::optional<std::string_view> line = TakeLine(&rest); ++number) {
    const std::string place = path + ":" + std::to_string(number);
    const std::optional<std::vector<std::string>> found = CsvCells(*line);
    if (!found) FailOnData(place, kExpectedQuotes);
    const std::vector<std::string>& cells = *found;
    if (number == 1) {
      if (cells.front() != "time" || cells.size() < 2) FailOnData(path + ":1", "expected a header 'time,x,y,z'");
      rows = ComponentRows(cells, forces->num_groups(), path);
    } else if (!Trimmed(*line).empty()) {
      AppendCsvRow(cells, rows, place, &times, &forces->values);
    }
  }
  if (times.empty()) FailOnData(path, "expected a header and at least one row of numbers");
  forces->times = Eigen::Map<const Eigen::VectorXd>(times.data(), static_cast<Eigen::Index>(times.size()));
  forces->values.conservativeResize(Eigen::NoChange, forces->times.size());
}

Eigen::VectorXd ReadNpyTimes(const ForceFile& file, Eigen::Index num_readings, const Eigen::VectorXd& frames) {
  if (file.times_path.empty()) {
    if (num_readings == frames.size()) return frames;
    FailOnData(file.path, std::to_string(num_readings) + " readings for " + std::to_string(frames.size()) +
                              " frames; expected a file with their times");
  }
  const NpyArray array = ReadNpy(file.times_path);
  if (array.shape != std::vector<long long>{num_readings}) {
    FailOnData(file.times_path,
               "expected an array of shape (" + std::to_string(num_readings) + "), a time per reading");
  }
  return Eigen::Map<const Eigen::VectorXd>(array.values.data(), num_readings);
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
  forces->times = ReadNpyTimes(file, num_readings, frames);
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
