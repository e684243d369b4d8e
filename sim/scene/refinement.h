// The same cloth on a mesh of twice the density: every triangle becomes four, halved along its three edges.
//
//        c
//       / \          Nodes keep their numbers; the midpoints follow them, ordered by the ends of their edges.
//     ca - bc        Rest shape, start and paths of handles are those of the coarse mesh, linear along every edge.
//     / \ / \        A midpoint between two handles is a handle, too.
//    a - ab - b       Triangle f becomes 4 f to 4 f + 3, which have its direction of the warp and its piece.
#ifndef CLOTHID_SIM_SCENE_REFINEMENT_H_
#define CLOTHID_SIM_SCENE_REFINEMENT_H_

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "sim/mesh/mesh.h"
#include "sim/scene/scene.h"

namespace clothid {

struct RefinedMesh {
  Mesh mesh;
  std::vector<std::array<int, 2>> edges;  // [E] of the coarse mesh, each {low, high}, in increasing order

  int num_coarse_nodes() const { return mesh.num_nodes() - static_cast<int>(edges.size()); }
  // The node halfway between two nodes of the coarse mesh, -1 where no edge joins them.
  int Midpoint(int a, int b) const;
  // Values [3N x c] at the coarse nodes, to [3(N + E) x c] at all.
  Eigen::MatrixXd Interpolate(const Eigen::MatrixXd& values) const;
};

RefinedMesh RefineMesh(const Mesh& mesh);

// `scene` on `refined`, which must be of its mesh. Its handles come first, in their order, those of midpoints follow.
Scene RefineScene(const Scene& scene, const RefinedMesh& refined);

// Throws `Error` (kUsage), led by `source`, where the scene cannot be refined: it has a force per node, which on
// another mesh is another force, or would have more than kMaxNodes nodes.
void ExpectRefinable(const Scene& scene, const std::string& source);

}  // namespace clothid

#endif  // CLOTHID_SIM_SCENE_REFINEMENT_H_
