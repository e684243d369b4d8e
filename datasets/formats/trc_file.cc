#include "datasets/formats/trc_file.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "datasets/formats/track_cells.h"
#include "datasets/formats/track_checks.h"
#include "sim/base/csv_row.h"
#include "sim/base/error.h"
#include "sim/base/table.h"
#include "sim/base/text_file.h"
#include "sim/mesh/mesh.h"

namespace clothid {
namespace {

constexpr std::size_t kFirstCoordinate = 2;  // cells before it: number and time of the frame
constexpr double kUnseen = std::numeric_limits<double>::quiet_NaN();
constexpr double kTimeRounding = 1e-3;  // s: some programs write times with three decimals
constexpr double kRateRounding = 0.01;  // relative: and rates with one

std::vector<std::string> Words(std::string_view line) {
  std::vector<std::string> words;
  while (true) {
    line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
    const std::string_view word = TakeWord(&line);
    if (word.empty()) return words;
    words.emplace_back(word);
  }
}

class TrcReader {
 public:
  explicit TrcReader(const std::string& path) : path_(path), text_(ReadText(path, kMaxTrcBytes)), rest_(text_) {}

  PointTracks Read() {
    ReadType();
    ReadProperties();
    ReadLabels();
    if (Words(NextLine("X1, Y1, Z1, .."))[0].front() != 'X') Fail("expected X1, Y1, Z1, ..");
    CheckTrackSize(path_, tracks_.labels.size(), num_frames_);
    // A row has at least a character for every cell: no memory for more than the file can hold.
    if (num_frames_ * 3 * tracks_.labels.size() > rest_.size()) FailAt(3, "the rows end before NumFrames");
    tracks_.name = path_;
    tracks_.times.resize(static_cast<Eigen::Index>(num_frames_));
    tracks_.positions.resize(3 * static_cast<Eigen::Index>(tracks_.labels.size()), tracks_.times.size());
    ReadRows();
    CheckRate();
    return std::move(tracks_);
  }

 private:
  [[noreturn]] void FailAt(int line, const std::string& message) const {
    throw Error(ErrorKind::kBadData, path_ + ":" + std::to_string(line) + ": " + message);
  }
  [[noreturn]] void Fail(const std::string& message) const { FailAt(line_, message); }

  // The next line of the header, which must hold a word.
  std::string_view NextLine(const std::string& expected) {
    const std::optional<std::string_view> line = TakeLine(&rest_);
    ++line_;
    if (!line || Trimmed(*line).empty()) Fail("expected " + expected);
    return *line;
  }

  void ReadType() {
    const std::vector<std::string> words = Words(NextLine("PathFileType"));
    if (words[0] != "PathFileType") Fail("is not a TRC file: expected PathFileType");
    if (words.size() < 3 || words[1] != "4" || words[2] != "(X/Y/Z)") Fail("expected 'PathFileType 4 (X/Y/Z)'");
  }

  void ReadProperties() {
    const std::vector<std::string> names = Words(NextLine("DataRate, NumFrames, NumMarkers and Units"));
    const std::vector<std::string> values = Words(NextLine("the values of DataRate, .."));
    const auto find = [&](const std::string& name) {
      const auto found = std::find(names.begin(), names.end(), name);
      if (found == names.end()) FailAt(2, "expected " + name);
      const auto place = static_cast<std::size_t>(found - names.begin());
      if (place >= values.size()) Fail("the value of " + name + " is missing");
      return values[place];
    };
    const auto count = [&](const std::string& name, long long most) {
      const std::optional<long long> value = ParseInteger(find(name));
      if (!value || *value < 1 || *value > most) {
        Fail("expected " + name + " to be an integer from 1 to " + std::to_string(most) + ", found '" +
             Printable(find(name)) + "'");
      }
      return static_cast<std::size_t>(*value);
    };
    const std::optional<double> rate = CellNumbers('\t').Parse(find("DataRate"));
    if (!rate || *rate <= 0.0) Fail("expected DataRate > 0, found '" + Printable(find("DataRate")) + "'");
    data_rate_ = *rate;
    num_frames_ = count("NumFrames", kMaxFrames);
    num_markers_ = count("NumMarkers", kMaxNodes);
    const std::optional<Unit> unit = FindUnit(find("Units"));
    if (!unit || unit->quantity != Quantity::kLength) {
      Fail("expected Units m, cm or mm, found '" + Printable(find("Units")) + "'");
    }
    tracks_.units_per_metre = unit->per_si;
  }

  void ReadLabels() {
    std::string_view line = NextLine("Frame#, Time and the labels");
    if (TakeWord(&line) != "Frame#" || TakeWord(&line) != "Time") Fail("expected Frame#, Time and the labels");
    for (const std::string& cell : Split(line, '\t')) {
      if (const std::string_view label = Trimmed(cell); !label.empty()) tracks_.labels.emplace_back(label);
    }
    if (tracks_.labels.size() != num_markers_) {
      Fail("found " + std::to_string(tracks_.labels.size()) + " labels, expected " + std::to_string(num_markers_) +
           ", NumMarkers of line 3" + (line.find('\t') == std::string_view::npos ? kTornTabs : ""));
    }
  }

  void ReadRows() {
    std::size_t frame = 0;
    while (const std::optional<std::string_view> line = TakeLine(&rest_)) {
      ++line_;
      if (Trimmed(*line).empty()) continue;
      if (frame == num_frames_) Fail("expected no further row: NumFrames of line 3 is " + std::to_string(num_frames_));
      ReadRow(*line, static_cast<Eigen::Index>(frame++));
    }
    if (frame < num_frames_) {
      FailAt(line_ + 1, "expected a row: NumFrames of line 3 is " + std::to_string(num_frames_) + ", found " +
                            std::to_string(frame));
    }
  }

