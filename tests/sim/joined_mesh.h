// Meshes side by side in one.
#ifndef CLOTHID_TESTS_SIM_JOINED_MESH_H_
#define CLOTHID_TESTS_SIM_JOINED_MESH_H_

#include <Eigen/Core>
#include <vector>

#include "sim/mesh/mesh.h"

namespace clothid {

// Nodes and faces in the order of `parts`.
inline Mesh JoinedMesh(const std::vector<Mesh>& parts) {
  Mesh mesh;
  for (const Mesh& part : parts) {
    const int num_nodes = mesh.num_nodes(), num_faces = mesh.num_faces();
    mesh.rest_positions.conservativeResize(3, num_nodes + part.num_nodes());
    mesh.rest_positions.rightCols(part.num_nodes()) = part.rest_positions;
    mesh.faces.conservativeResize(3, num_faces + part.num_faces());
    mesh.faces.rightCols(part.num_faces()) = part.faces.array() + num_nodes;
  }
  return mesh;
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_SIM_JOINED_MESH_H_
