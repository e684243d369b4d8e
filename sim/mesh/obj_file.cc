#include "sim/mesh/obj_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

#include "sim/base/error.h"
#include "sim/base/text_file.h"
#include "sim/geometry/polygon.h"

namespace clothid {
namespace {

constexpr long long kMaxTextureCoordinates = 3LL * kMaxFaces;
// Twice the area of a triangle of the UV map that counts as none, relative to its longest side squared.
constexpr double kOnALine = 1e-6;

// What the UV map is read for.
enum class UvUse { kNone, kWarp, kRest };

// The lines of a file, with those that they go on in: a backslash at the end says so. Where they hold numbers, without
// the comment after them; names may have '#'.
class ObjStatements {
 public:
  explicit ObjStatements(std::string_view text) : rest_(text) {}

  std::optional<std::string_view> Take() {
    line_ += num_lines_;
    num_lines_ = 1;
    const std::optional<std::string_view> line = TakeLine(&rest_);
    std::string_view words = line.value_or("");
    const std::string_view keyword = TakeWord(&words);
    const bool has_names = keyword == "g";
    if (!has_names && keyword != "v" && keyword != "vt" && keyword != "f") return line;
    const auto content = [&](std::string_view text) {
      return Trimmed(has_names ? text : text.substr(0, text.find('#')));
    };
    const auto goes_on = [](std::string_view text) { return !text.empty() && text.back() == '\\'; };
    if (!goes_on(content(*line))) return content(*line);
    whole_.assign(content(*line));
    while (goes_on(whole_)) {
      whole_.back() = ' ';
      const std::optional<std::string_view> next = TakeLine(&rest_);
      if (!next) break;
      ++num_lines_;
      whole_.append(content(*next));
    }
    return whole_;
  }

  int line() const { return line_; }  // the first one of what was taken last, from 1 on

 private:
  std::string_view rest_;
  std::string whole_;  // what stands in several lines
  int line_ = 0, num_lines_ = 1;
};

// Collects the lines of an OBJ file. Of its UV map, where that is asked for.
class ObjReader {
 public:
  // `like` (may be null): triangles that those of polygons are to be.
  ObjReader(const std::string& path, UvUse use, FaceGroups* groups, const Eigen::Matrix3Xi* like = nullptr)
      : path_(path), use_(use), groups_(groups), like_(like) {}

  Mesh Read() {
    const std::string text = ReadText(path_, kMaxObjBytes);
    ObjStatements statements(text);
    while (std::optional<std::string_view> line = statements.Take()) {
      line_ = statements.line();
      const std::string_view keyword = TakeWord(&*line);
      if (keyword == "v") ReadVertex(*line);
      if (keyword == "vt" && use_ != UvUse::kNone) ReadTextureCoordinates(*line);
      if (keyword == "f") ReadFace(*line);
      if (groups_ == nullptr) continue;
      if (keyword == "g") Begin(*line, &group_);
      if (keyword == "usemtl") Begin(*line, &material_);
    }
    if (groups_ != nullptr) {
      for (OpenGroups* open : {&group_, &material_}) End(open);
    }
    Mesh mesh;
    mesh.rest_positions = Eigen::Map<Eigen::Matrix3Xd>(coordinates_.data(), 3, NumVertices());
    mesh.faces = Eigen::Map<Eigen::Matrix3Xi>(indices_.data(), 3, NumFaces());
    return mesh;
  }

  Eigen::Matrix2Xd corner_uv() const {
    return Eigen::Map<const Eigen::Matrix2Xd>(corner_uv_.data(), 2, 3 * NumFaces());
  }
  Eigen::Matrix3Xd along_u() const { return Eigen::Map<const Eigen::Matrix3Xd>(along_u_.data(), 3, NumFaces()); }

 private:
  struct Corner {
    int vertex = 0;
    Eigen::Vector2d uv = Eigen::Vector2d::Zero();
  };

  // Names that the next triangles have, of one keyword.
  struct OpenGroups {
    std::vector<std::string> names;
    Eigen::Index first = 0;
  };

  void Begin(std::string_view line, OpenGroups* open) {
    End(open);
    open->first = NumFaces();
    for (std::string_view name = TakeWord(&line); !name.empty(); name = TakeWord(&line)) {
      open->names.emplace_back(name);
      (*groups_)[open->names.back()];
    }
  }

  void End(OpenGroups* open) {
    for (const std::string& name : open->names) {
      const FaceRange range = {static_cast<int>(open->first), static_cast<int>(NumFaces()) - 1};
      if (range[0] <= range[1]) (*groups_)[name].push_back(range);
    }
    open->names.clear();
  }

  [[noreturn]] void FailHere(const std::string& message) const {
    throw Error(ErrorKind::kBadData, path_ + ":" + std::to_string(line_) + ": " + message);
  }

