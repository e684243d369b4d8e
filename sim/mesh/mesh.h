// A triangulated piece of cloth at rest.
#ifndef CLOTHID_SIM_MESH_MESH_H_
#define CLOTHID_SIM_MESH_MESH_H_

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

namespace clothid {

// The most that a mesh may have: bounds to check before memory is asked for.
inline constexpr int kMaxNodes = 4000000;
inline constexpr int kMaxFaces = 2 * kMaxNodes;

struct Mesh {
  Eigen::Matrix3Xd rest_positions;  // [3 x N] m
  Eigen::Matrix3Xi faces;           // [3 x F] node indices, consistently oriented
  // Groups of triangles with a name, whose constants may differ. Empty: the cloth is one.
  std::vector<std::string> piece_names = {};  // [P]
  std::vector<int> face_pieces = {};          // [F] 0 to P - 1, or P: of none

  int num_nodes() const { return static_cast<int>(rest_positions.cols()); }
  int num_faces() const { return static_cast<int>(faces.cols()); }
};

struct GridOptions {
  std::array<int, 2> nodes = {16, 16};      // along the first and the second axis, at least 2 each
  std::array<double, 2> size = {0.3, 0.3};  // m
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  std::array<Eigen::Vector3d, 2> axes = {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY()};  // normalised on use
};

// Node (i, j) has index i + nodes[0] * j and stands at origin + i du axes[0] + j dv axes[1]. The diagonals alternate,
// so that neither diagonal direction is preferred.
Mesh MakeGrid(const GridOptions& options);

// Throws `Error` (kBadData), prefixed by `source`, unless: there are at most kMaxNodes nodes and kMaxFaces triangles;
// positions are finite; indices are in range and distinct within a face; every triangle has area; every edge has one or
// two triangles, which run along it in opposite directions (otherwise one of them is inverted); every node belongs to a
// triangle. Messages count nodes and triangles from 0.
void ValidateMesh(const Mesh& mesh, const std::string& source);

// Area of every triangle at rest [F], m^2.
Eigen::VectorXd TriangleAreas(const Mesh& mesh);

// A third of the rest area of the adjacent triangles [N], m^2.
Eigen::VectorXd NodeAreas(const Mesh& mesh);

// The length that "relative to the cloth's size" refers to: the square root of the rest area, m.
double ClothSize(const Mesh& mesh);

}  // namespace clothid

#endif  // CLOTHID_SIM_MESH_MESH_H_
