#include "datasets/formats/tracks_csv.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "datasets/formats/track_cells.h"
#include "datasets/formats/track_checks.h"
#include "sim/base/csv_row.h"
#include "sim/base/error.h"
#include "sim/base/frame_names.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

constexpr std::array<std::string_view, 5> kColumns = {"t", "id", "x", "y", "z"};
enum Column { kT, kId, kX };

// Where the five columns stand; the number of cells where one is missing, or there twice.
std::array<std::size_t, 5> FindColumns(const std::vector<std::string>& cells) {
  std::array<std::size_t, 5> places;
  for (std::size_t k = 0; k < kColumns.size(); ++k) {
    const auto found = std::find(cells.begin(), cells.end(), kColumns[k]);
    const bool is_alone = found != cells.end() && std::find(found + 1, cells.end(), kColumns[k]) == cells.end();
    places[k] = is_alone ? static_cast<std::size_t>(found - cells.begin()) : cells.size();
  }
  return places;
}

// Where a further column stands that tells how well a point was seen; the number of cells where there is none.
std::size_t FindResidual(const std::vector<std::string>& cells) {
  return static_cast<std::size_t>(std::find(cells.begin(), cells.end(), "residual") - cells.begin());
}

// The order that sorts `items`.
template <typename T, typename Less>
std::vector<int> SortingOrder(const std::vector<T>& items, const Less& less) {
  std::vector<int> order(items.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](int a, int b) { return less(items[static_cast<std::size_t>(a)], items[static_cast<std::size_t>(b)]); });
  return order;
}

class TracksCsvReader {
 public:
  explicit TracksCsvReader(const std::string& path) : path_(path) {}

  PointTracks Read() {
    const std::string text = ReadText(path_, kMaxTracksCsvBytes);
    std::string_view rest = text;
    while (const std::optional<std::string_view> line = TakeLine(&rest)) {
      ++line_;
      if (line_ == 1) {
        ReadHeader(*line);
      } else if (!WithoutBlanks(*line).empty()) {
        ReadRow(Cells(*line));
      }
    }
    if (line_ == 0) throw Error(ErrorKind::kBadData, path_ + ": expected the header 't,id,x,y,z' and rows of numbers");
    return Tracks();
  }

 private:
  struct Sample {
    int frame, point;  // in the order of the file
    std::array<double, 3> position;
  };

  [[noreturn]] void Fail(const std::string& message) const {
    throw Error(ErrorKind::kBadData, path_ + ":" + std::to_string(line_) + ": " + message);
  }
  [[noreturn]] void FailInColumn(std::size_t column, const std::string& message) const {
    Fail("column '" + std::string(kColumns[column]) + "': " + message);
  }

  std::vector<std::string> Cells(std::string_view line) const {
    std::optional<std::vector<std::string>> cells = CsvCells(line);
    if (!cells) Fail(kExpectedQuotes);
    return std::move(*cells);
  }

  void ReadHeader(std::string_view line) {
    const std::vector<std::string> cells = Cells(line);
    places_ = FindColumns(cells);
    residual_ = FindResidual(cells);
    num_cells_ = cells.size();
    for (std::size_t k = 0; k < kColumns.size(); ++k) {
      if (places_[k] == num_cells_) FailInColumn(k, "expected once in the header, as in 't,id,x,y,z'");
    }
  }

  void ReadRow(const std::vector<std::string>& cells) {
    if (cells.size() != num_cells_) {
      Fail("expected " + std::to_string(num_cells_) + " cells as in the header, found " + std::to_string(cells.size()));
    }
    const std::optional<double> time = ParseNumber(Trimmed(cells[places_[kT]]));
    if (!time) FailInColumn(kT, "expected a finite number, found '" + Printable(cells[places_[kT]]) + "'");
    if (times_.empty() || *time != times_.back()) BeginFrame(*time);
    Sample sample;
    sample.frame = static_cast<int>(times_.size()) - 1;
    sample.point = Point(cells[places_[kId]], sample.frame);
    for (std::size_t k = 0; k < 3; ++k) {
      const std::string& cell = cells[places_[kX + k]];
      const std::optional<double> value = ParseCoordinate(Trimmed(cell));
      if (!value) FailInColumn(kX + k, "expected a finite number or nothing, found '" + Printable(cell) + "'");
      sample.position[k] = *value;
    }
    if (residual_ < num_cells_ && ParseNumber(Trimmed(cells[residual_])).value_or(0.0) < 0.0) {
      sample.position.fill(std::numeric_limits<double>::quiet_NaN());
    }
    samples_.push_back(sample);
  }