  Eigen::Index NumVertices() const { return static_cast<Eigen::Index>(coordinates_.size() / 3); }
  Eigen::Index NumFaces() const { return static_cast<Eigen::Index>(indices_.size() / 3); }
  long long NumTextureCoordinates() const { return static_cast<long long>(uv_.size() / 2); }

  Eigen::Vector3d Vertex(const Corner& corner) const {
    return Eigen::Map<const Eigen::Vector3d>(&coordinates_[3 * static_cast<std::size_t>(corner.vertex)]);
  }

  void ReadVertex(std::string_view line) {
    if (NumVertices() == kMaxNodes) FailHere("more than " + std::to_string(kMaxNodes) + " vertices");
    ReadNumbers(line, 3, "three finite numbers after 'v'", &coordinates_);
  }

  void ReadTextureCoordinates(std::string_view line) {
    if (NumTextureCoordinates() == kMaxTextureCoordinates) {
      FailHere("more than " + std::to_string(kMaxTextureCoordinates) + " texture coordinates");
    }
    ReadNumbers(line, 2, "two finite numbers after 'vt'", &uv_);
  }

  void ReadNumbers(std::string_view line, int count, const char* expected, std::vector<double>* numbers) const {
    for (int k = 0; k < count; ++k) {
      const std::string_view word = TakeWord(&line);
      const std::optional<double> value = ParseNumber(word);
      if (!value) FailHere(std::string("expected ") + expected + ", found '" + Printable(word) + "'");
      numbers->push_back(*value);
    }
  }

  // An index counts from 1; a negative one counts back from the last so far. Nothing where it names none.
  static std::optional<long long> Place(std::string_view index_text, long long count) {
    const std::optional<long long> index = ParseInteger(index_text);
    if (!index || *index == 0 || *index > count || *index < -count) return std::nullopt;
    return *index > 0 ? *index - 1 : count + *index;
  }

  // "7", "7/1" or "7/1/2": vertex, texture coordinates, normal.
  Corner ReadCorner(std::string_view word) const {
    const std::size_t slash = word.find('/');
    const std::optional<long long> vertex = Place(word.substr(0, slash), NumVertices());
    if (!vertex) {
      FailHere("face corner '" + Printable(word) + "' is not one of the " + std::to_string(NumVertices()) +
               " vertices before it");
    }
    Corner corner;
    corner.vertex = static_cast<int>(*vertex);
    if (use_ != UvUse::kNone) corner.uv = ReadUv(word, slash == std::string_view::npos ? "" : word.substr(slash + 1));
    return corner;
  }

  Eigen::Vector2d ReadUv(std::string_view word, std::string_view after_vertex) const {
    const std::string_view text = after_vertex.substr(0, after_vertex.find('/'));
    const std::string corner = "face corner '" + Printable(word) + "' of triangle " + std::to_string(NumFaces());
    if (text.empty()) FailHere(corner + " has no texture coordinates, which " + purpose());
    const std::optional<long long> place = Place(text, NumTextureCoordinates());
    if (!place) {
      FailHere(corner + " has none of the " + std::to_string(NumTextureCoordinates()) +
               " texture coordinates before it");
    }
    return Eigen::Map<const Eigen::Vector2d>(&uv_[2 * static_cast<std::size_t>(*place)]);
  }

  void ReadFace(std::string_view line) {
    std::vector<Corner> corners;
    for (std::string_view word = TakeWord(&line); !word.empty(); word = TakeWord(&line)) {
      corners.push_back(ReadCorner(word));
    }
    if (corners.size() < 3) FailHere("expected at least three corners after 'f'");
    const std::size_t num_faces = indices_.size() / 3 + corners.size() - 2;
    if (num_faces > kMaxFaces) FailHere("more than " + std::to_string(kMaxFaces) + " triangles");
    for (const auto& [a, b, c] : Cut(corners)) {
      const std::array<Corner, 3> triangle = {corners[a], corners[b], corners[c]};
      if (use_ != UvUse::kNone) AddUv(triangle);
      for (const Corner& corner : triangle) indices_.push_back(corner.vertex);
    }
  }

  // The triangles of a polygon, where it lies as the cloth does at rest.
  std::vector<std::array<int, 3>> Cut(const std::vector<Corner>& corners) const {
    if (like_ != nullptr) {
      std::vector<int> vertices;
      for (const Corner& corner : corners) vertices.push_back(corner.vertex);
      std::vector<std::array<int, 3>> triangles = TrianglesLike(*like_, NumFaces(), vertices);
      if (!triangles.empty()) return triangles;
    }
    Eigen::Matrix3Xd places = Eigen::Matrix3Xd::Zero(3, static_cast<Eigen::Index>(corners.size()));
    for (Eigen::Index i = 0; i < places.cols(); ++i) {
      if (use_ == UvUse::kRest) {
        places.col(i).head<2>() = corners[i].uv;
      } else {
        places.col(i) = Vertex(corners[i]);
      }
    }
    std::vector<std::array<int, 3>> triangles = TrianglesOfPolygon(places);
    if (triangles.empty()) {
      FailHere("the polygon of " + std::to_string(corners.size()) +
               " corners crosses or touches itself, or has no area; expected one that can be cut into triangles");
    }
    return triangles;
  }

