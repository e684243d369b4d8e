#include "datasets/formats/polygon_mesh.h"

#include <array>

#include "sim/base/error.h"
#include "sim/geometry/polygon.h"

namespace clothid {
namespace {

using PolygonTriangles = std::vector<std::array<int, 3>>;

PolygonTriangles FanOfPolygon(std::size_t num_corners) {
  PolygonTriangles triangles;
  for (int k = 2; k < static_cast<int>(num_corners); ++k) triangles.push_back({0, k - 1, k});
  return triangles;
}

// As it lies; empty where it is seen, and crosses itself.
PolygonTriangles CutWhereSeen(const std::vector<int>& corners, const Eigen::MatrixXd& frames) {
  bool is_seen = false;
  Eigen::Matrix3Xd places(3, static_cast<Eigen::Index>(corners.size()));
  for (Eigen::Index frame = 0; frame < frames.cols(); ++frame) {
    for (std::size_t k = 0; k < corners.size(); ++k) {
      places.col(static_cast<Eigen::Index>(k)) =
          frames.col(frame).segment<3>(3 * static_cast<Eigen::Index>(corners[k]));
    }
    if (!places.allFinite()) continue;
    is_seen = true;
    PolygonTriangles triangles = TrianglesOfPolygon(places);
    if (!triangles.empty()) return triangles;
  }
  return is_seen ? PolygonTriangles() : FanOfPolygon(corners.size());
}

[[noreturn]] void FailOnPolygon(const std::string& path, const PolygonMesh& mesh, std::size_t face) {
  const std::string place =
      mesh.lines.empty() ? ": face " + std::to_string(face) : ":" + std::to_string(mesh.lines[face]);
  FailOnData(path + place,
             "the polygon of " + std::to_string(mesh.sizes[face]) +
                 " corners crosses or touches itself, or has no area; expected one that can be cut into triangles");
}

}  // namespace

PolygonMesh OfTriangles(const Eigen::Matrix3Xi& faces) {
  PolygonMesh mesh;
  const auto corners = faces.reshaped();
  mesh.corners.assign(corners.begin(), corners.end());
  mesh.sizes.assign(static_cast<std::size_t>(faces.cols()), 3);
  return mesh;
}

Eigen::Matrix3Xi CutPolygons(const std::string& path, const PolygonMesh& mesh, const Eigen::MatrixXd& frames,
                             const PolygonMesh* like) {
  Eigen::Matrix3Xi like_faces;
  if (like != nullptr) {
    like_faces =
        Eigen::Map<const Eigen::Matrix3Xi>(like->corners.data(), 3, static_cast<Eigen::Index>(like->sizes.size()));
  }
  Eigen::Matrix3Xi faces(3, static_cast<Eigen::Index>(mesh.corners.size() - 2 * mesh.sizes.size()));
  Eigen::Index num_faces = 0;
  auto next = mesh.corners.begin();
  for (std::size_t face = 0; face < mesh.sizes.size(); ++face) {
    const std::vector<int> corners(next, next + mesh.sizes[face]);
    next += mesh.sizes[face];
    PolygonTriangles triangles = TrianglesLike(like_faces, num_faces, corners);
    if (triangles.empty()) triangles = corners.size() == 3 ? FanOfPolygon(3) : CutWhereSeen(corners, frames);
    if (triangles.empty()) FailOnPolygon(path, mesh, face);
    for (const auto& [a, b, c] : triangles) faces.col(num_faces++) << corners[a], corners[b], corners[c];
  }
  return faces;
}

}  // namespace clothid
