// The neighbourhood of some triangles of a cloth at rest, unfolded into their plane. Internal to sim/cloth.
#ifndef CLOTHID_SIM_SHELL_MESH_UNFOLDING_H_
#define CLOTHID_SIM_SHELL_MESH_UNFOLDING_H_

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "sim/mesh/mesh.h"

namespace clothid {

// The triangle on the other side of every edge [3 x F]: edge i runs from corner i to corner i + 1; -1: a border
// or a fold, across which nothing bends.
Eigen::Matrix3Xi OppositeFaces(const Mesh& mesh);

// Triangles are laid down one after the other, each beside one that lies there, so that lengths and angles of every
// triangle are kept. In a mesh that is flat at rest that is the mesh itself.
class MeshUnfolding {
 public:
  // Lays down `face`, edge `side` of it along the x axis with its middle at the origin and the triangle above it, and
  // the triangle on the other side of that edge. Both arguments must outlive the unfolding.
  MeshUnfolding(const Mesh& mesh, const Eigen::Matrix3Xi& opposite, int face, int side);

  // Lays down the triangles that share an edge with the first (0) or the second (1) of the two.
  void AddNeighboursOf(std::size_t i);
  // Then: all that share a node with the two, as far as edges lead to them.
  void AddTouching();

  // In the order in which they were laid down, the edge's nodes first, then the apexes of its triangles.
  const std::vector<int>& nodes() const { return nodes_; }
  Eigen::Matrix2Xd Positions() const;  // [2 x n] m

 private:
  struct Laid {
    int face;
    Eigen::Matrix<double, 2, 3> corners;
  };

  bool TouchesFirst(int face) const;
  bool IsLaid(int face) const;
  void Place(int node, const Eigen::Vector2d& position);
  void LayNeighbours(std::size_t i);
  void LayBeside(std::size_t i, int side);

  const Mesh& mesh_;
  const Eigen::Matrix3Xi& opposite_;
  std::vector<Laid> laid_;
  std::size_t num_first_ = 0;  // of laid_: the triangles of the edge
  std::vector<int> nodes_;
  std::vector<Eigen::Vector2d> positions_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_SHELL_MESH_UNFOLDING_H_
