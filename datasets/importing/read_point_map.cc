// Point maps from files: datasets/importing/point_map.h.
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "datasets/importing/point_map.h"
#include "sim/base/csv_row.h"
#include "sim/base/error.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

const std::vector<std::string> kNodeColumns = {"id", "node"};
const std::vector<std::string> kFaceColumns = {"id", "face", "b0", "b1", "b2"};
constexpr double kBarycentricTolerance = 1e-6;  // of their sum

// A row of a point map.
struct Entry {
  int node = -1, face = -1;
  Eigen::Vector3d barycentric = Eigen::Vector3d::Zero();
};

class PointMapReader {
 public:
  PointMapReader(const std::string& path, const PointTracks& tracks, const Mesh& mesh)
      : path_(path), tracks_(tracks), mesh_(mesh) {
    for (std::size_t p = 0; p < tracks.labels.size(); ++p) labels_[tracks.labels[p]] = static_cast<int>(p);
  }

  PointMap Read() {
    const std::string text = ReadText(path_, kMaxPointMapBytes);
    std::string_view rest = text;
    std::map<int, Entry> entries;
    bool of_nodes = true;
    while (std::optional<std::string_view> line = TakeLine(&rest)) {
      ++line_;
      const std::optional<std::vector<std::string>> found = CsvCells(*line);
      if (!found) throw Error(ErrorKind::kBadData, path_ + ":" + std::to_string(line_) + ": " + kExpectedQuotes);
      const std::vector<std::string>& cells = *found;
      if (line_ == 1) {
        of_nodes = cells == kNodeColumns;
        if (!of_nodes && cells != kFaceColumns) FailHere("the header 'id,node' or 'id,face,b0,b1,b2'");
      } else if (!Trimmed(*line).empty()) {
        if (cells.size() != (of_nodes ? 2U : 5U)) FailHere(of_nodes ? "two cells" : "five cells");
        if (!entries.emplace(ReadId(cells[0]), ReadEntry(cells, of_nodes)).second) FailHere("every id once");
      }
    }
    if (entries.empty()) FailHere("a header and at least one row");
    return ToMap(entries, of_nodes);
  }

 private:
  [[noreturn]] void FailHere(const std::string& expected) const {
    throw Error(ErrorKind::kBadData, path_ + ":" + std::to_string(line_) + ": expected " + expected);
  }

  int ReadIndex(const std::string& cell, int count, const std::string& what) const {
    const std::optional<long long> index = ParseInteger(cell);
    if (!index || *index < 0 || *index >= count) {
      FailHere(what + " from 0 to " + std::to_string(count - 1) + ", found '" + Printable(cell) + "'");
    }
    return static_cast<int>(*index);
  }

  int ReadId(const std::string& cell) const {
    if (tracks_.labels.empty()) return ReadIndex(cell, tracks_.num_points(), "the number of a point");
    const auto found = labels_.find(cell);
    if (found == labels_.end())
      FailHere("the label of a point of " + tracks_.name + ", found '" + Printable(cell) + "'");
    return found->second;
  }

  Entry ReadEntry(const std::vector<std::string>& cells, bool of_nodes) const {
    Entry entry;
    if (of_nodes) {
      entry.node = ReadIndex(cells[1], mesh_.num_nodes(), "a node");
      return entry;
    }
    entry.face = ReadIndex(cells[1], mesh_.num_faces(), "a triangle");
    for (std::size_t k = 0; k < 3; ++k) {
      const std::optional<double> weight = ParseNumber(cells[2 + k]);
      if (!weight) FailHere("three finite barycentric coordinates");
      entry.barycentric[static_cast<Eigen::Index>(k)] = *weight;
    }
    if (!(std::abs(entry.barycentric.sum() - 1.0) <= kBarycentricTolerance)) {
      FailHere("barycentric coordinates that sum to 1");
    }
    return entry;
  }

  static PointMap ToMap(const std::map<int, Entry>& entries, bool of_nodes) {
    PointMap map;
    if (!of_nodes) map.barycentric.resize(3, static_cast<Eigen::Index>(entries.size()));
    for (const auto& [point, entry] : entries) {
      if (of_nodes) {
        map.node_index.push_back(entry.node);
      } else {
        map.barycentric.col(static_cast<Eigen::Index>(map.points.size())) = entry.barycentric;
        map.face_index.push_back(entry.face);
      }
      map.points.push_back(point);
    }
    return map;
  }

  const std::string& path_;
  const PointTracks& tracks_;
  const Mesh& mesh_;
  std::map<std::string, int> labels_;
  int line_ = 0;
};

}  // namespace

PointMap ReadPointMap(const std::string& path, const PointTracks& tracks, const Mesh& mesh) {
  return PointMapReader(path, tracks, mesh).Read();
}

}  // namespace clothid
