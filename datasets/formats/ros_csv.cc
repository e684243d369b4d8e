#include "datasets/formats/ros_csv.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include "sim/base/error.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

constexpr std::string_view kFirstColumn = "%time";
constexpr std::size_t kMaxMark = 3;            // bytes of a byte order mark
constexpr double kNanoseconds = 1e9;           // per second
constexpr double kUnitLengthTolerance = 1e-2;  // of a quaternion

bool EndsWith(std::string_view text, std::string_view end) {
  return text.size() >= end.size() && text.substr(text.size() - end.size()) == end;
}

// The cells of a table of numbers, line by line, with errors that name file, line and column.
class RosTable {
 public:
  explicit RosTable(const std::string& path) : path_(path), text_(ReadText(path, kMaxRosCsvBytes)), rest_(text_) {
    const std::optional<std::string_view> header = TakeLine(&rest_);
    if (!header || header->substr(0, kFirstColumn.size()) != kFirstColumn) {
      Fail("expected a header that starts with '" + std::string(kFirstColumn) + "'");
    }
    columns_ = Split(*header, ',');
    const std::optional<std::size_t> stamp = Find("field.header.stamp");
    time_column_ = stamp ? *stamp : 0;
  }

  // Goes to the next row that is not empty; false where there is none.
  bool NextRow() {
    while (std::optional<std::string_view> line = TakeLine(&rest_)) {
      ++line_;
      if (line->empty()) continue;
      const auto num_cells = static_cast<std::size_t>(std::count(line->begin(), line->end(), ',')) + 1;
      if (num_cells != columns_.size()) {
        Fail("expected the " + std::to_string(columns_.size()) + " columns of the header, found " +
             std::to_string(num_cells));
      }
      cells_.clear();
      for (std::size_t end = line->find(','); end != std::string_view::npos; end = line->find(',')) {
        cells_.push_back(line->substr(0, end));
        line->remove_prefix(end + 1);
      }
      cells_.push_back(*line);
      return true;
    }
    return false;
  }

  const std::vector<std::string>& columns() const { return columns_; }

  std::optional<std::size_t> Find(std::string_view name) const {
    const auto found = std::find(columns_.begin(), columns_.end(), name);
    if (found == columns_.end()) return std::nullopt;
    return static_cast<std::size_t>(found - columns_.begin());
  }

  std::size_t Require(std::string_view name) const {
    const std::optional<std::size_t> found = Find(name);
    if (!found) Fail("expected a column '" + std::string(name) + "'");
    return *found;
  }

  // The one column whose name ends so.
  std::size_t RequireEnd(std::string_view end) const {
    std::optional<std::size_t> found;
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      if (!EndsWith(columns_[i], end)) continue;
      if (found) Fail("expected one column that ends in '" + std::string(end) + "', found two");
      found = i;
    }
    if (!found) Fail("expected a column that ends in '" + std::string(end) + "'");
    return *found;
  }

  double Seconds() const {
    const std::optional<long long> stamp = ParseInteger(cells_[time_column_]);
    if (!stamp || *stamp < 0) FailAt(time_column_, "an integer >= 0 (ns)");
    return static_cast<double>(*stamp) / kNanoseconds;
  }

  long long Integer(std::size_t column, long long low, long long high) const {
    const std::optional<long long> value = ParseInteger(cells_[column]);
    if (!value || *value < low || *value > high) {
      FailAt(column, "an integer from " + std::to_string(low) + " to " + std::to_string(high));
    }
    return *value;
  }

  double Number(std::size_t column) const {
    const std::optional<double> value = ParseNumber(cells_[column]);
    if (!value) FailAt(column, "a finite number");
    return *value;
  }

  // NaN for nan and infinity.
  double NumberOrMissing(std::size_t column) const {
    std::string_view cell = cells_[column];
    if (const std::optional<double> value = ParseNumber(cell)) return *value;
    if (!cell.empty() && (cell[0] == '-' || cell[0] == '+')) cell.remove_prefix(1);
    if (cell != "nan" && cell != "NaN" && cell != "inf" && cell != "Infinity") FailAt(column, "a number or nan");
    return std::numeric_limits<double>::quiet_NaN();
  }

  [[noreturn]] void Fail(const std::string& message) const {
    throw Error(ErrorKind::kBadData, path_ + ":" + std::to_string(line_) + ": " + message);
  }

 private:
  [[noreturn]] void FailAt(std::size_t column, const std::string& expected) const {
    Fail("column '" + Printable(columns_[column]) + "': expected " + expected + ", found '" +
         Printable(cells_[column]) + "'");
  }

  const std::string& path_;
  const std::string text_;
  std::string_view rest_;
  int line_ = 1;
  std::vector<std::string> columns_;
  std::size_t time_column_ = 0;
  std::vector<std::string_view> cells_;
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
    if (column >= table.columns().size() || table.columns()[column] != name) {
      table.Fail("expected column " + std::to_string(column + 1) + " to be '" + name + "'");
    }
  }
  return grid;
}

void ReadPoints(const RosTable& table, const GridColumns& grid, std::vector<double>* positions) {
  for (std::size_t p = 0; p < grid.num_points; ++p) {
    Eigen::Vector3d point;
    for (std::size_t k = 0; k < 3; ++k) {
      point[static_cast<Eigen::Index>(k)] = table.NumberOrMissing(grid.first_x + k * grid.num_points + p);
    }
    if (point.hasNaN()) point.setConstant(std::numeric_limits<double>::quiet_NaN());
    positions->insert(positions->end(), point.begin(), point.end());
  }
}

Eigen::Vector4d ReadQuaternion(const RosTable& table, const std::size_t (&columns)[4]) {
  Eigen::Vector4d quaternion;
  for (int k = 0; k < 4; ++k) quaternion[k] = table.Number(columns[k]);
  const double length = quaternion.stableNorm();
  if (!(std::abs(length - 1.0) <= kUnitLengthTolerance)) table.Fail("expected an orientation of unit length");
  return quaternion / length;
}

}  // namespace

bool IsRosCsv(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string start(kMaxMark + kFirstColumn.size(), '\0');
  if (!file) throw Error(ErrorKind::kIo, path + ": cannot be read: " + std::strerror(errno));
  file.read(start.data(), static_cast<std::streamsize>(start.size()));
  StripByteOrderMark(path, &start);
  return start.compare(0, kFirstColumn.size(), kFirstColumn) == 0;
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
    ReadPoints(table, grid, &positions);
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
  std::vector<double> times, positions, rotations;
  while (table.NextRow()) {
    times.push_back(table.Seconds());
    for (const std::size_t column : position) positions.push_back(table.Number(column));
    const Eigen::Vector4d quaternion = ReadQuaternion(table, orientation);
    rotations.insert(rotations.end(), quaternion.begin(), quaternion.end());
  }
  if (times.empty()) table.Fail("expected at least one row below the header");
  const auto count = static_cast<Eigen::Index>(times.size());
  PoseTrack poses;
  poses.name = path;
  poses.times = Eigen::Map<Eigen::VectorXd>(times.data(), count);
  poses.positions = Eigen::Map<Eigen::Matrix3Xd>(positions.data(), 3, count);
  poses.rotations = Eigen::Map<Eigen::Matrix4Xd>(rotations.data(), 4, count);
  return poses;
}

}  // namespace clothid
