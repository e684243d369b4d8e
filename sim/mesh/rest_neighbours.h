// The nodes of a cloth that belong together at rest, so that their contact says nothing.
#ifndef CLOTHID_SIM_MESH_REST_NEIGHBOURS_H_
#define CLOTHID_SIM_MESH_REST_NEIGHBOURS_H_

#include <vector>

#include "sim/mesh/mesh.h"

namespace clothid {

// Neighbours of a node: itself, and those that are less than `closest`, m, away along edges at rest; links
// (`Mesh::links`: node and edge) have no length.
class RestNeighbours {
 public:
  RestNeighbours(const Mesh& mesh, double closest);

  bool Contains(int node, int other) const;  // the same in either order

 private:
  std::vector<int> neighbours_;  // of node 0, ascending; of node 1, ...
  std::vector<int> first_;       // [N + 1] where those of a node begin
};

}  // namespace clothid

#endif  // CLOTHID_SIM_MESH_REST_NEIGHBOURS_H_
