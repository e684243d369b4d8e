#include "sim/shell/mesh_unfolding.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <utility>

namespace clothid {
namespace {

// Of the tip of a triangle over its edge from `start` to `end`, in lengths of the edge: along it, and beside it.
Eigen::Vector2d TipOver(const Eigen::Vector3d& start, const Eigen::Vector3d& end, const Eigen::Vector3d& tip) {
  const Eigen::Vector3d edge = end - start, offset = tip - start;
  return Eigen::Vector2d(edge.dot(offset), edge.cross(offset).norm()) / edge.squaredNorm();
}

}  // namespace

Eigen::Matrix3Xi OppositeFaces(const Mesh& mesh) {
  struct Edge {
    int low, high, face, side;
  };
  std::vector<Edge> edges;
  edges.reserve(3 * static_cast<std::size_t>(mesh.num_faces()));
  for (int face = 0; face < mesh.num_faces(); ++face) {
    for (int side = 0; side < 3; ++side) {
      const auto [low, high] = std::minmax({mesh.faces(side, face), mesh.faces((side + 1) % 3, face)});
      edges.push_back({low, high, face, side});
    }
  }
  std::sort(edges.begin(), edges.end(),
            [](const Edge& a, const Edge& b) { return std::pair(a.low, a.high) < std::pair(b.low, b.high); });
  std::vector<std::array<int, 2>> folds = mesh.folds;
  std::sort(folds.begin(), folds.end());
  Eigen::Matrix3Xi opposite = Eigen::Matrix3Xi::Constant(3, mesh.num_faces(), -1);
  for (std::size_t i = 1; i < edges.size(); ++i) {
    const Edge &a = edges[i - 1], &b = edges[i];
    if (a.low != b.low || a.high != b.high) continue;
    if (std::binary_search(folds.begin(), folds.end(), std::array<int, 2>{a.low, a.high})) continue;
    opposite(a.side, a.face) = b.face;
    opposite(b.side, b.face) = a.face;
  }
  return opposite;
}

MeshUnfolding::MeshUnfolding(const Mesh& mesh, const Eigen::Matrix3Xi& opposite, int face, int side)
    : mesh_(mesh), opposite_(opposite) {
  const Eigen::Vector3d start = RestCorner(mesh, face, side), end = RestCorner(mesh, face, (side + 1) % 3);
  const double length = (end - start).norm();
  const Eigen::Vector2d tip = TipOver(start, end, RestCorner(mesh, face, (side + 2) % 3));
  Laid first{face, {}};
  first.corners.col(side) << -0.5 * length, 0.0;
  first.corners.col((side + 1) % 3) << 0.5 * length, 0.0;
  first.corners.col((side + 2) % 3) << (tip.x() - 0.5) * length, tip.y() * length;
  for (int i = 0; i < 3; ++i) Place(mesh.faces((side + i) % 3, face), first.corners.col((side + i) % 3));
  laid_.push_back(first);
  if (opposite(side, face) >= 0) LayBeside(0, side);
  num_first_ = laid_.size();
}

void MeshUnfolding::AddNeighboursOf(std::size_t i) {
  if (i < num_first_) LayNeighbours(i);
}

void MeshUnfolding::AddTouching() {
  for (std::size_t i = 0; i < laid_.size(); ++i) LayNeighbours(i);
}

Eigen::Matrix2Xd MeshUnfolding::Positions() const {
  Eigen::Matrix2Xd all(2, static_cast<Eigen::Index>(positions_.size()));
  for (std::size_t i = 0; i < positions_.size(); ++i) all.col(static_cast<Eigen::Index>(i)) = positions_[i];
  return all;
}

bool MeshUnfolding::TouchesFirst(int face) const {
  for (std::size_t k = 0; k < num_first_; ++k) {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        if (mesh_.faces(i, face) == mesh_.faces(j, laid_[k].face)) return true;
      }
    }
  }
  return false;
}

bool MeshUnfolding::IsLaid(int face) const {
  return std::any_of(laid_.begin(), laid_.end(), [face](const Laid& laid) { return laid.face == face; });
}

void MeshUnfolding::Place(int node, const Eigen::Vector2d& position) {
  if (std::find(nodes_.begin(), nodes_.end(), node) != nodes_.end()) return;
  nodes_.push_back(node);
  positions_.push_back(position);
}

void MeshUnfolding::LayNeighbours(std::size_t i) {
  for (int side = 0; side < 3; ++side) {
    const int face = opposite_(side, laid_[i].face);
    if (face >= 0 && !IsLaid(face) && TouchesFirst(face)) LayBeside(i, side);
  }
}

// The triangle beyond edge `side` of one that is laid: on the right of the edge, as triangles run counter-clockwise.
// Where it has that edge longer or shorter, as an eased seam does, it is scaled to it.
void MeshUnfolding::LayBeside(std::size_t i, int side) {
  const Laid from = laid_[i];
  const int start = mesh_.faces(side, from.face), end = mesh_.faces((side + 1) % 3, from.face);
  Laid laid{opposite_(side, from.face), {}};
  int apex = 0;
  while (mesh_.faces(apex, laid.face) == start || mesh_.faces(apex, laid.face) == end) ++apex;
  const Eigen::Vector2d tip = TipOver(RestCorner(mesh_, laid.face, (apex + 2) % 3),
                                      RestCorner(mesh_, laid.face, (apex + 1) % 3), RestCorner(mesh_, laid.face, apex));
  const Eigen::Vector2d a = from.corners.col(side), b = from.corners.col((side + 1) % 3), edge = b - a;
  laid.corners.col(apex) = a + tip.x() * edge + tip.y() * Eigen::Vector2d(edge.y(), -edge.x());
  laid.corners.col((apex + 1) % 3) = b;  // where it runs along the edge the other way
  laid.corners.col((apex + 2) % 3) = a;
  Place(mesh_.faces(apex, laid.face), laid.corners.col(apex));
  laid_.push_back(laid);
}

}  // namespace clothid
