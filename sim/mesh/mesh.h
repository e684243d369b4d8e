// A triangulated piece of cloth at rest.
#ifndef CLOTHID_SIM_MESH_MESH_H_
#define CLOTHID_SIM_MESH_MESH_H_

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "sim/base/error.h"

namespace clothid {

// The most that a mesh may have: bounds to check before memory is asked for.
inline constexpr int kMaxNodes = 4000000;
inline constexpr int kMaxFaces = 2 * kMaxNodes;
// Twice the area of a triangle that counts as having none, relative to its longest side squared: the rounding of
// coordinates given to seven digits.
inline constexpr double kDegenerate = 1e-7;

// A fault of a mesh, and the part that has it: a triangle or a node, from 0 on; -1 where none is known.
struct MeshPart {
  int face = -1, node = -1;
};
class MeshError : public Error {
 public:
  MeshError(const std::string& source, const std::string& fault, MeshPart part)
      : Error(ErrorKind::kBadData, source + ": " + fault), fault_(fault), part_(part) {}
  const std::string& fault() const { return fault_; }  // without the source
  MeshPart part() const { return part_; }

 private:
  std::string fault_;
  MeshPart part_;
};

// Draws node p to the point (1 - s) q_0 + s q_1 of an edge: sim/shell/seam_energy.h.
struct SeamLink {
  int node = 0;                      // p
  std::array<int, 2> edge = {0, 0};  // q_0 and q_1; twice the same: to that node
  double share = 0.0;                // s, in [0, 1]
  double stiffness = 0.0;            // k_s > 0, N/m
  double closing_time = 0.0;         // T >= 0, s: when it is to be closed, on the scene's clock; 0: from the first
};

// The rest shape of cloth that is cut from flat pieces is no embedding: along a seam a node has a place in each piece.
// So a mesh may give one for each corner of a triangle. Lengths, areas and angles at rest are then those of the
// corners, the cloth is flat at rest, and directions in it are (u, v, 0). `rest_positions` are then a shape that the
// nodes have together, from which the cloth starts and by which its places are known: to a wind, to seams that close,
// and to the import of points.
struct Mesh {
  Eigen::Matrix3Xd rest_positions;    // [3 x N] m
  Eigen::Matrix3Xi faces;             // [3 x F] node indices, consistently oriented
  Eigen::Matrix2Xd corner_rest = {};  // [2 x 3F] m, corner k of face f in column 3f + k; empty: as the nodes are
  std::vector<std::array<int, 2>> folds = {};  // edges {low, high} between two triangles across which nothing bends
  std::vector<SeamLink> links = {};
  // Groups of triangles with a name, whose constants may differ. Empty: the cloth is one.
  std::vector<std::string> piece_names = {};  // [P]
  std::vector<int> face_pieces = {};          // [F] 0 to P - 1, or P: of none

  bool has_corner_rest() const { return corner_rest.cols() > 0; }
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

// Where a corner of a triangle is at rest; with a place per corner (u, v, 0). The side `side` of a triangle runs from
// that corner to the next.
inline Eigen::Vector3d RestCorner(const Mesh& mesh, int face, int corner) {
  if (!mesh.has_corner_rest()) return mesh.rest_positions.col(mesh.faces(corner, face));
  const auto place = mesh.corner_rest.col(3 * static_cast<Eigen::Index>(face) + corner);
  return {place[0], place[1], 0.0};
}
double RestLength(const Mesh& mesh, int face, int side);  // m

// Throws `MeshError`, prefixed by `source`, unless: there are at most kMaxNodes nodes and kMaxFaces triangles;
// positions are finite; indices are in range and distinct within a face; every triangle has area; every edge has one or
// two triangles, which run along it in opposite directions (otherwise one of them is inverted); every node belongs to a
// triangle. With a place per corner: there are 3F, finite, and triangles have area there, too, and do not lie on each
// other along an edge that is no seam. Folds are edges of two triangles, links join nodes to others, with numbers in
// their ranges. Messages count nodes and triangles from 0.
void ValidateMesh(const Mesh& mesh, const std::string& source);

// Area of every triangle at rest [F], m^2.
Eigen::VectorXd TriangleAreas(const Mesh& mesh);

// A third of the rest area of the adjacent triangles [N], m^2.
Eigen::VectorXd NodeAreas(const Mesh& mesh);

// The length that "relative to the cloth's size" refers to: the square root of the rest area, m.
double ClothSize(const Mesh& mesh);

}  // namespace clothid

#endif  // CLOTHID_SIM_MESH_MESH_H_