  const char* purpose() const { return use_ == UvUse::kWarp ? "the warp is to follow" : "are to be its shape at rest"; }

  // X is linear over the triangle, so that its edges are dX/du du + dX/dv dv.
  void AddUv(const std::array<Corner, 3>& triangle) {
    const Eigen::Vector2d a = triangle[1].uv - triangle[0].uv, b = triangle[2].uv - triangle[0].uv;
    const double longest = std::max({a.squaredNorm(), b.squaredNorm(), (b - a).squaredNorm()});
    const double twice_area = a.x() * b.y() - a.y() * b.x();
    if (!(std::abs(twice_area) > kOnALine * longest)) {
      const std::string missing = use_ == UvUse::kWarp ? " has no direction of u, which the warp is to follow"
                                                       : " has no area in the UV map, its shape at rest";
      FailHere("triangle " + std::to_string(NumFaces()) + missing + ": its texture coordinates lie on a line");
    }
    for (const Corner& corner : triangle) corner_uv_.insert(corner_uv_.end(), corner.uv.begin(), corner.uv.end());
    const Eigen::Vector3d origin = Vertex(triangle[0]);
    const double scale = std::copysign(1.0 / std::sqrt(longest), twice_area);
    const Eigen::Vector3d direction =
        (scale * b.y() * (Vertex(triangle[1]) - origin) - scale * a.y() * (Vertex(triangle[2]) - origin))
            .stableNormalized();
    along_u_.insert(along_u_.end(), direction.begin(), direction.end());
  }

  const std::string& path_;
  const UvUse use_;
  FaceGroups* const groups_;  // null: not asked for
  const Eigen::Matrix3Xi* const like_;
  int line_ = 0;                          // the first one of a statement
  OpenGroups group_, material_;           // of `g`, of `usemtl`
  std::vector<double> coordinates_, uv_;  // of vertices, three each, and of `vt` lines, two each
  std::vector<int> indices_;              // of faces, three each
  std::vector<double> along_u_;           // of faces, three each
  std::vector<double> corner_uv_;         // of faces, six each
};

}  // namespace

Mesh ReadObj(const std::string& path) { return ObjReader(path, UvUse::kNone, nullptr).Read(); }

Mesh ReadObjLike(const std::string& path, const Eigen::Matrix3Xi& faces) {
  return ObjReader(path, UvUse::kNone, nullptr, &faces).Read();
}

Mesh ReadObjWithGroups(const std::string& path, FaceGroups* groups) {
  return ObjReader(path, UvUse::kNone, groups).Read();
}

Mesh ReadObjWithUv(const std::string& path, Eigen::Matrix3Xd* along_u, FaceGroups* groups) {
  ObjReader reader(path, UvUse::kWarp, groups);
  Mesh mesh = reader.Read();
  *along_u = reader.along_u();
  return mesh;
}

Mesh ReadObjWithUvRest(const std::string& path, double scale, FaceGroups* groups) {
  ObjReader reader(path, UvUse::kRest, groups);
  Mesh mesh = reader.Read();
  mesh.corner_rest = scale * reader.corner_uv();
  return mesh;
}

std::string PlaceInObj(const std::string& path, MeshPart part) {
  const std::string text = ReadText(path, kMaxObjBytes);
  ObjStatements statements(text);
  int num_faces = 0, num_nodes = 0;
  while (std::optional<std::string_view> line = statements.Take()) {
    const std::string_view keyword = TakeWord(&*line);
    if (keyword == "v") ++num_nodes;
    if (keyword == "f") {
      num_faces -= 2;
      for (auto word = TakeWord(&*line); !word.empty(); word = TakeWord(&*line)) ++num_faces;
    }
    const bool is_face = part.face >= 0 && num_faces > part.face, is_node = part.node >= 0 && num_nodes > part.node;
    if (is_face || is_node) return path + ":" + std::to_string(statements.line());
  }
  return path;
}

void ValidateObjMesh(const Mesh& mesh, const std::string& path) {
  std::string fault;
  MeshPart part;
  try {
    return ValidateMesh(mesh, path);
  } catch (const MeshError& error) {
    fault = error.fault();
    part = error.part();
  }
  FailOnData(PlaceInObj(path, part), fault);
}

}  // namespace clothid