  void BeginFrame(double time) {
    const auto [known, is_new] = first_lines_.try_emplace(time, line_);
    if (!is_new) {
      FailInColumn(kT, "rows of this time stand at line " + std::to_string(known->second) +
                           " already; expected those of one time together");
    }
    times_.push_back(time);
  }

  // The index of the point called `id`, which must not have had a row in this frame.
  int Point(const std::string& id, int frame) {
    if (id.empty()) FailInColumn(kId, "expected a name or a number, found nothing");
    const auto [known, is_new] = points_.try_emplace(id, static_cast<int>(ids_.size()));
    if (is_new) {
      ids_.push_back(id);
      last_frames_.push_back(-1);
    }
    int& last_frame = last_frames_[static_cast<std::size_t>(known->second)];
    if (last_frame == frame) FailInColumn(kId, "'" + Printable(id) + "' has two rows at this time");
    last_frame = frame;
    return known->second;
  }

  PointTracks Tracks() const {
    CheckTrackSize(path_, ids_.size(), times_.size());
    const std::vector<int> points = SortingOrder(ids_, &NaturalLess),
                           frames = SortingOrder(times_, std::less<double>());
    PointTracks tracks;
    tracks.name = path_;
    tracks.times.resize(static_cast<Eigen::Index>(times_.size()));
    std::vector<int> rows(points.size()), columns(frames.size());
    bool is_counted = true;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const std::string& id = ids_[static_cast<std::size_t>(points[i])];
      rows[static_cast<std::size_t>(points[i])] = 3 * static_cast<int>(i);
      tracks.labels.push_back(id);
      is_counted = is_counted && id == std::to_string(i);
    }
    if (is_counted) tracks.labels.clear();
    for (std::size_t i = 0; i < frames.size(); ++i) {
      columns[static_cast<std::size_t>(frames[i])] = static_cast<int>(i);
      tracks.times[static_cast<Eigen::Index>(i)] = times_[static_cast<std::size_t>(frames[i])];
    }
    tracks.positions.setConstant(3 * static_cast<Eigen::Index>(points.size()), tracks.times.size(),
                                 std::numeric_limits<double>::quiet_NaN());
    for (const Sample& sample : samples_) {
      tracks.positions.col(columns[static_cast<std::size_t>(sample.frame)])
          .segment<3>(rows[static_cast<std::size_t>(sample.point)]) = Eigen::Vector3d(sample.position.data());
    }
    return tracks;
  }

  const std::string& path_;
  int line_ = 0;
  std::size_t num_cells_ = 0;
  std::array<std::size_t, 5> places_ = {};
  std::size_t residual_ = 0;  // the column of it; num_cells_: none
  std::vector<double> times_;
  std::unordered_map<double, int> first_lines_;  // of the rows of a time
  std::vector<std::string> ids_;
  std::unordered_map<std::string, int> points_;
  std::vector<int> last_frames_;
  std::vector<Sample> samples_;
};

std::string CsvCell(const std::string& label) {
  if (label.find_first_of(",\"") == std::string::npos && WithoutBlanks(label) == label) return label;
  std::string quoted = "\"";
  for (const char c : label) quoted.append(c == '"' ? 2 : 1, c);
  return quoted + '"';
}

}  // namespace

bool IsTracksCsvHeader(std::string_view line) {
  const std::optional<std::vector<std::string>> cells = CsvCells(line);
  if (!cells) return false;
  const std::array<std::size_t, 5> places = FindColumns(*cells);
  return std::find(places.begin(), places.end(), cells->size()) == places.end();
}

PointTracks ReadTracksCsv(const std::string& path) { return TracksCsvReader(path).Read(); }

std::string TracksCsvText(const PointTracks& tracks) {
  RequireTimes(tracks, "CSV");
  RequirePlainLabels(tracks, "CSV");
  std::string text = "t,id,x,y,z\n";
  for (int frame = 0; frame < tracks.num_frames(); ++frame) {
    const auto positions = tracks.positions.col(frame).reshaped(3, tracks.num_points());
    const std::string time = ShortestText(tracks.times[frame]) + ",";
    const bool is_empty = positions.array().isNaN().all();
    for (int point = 0; point < tracks.num_points(); ++point) {
      const bool is_seen = !positions.col(point).array().isNaN().all();
      if (!is_seen && frame > 0 && !(is_empty && point == 0)) continue;
      text += time;
      text += tracks.labels.empty() ? std::to_string(point) : CsvCell(tracks.labels[static_cast<std::size_t>(point)]);
      for (const double value : positions.col(point)) text += "," + CoordinateText(value);
      text += '\n';
    }
  }
  return text;
}

}  // namespace clothid
