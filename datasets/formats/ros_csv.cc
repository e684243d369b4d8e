#include "datasets/formats/ros_csv.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include "datasets/files/file_kind.h"
#include "sim/base/table.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

constexpr std::string_view kFirstColumn = "%time";
constexpr char kExample[] = "%time,field.header.stamp,..";
constexpr std::size_t kMaxStart = 16;          // bytes that tell such a file: a byte order mark, a quote, the column
constexpr double kNanoseconds = 1e9;           // per second
constexpr double kUnitLengthTolerance = 1e-2;  // of a quaternion

bool EndsWith(std::string_view text, std::string_view end) {
  return text.size() >= end.size() && text.substr(text.size() - end.size()) == end;
}

// A table with times in ns.
class RosTable : public Table {
 public:
  explicit RosTable(const std::string& path) : Table(path, ReadText(path, kMaxRosCsvBytes), kExample) {
    if (header()[0] != kFirstColumn) FailOnHeader("expected a header that starts with '%time'");
    time_column_ = Find("field.header.stamp").value_or(0);
  }

  // The one column whose name ends so.
  std::size_t RequireEnd(std::string_view end) const {
    std::optional<std::size_t> found;
    for (std::size_t i = 0; i < header().size(); ++i) {
      if (!EndsWith(header()[i], end)) continue;
      if (found) Fail("expected one column that ends in '" + std::string(end) + "', found two");
      found = i;
    }
    if (!found) Fail("expected a column that ends in '" + std::string(end) + "'");
    return *found;
  }

  double Seconds() const {
    const std::optional<long long> stamp = ParseInteger(cell(time_column_));
    if (!stamp || *stamp < 0) FailAt(time_column_, "an integer >= 0 (ns)");
    return static_cast<double>(*stamp) / kNanoseconds;
  }

  long long Integer(std::size_t column, long long low, long long high) const {
    const std::optional<long long> value = ParseInteger(cell(column));
    if (!value || *value < low || *value > high) {
      FailAt(column, "an integer from " + std::to_string(low) + " to " + std::to_string(high));
    }
    return *value;
  }

  // NaN for infinity, too.
  double NumberOrMissing(std::size_t column) {
    std::string_view word = cell(column);
    if (!word.empty() && (word[0] == '-' || word[0] == '+')) word.remove_prefix(1);
    if (word == "inf" || word == "Infinity") return std::numeric_limits<double>::quiet_NaN();
    return NumberOrNothing(column, Quantity::kLength);
  }

 private:
  std::size_t time_column_ = 0;
};

// Where the coordinates of a grid stand.
struct GridColumns {
  std::size_t size = 0;     // the column of n
  std::size_t first_x = 0;  // then all x, all y, all z
  std::size_t num_points = 0;
};

GridColumns FindGrid(const RosTable& table) {
  GridColumns grid;
  grid.size = table.Require("field.size");
  grid.first_x = table.Require("field.x0");
  const std::size_t first_y = table.Require("field.y0");
  if (first_y <= grid.first_x) table.Fail("expected the column 'field.y0' behind 'field.x0'");
  grid.num_points = first_y - grid.first_x;
  for (std::size_t k = 0; k < 3 * grid.num_points; ++k) {
    const std::string name = std::string("field.") + "xyz"[k / grid.num_points] + std::to_string(k % grid.num_points);
    const std::size_t column = grid.first_x + k;
    if (column >= table.header().size() || table.header()[column] != name) {
      table.Fail("expected column " + std::to_string(column + 1) + " to be '" + name + "'");
    }
  }
  return grid;
}

void ReadPoints(const GridColumns& grid, RosTable* table, std::vector<double>* positions) {
  for (std::size_t p = 0; p < grid.num_points; ++p) {
    Eigen::Vector3d point;
    for (std::size_t k = 0; k < 3; ++k) {
      point[static_cast<Eigen::Index>(k)] = table->NumberOrMissing(grid.first_x + k * grid.num_points + p);
    }
    if (point.hasNaN()) point.setConstant(std::numeric_limits<double>::quiet_NaN());
    positions->insert(positions->end(), point.begin(), point.end());
  }
}

Eigen::Vector4d ReadQuaternion(const std::size_t (&columns)[4], RosTable* table) {
  Eigen::Vector4d quaternion;
  for (int k = 0; k < 4; ++k) quaternion[k] = table->Number(columns[k], Quantity::kNumber);
  const double length = quaternion.stableNorm();
  if (!(std::abs(length - 1.0) <= kUnitLengthTolerance)) table->Fail("expected an orientation of unit length");
  return quaternion / length;
}

}  // namespace

bool IsRosCsv(const std::string& path) {
  const std::string start = ReadStart(path, kMaxStart);
  const std::size_t first = std::min(start.find_first_not_of(" \""), start.size());
  return start.compare(first, kFirstColumn.size(), kFirstColumn) == 0;
}

PointTracks ReadRosGrid(const std::string& path) {
  RosTable table(path);
  const GridColumns grid = FindGrid(table);
  std::vector<double> times, positions;
  while (table.NextRow()) {
    const long long side = table.Integer(grid.size, 1, kMaxRosGridSide);
    if (side * side != static_cast<long long>(grid.num_points)) {
      table.Fail("column 'field.size': expected the side of a square grid of " + std::to_string(grid.num_points) +
                 " points, found " + std::to_string(side));
    }
    times.push_back(table.Seconds());
    if (times.size() > 1 && !(times.back() > times[times.size() - 2])) {
      table.Fail("expected a time after that of the row before");
    }
    ReadPoints(grid, &table, &positions);
  }
  if (times.empty()) table.Fail("expected at least one row below the header");
  PointTracks tracks;
  tracks.name = path;
  tracks.times = Eigen::Map<Eigen::VectorXd>(times.data(), static_cast<Eigen::Index>(times.size()));
  tracks.positions = Eigen::Map<Eigen::MatrixXd>(positions.data(), 3 * static_cast<Eigen::Index>(grid.num_points),
                                                 tracks.times.size());
  return tracks;
}

PoseTrack ReadRosPoses(const std::string& path) {
  RosTable table(path);
  const std::size_t position[3] = {table.RequireEnd("position.x"), table.RequireEnd("position.y"),
                                   table.RequireEnd("position.z")};
  const std::size_t orientation[4] = {table.RequireEnd("orientation.x"), table.RequireEnd("orientation.y"),
                                      table.RequireEnd("orientation.z"), table.RequireEnd("orientation.w")};
  PoseTrack poses;
  std::vector<double> times, positions, rotations;
  while (table.NextRow()) {
    times.push_back(table.Seconds());
    poses.lines.push_back(table.line());
    for (const std::size_t column : position) positions.push_back(table.Number(column, Quantity::kLength));
    const Eigen::Vector4d quaternion = ReadQuaternion(orientation, &table);
    rotations.insert(rotations.end(), quaternion.begin(), quaternion.end());
  }
  if (times.empty()) table.Fail("expected at least one row below the header");
  const auto count = static_cast<Eigen::Index>(times.size());
  poses.name = path;
  poses.times = Eigen::Map<Eigen::VectorXd>(times.data(), count);
  poses.positions = Eigen::Map<Eigen::Matrix3Xd>(positions.data(), 3, count);
  poses.rotations = Eigen::Map<Eigen::Matrix4Xd>(rotations.data(), 4, count);
  return poses;
}

}  // namespace clothid
