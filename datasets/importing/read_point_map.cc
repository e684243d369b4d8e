// Point maps from files: datasets/importing/point_map.h.
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "datasets/importing/point_map.h"
#include "sim/base/table.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

constexpr double kBarycentricTolerance = 1e-6;  // of their sum

// A row of a point map.
struct Entry {
  int node = -1, face = -1;
  Eigen::Vector3d barycentric = Eigen::Vector3d::Zero();
};

class PointMapReader {
 public:
  PointMapReader(const std::string& path, const PointTracks& tracks, const Mesh& mesh)
      : table_(path, ReadText(path, kMaxPointMapBytes), "id,node' or 'id,face,b0,b1,b2"), tracks_(tracks), mesh_(mesh) {
    for (std::size_t p = 0; p < tracks.labels.size(); ++p) labels_[tracks.labels[p]] = static_cast<int>(p);
  }

  PointMap Read() {
    const std::size_t id = table_.Require("id");
    const auto node = table_.Find("node"), face = table_.Find("face");
    if (node.has_value() == face.has_value()) table_.FailOnHeader("expected a column 'node' or 'face'");
    if (face) place_ = {*face, table_.Require("b0"), table_.Require("b1"), table_.Require("b2")};
    std::map<int, Entry> entries;
    while (table_.NextRow()) {
      const Entry entry = node ? Entry{ReadIndex(*node, mesh_.num_nodes(), "a node")} : ReadPlace();
      if (!entries.emplace(ReadId(id), entry).second) table_.FailAt(id, "every point once");
    }
    if (entries.empty()) table_.FailWithoutRows();
    return ToMap(entries, node.has_value());
  }

 private:
  int ReadIndex(std::size_t column, int count, const std::string& what) const {
    const std::optional<long long> index = ParseInteger(table_.cell(column));
    if (!index || *index < 0 || *index >= count) {
      table_.FailAt(column, what + " from 0 to " + std::to_string(count - 1));
    }
    return static_cast<int>(*index);
  }

  int ReadId(std::size_t column) const {
    if (tracks_.labels.empty()) return ReadIndex(column, tracks_.num_points(), "the number of a point");
    const auto found = labels_.find(table_.cell(column));
    if (found == labels_.end()) table_.FailAt(column, "the label of a point of " + tracks_.name);
    return found->second;
  }

  Entry ReadPlace() {
    Entry entry;
    entry.face = ReadIndex(place_[0], mesh_.num_faces(), "a triangle");
    for (std::size_t k = 0; k < 3; ++k) {
      entry.barycentric[static_cast<Eigen::Index>(k)] = table_.Number(place_[1 + k], Quantity::kNumber);
    }
    if (!(std::abs(entry.barycentric.sum() - 1.0) <= kBarycentricTolerance)) {
      table_.Fail("expected barycentric coordinates that sum to 1");
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

  Table table_;
  const PointTracks& tracks_;
  const Mesh& mesh_;
  std::map<std::string, int> labels_;
  std::array<std::size_t, 4> place_ = {};  // the columns of face, b0, b1 and b2
};

}  // namespace

PointMap ReadPointMap(const std::string& path, const PointTracks& tracks, const Mesh& mesh) {
  return PointMapReader(path, tracks, mesh).Read();
}

}  // namespace clothid