  void ReadRow(std::string_view line, Eigen::Index frame) {
    const std::vector<std::string> cells = Cells(line);
    const std::size_t num_cells = kFirstCoordinate + 3 * num_markers_;
    const auto is_blank = [](const std::string& cell) { return cell.empty(); };
    if (cells.size() < num_cells ||
        !std::all_of(cells.begin() + static_cast<std::ptrdiff_t>(num_cells), cells.end(), is_blank)) {
      Fail("expected " + std::to_string(num_cells) + " cells between tabs, number, time and " +
           std::to_string(num_markers_) + " times X, Y, Z, found " + std::to_string(cells.size()) +
           (cells.size() == 1 ? kTornTabs : ""));
    }
    const double number = Number(cells[0], "the number of the frame");
    const double time = Number(cells[1], "the time");
    if (frame == 0) first_number_ = number;
    if (frame > 0 && !(number > last_number_)) Fail("expected frame numbers to increase");
    if (frame > 0 && !(time > tracks_.times[frame - 1])) Fail("expected times to increase");
    last_number_ = number;
    tracks_.times[frame] = time;
    for (std::size_t i = kFirstCoordinate; i < num_cells; ++i) {
      const bool is_unseen = cells[i].empty() || IsNanWord(cells[i]);
      const std::optional<double> value = is_unseen ? kUnseen : numbers_.Parse(cells[i]);
      if (!value) {
        const std::size_t axis = (i - kFirstCoordinate) % 3, marker = (i - kFirstCoordinate) / 3;
        Fail(std::string(1, "XYZ"[axis]) + " of '" + Printable(tracks_.labels[marker]) +
             "': expected a finite number or nothing, found '" + Printable(cells[i]) + "'" +
             numbers_.LikelyCause(cells[i]));
      }
      tracks_.positions(static_cast<Eigen::Index>(i - kFirstCoordinate), frame) = *value / tracks_.units_per_metre;
    }
  }

  std::vector<std::string> Cells(std::string_view line) const {
    std::vector<std::string> cells;
    if (!SplitCells(line, '\t', &cells)) Fail(kExpectedQuotes);
    return cells;
  }

  double Number(const std::string& cell, const std::string& what) {
    const std::optional<double> value = numbers_.Parse(cell);
    if (!value) Fail("expected " + what + ", found '" + Printable(cell) + "'" + numbers_.LikelyCause(cell));
    return *value;
  }

  void CheckRate() const {
    if (num_frames_ < 2) return;
    const double span = tracks_.times[tracks_.times.size() - 1] - tracks_.times[0];
    const double steps = last_number_ - first_number_;
    const double expected = steps / data_rate_;
    if (std::abs(span - expected) <= kTimeRounding + kRateRounding * expected) return;
    FailAt(3, "DataRate is " + ShortestText(data_rate_) + " per s, the rows' numbers and times make it " +
                  ShortestText(steps / span));
  }

  const std::string& path_;
  const std::string text_;
  std::string_view rest_;
  int line_ = 0;
  CellNumbers numbers_{'\t'};
  double data_rate_ = 0.0;  // Hz
  std::size_t num_frames_ = 0, num_markers_ = 0;
  double first_number_ = 0.0, last_number_ = 0.0;
  PointTracks tracks_;
};

std::string Label(const PointTracks& tracks, int point) {
  if (tracks.labels.empty()) return "point_" + std::to_string(point);
  const std::string& label = tracks.labels[static_cast<std::size_t>(point)];
  if (Trimmed(label) == label) return label;
  throw Error(ErrorKind::kUsage, tracks.name + ": label '" + Printable(label) + "' has blanks at its ends, TRC cannot");
}

// Frames per second on average, finite. A single frame has no rate, and the format wants one.
double MeanRate(const Eigen::VectorXd& times) {
  const Eigen::Index last = times.size() - 1;
  if (last == 0) return 1.0;
  return std::min(static_cast<double>(last) / (times[last] - times[0]), std::numeric_limits<double>::max());
}

}  // namespace

PointTracks ReadTrc(const std::string& path) { return TrcReader(path).Read(); }

std::string TrcText(const PointTracks& tracks) {
  RequireTimes(tracks, "TRC");
  RequirePlainLabels(tracks, "TRC");
  const std::string rate = ShortestText(MeanRate(tracks.times));
  const std::string num_frames = std::to_string(tracks.num_frames());
  std::string text = "PathFileType\t4\t(X/Y/Z)\tclothid\n";
  text += "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\n";
  text += rate + '\t' + rate + '\t' + num_frames + '\t' + std::to_string(tracks.num_points()) + "\tm\t" + rate +
          "\t1\t" + num_frames + "\nFrame#\tTime";
  std::string axes = "\t";
  for (int point = 0; point < tracks.num_points(); ++point) {
    const std::string number = std::to_string(point + 1);
    text += '\t' + Label(tracks, point) + "\t\t";
    axes += "\tX" + number + "\tY" + number + "\tZ" + number;
  }
  text += '\n' + axes + "\n\n";
  for (int frame = 0; frame < tracks.num_frames(); ++frame) {
    text += std::to_string(frame + 1) + '\t' + ShortestText(tracks.times[frame]);
    for (const double value : tracks.positions.col(frame)) text += '\t' + CoordinateText(value);
    text += '\n';
  }
  return text;
}

}  // namespace clothid
