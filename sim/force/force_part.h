// Some nodes of a cloth and what acts on them: the surroundings of handles, whose forces need no more of the cloth.
#ifndef CLOTHID_SIM_FORCE_FORCE_PART_H_
#define CLOTHID_SIM_FORCE_FORCE_PART_H_

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <algorithm>
#include <memory>
#include <vector>

#include "sim/matrix/block_matrix.h"
#include "sim/scene/scene.h"
#include "sim/shell/triangle_element.h"

namespace clothid {

struct ForcePart {
  std::vector<bool> is_chosen;                        // [N] nodes of the mesh on which forces are to be whole
  std::vector<int> nodes;                             // [n] those and all that acts on them, ascending
  std::vector<int> index;                             // [N] the place of a node in `nodes`, -1: none
  std::vector<int> faces;                             // the triangles at chosen nodes, ascending
  std::shared_ptr<const BlockPattern> pattern;        // of a Hessian over `nodes`, in their order
  std::vector<int> blocks;                            // [n] 0, 1, ..: of every node its block there
  std::shared_ptr<const TriangleElements> triangles;  // of `faces`, over `nodes`, as `MakeTriangleElements` makes them

  // Whether one of these nodes of the mesh is chosen.
  template <typename Nodes>
  bool Touches(const Nodes& mesh_nodes) const {
    return std::any_of(mesh_nodes.begin(), mesh_nodes.end(), [this](int node) { return is_chosen[node]; });
  }
};

// The part of the cloth of `scene` in which forces on the nodes `chosen` are whole. `coupled`: sets of nodes, each with
// a chosen one, that forces couple beside triangles (`ForceTerm::VisitCoupled`).
ForcePart MakeForcePart(const Scene& scene, const std::vector<int>& chosen,
                        const std::vector<std::vector<int>>& coupled);

// The entries of a symmetric matrix [N x N] in rows or columns of chosen nodes, over the part [n x n].
Eigen::SparseMatrix<double> PartOfMatrix(const Eigen::SparseMatrix<double>& matrix, const ForcePart& part);

}  // namespace clothid

#endif  // CLOTHID_SIM_FORCE_FORCE_PART_H_
