// The edges at which a cloth leaves what clamps it.
#ifndef CLOTHID_SIM_MESH_CLAMPED_EDGES_H_
#define CLOTHID_SIM_MESH_CLAMPED_EDGES_H_

#include <Eigen/Core>
#include <array>
#include <vector>

#include "sim/mesh/mesh.h"

namespace clothid {

struct ClampedEdge {
  std::array<int, 2> nodes;  // as `face` runs along them
  int face;                  // the triangle that leaves the clamp
};

// Of a cloth that is held at `held` nodes: edges between two of them, of a triangle that has a node that is not, in the
// order of these triangles. Of two such triangles at one edge the first counts.
std::vector<ClampedEdge> ClampedEdges(const Mesh& mesh, const std::vector<int>& held);

// At right angles to the edges, in the planes of their triangles and into them, as the nodes are at rest: unit vectors
// [3 x C].
Eigen::Matrix3Xd RestSlopes(const Mesh& mesh, const std::vector<ClampedEdge>& edges);

}  // namespace clothid

#endif  // CLOTHID_SIM_MESH_CLAMPED_EDGES_H_
