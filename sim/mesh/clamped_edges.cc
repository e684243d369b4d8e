#include "sim/mesh/clamped_edges.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <set>
#include <utility>

namespace clothid {

std::vector<ClampedEdge> ClampedEdges(const Mesh& mesh, const std::vector<int>& held) {
  std::vector<bool> is_held(static_cast<std::size_t>(mesh.num_nodes()), false);
  for (const int node : held) is_held[node] = true;
  std::vector<ClampedEdge> edges;
  std::set<std::pair<int, int>> known;
  for (int face = 0; face < mesh.num_faces(); ++face) {
    for (int side = 0; side < 3; ++side) {
      const int start = mesh.faces(side, face), end = mesh.faces((side + 1) % 3, face);
      if (!is_held[start] || !is_held[end] || is_held[mesh.faces((side + 2) % 3, face)]) continue;
      if (known.insert(std::minmax(start, end)).second) edges.push_back({{start, end}, face});
    }
  }
  return edges;
}

Eigen::Matrix3Xd RestSlopes(const Mesh& mesh, const std::vector<ClampedEdge>& edges) {
  Eigen::Matrix3Xd slopes(3, static_cast<Eigen::Index>(edges.size()));
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const auto [start, end] = edges[i].nodes;
    const Eigen::Vector3i corners = mesh.faces.col(edges[i].face);
    const int apex = corners.sum() - start - end;
    const Eigen::Vector3d along = (mesh.rest_positions.col(end) - mesh.rest_positions.col(start)).normalized();
    const Eigen::Vector3d to_apex = mesh.rest_positions.col(apex) - mesh.rest_positions.col(start);
    slopes.col(static_cast<Eigen::Index>(i)) = (to_apex - to_apex.dot(along) * along).normalized();
  }
  return slopes;
}

}  // namespace clothid
