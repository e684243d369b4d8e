#include "datasets/formats/tracks_csv.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <optional>
#include <unordered_map>
#include <vector>

#include "datasets/formats/track_cells.h"
#include "datasets/formats/track_checks.h"
#include "sim/base/error.h"
#include "sim/base/frame_names.h"
#include "sim/base/table.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

constexpr std::array<std::string_view, 5> kColumns = {"t", "id", "x", "y", "z"};
enum Column { kT, kId, kX };

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
  explicit TracksCsvReader(const std::string& path)
      : path_(path), table_(path, ReadText(path, kMaxTracksCsvBytes), "t,id,x,y,z") {}

  PointTracks Read() {
    for (std::size_t k = 0; k < kColumns.size(); ++k) places_[k] = table_.Require(kColumns[k]);
    residual_ = table_.Find("residual");
    while (table_.NextRow()) ReadRow();
    return Tracks();
  }

 private:
  struct Sample {
    int frame, point;  // in the order of the file
    std::array<double, 3> position;
  };

  [[noreturn]] void FailInColumn(std::size_t column, const std::string& message) const {
    table_.Fail("column '" + std::string(kColumns[column]) + "': " + message);
  }

  void ReadRow() {
    const double time = table_.Number(places_[kT], Quantity::kTime);
    if (times_.empty() || time != times_.back()) BeginFrame(time);
    Sample sample;
    sample.frame = static_cast<int>(times_.size()) - 1;
    sample.point = Point(table_.cell(places_[kId]), sample.frame);
    for (std::size_t k = 0; k < 3; ++k) {
      sample.position[k] = table_.NumberOrNothing(places_[kX + k], Quantity::kLength);
    }
    if (residual_ && ParseNumber(table_.Digits(*residual_)).value_or(0.0) < 0.0) {
      sample.position.fill(std::numeric_limits<double>::quiet_NaN());
    }
    samples_.push_back(sample);
  }

  void BeginFrame(double time) {
    const auto [known, is_new] = first_lines_.try_emplace(time, table_.line());
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
  Table table_;
  std::array<std::size_t, 5> places_ = {};
  std::optional<std::size_t> residual_;  // the column that tells how well a point was seen
  std::vector<double> times_;
  std::unordered_map<double, int> first_lines_;  // of the rows of a time
  std::vector<std::string> ids_;
  std::unordered_map<std::string, int> points_;
  std::vector<int> last_frames_;
  std::vector<Sample> samples_;
};

std::string CsvCell(const std::string& label) {
  if (label.find_first_of(",\"") == std::string::npos && Trimmed(label) == label) return label;
  std::string quoted = "\"";
  for (const char c : label) quoted.append(c == '"' ? 2 : 1, c);
  return quoted + '"';
}

}  // namespace

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
