// Slopes of a cloth at the middles of its edges, as sums over nodes, and axes of triangles: what bending patches
// (bending_patch.h) are made of.
#ifndef CLOTHID_SIM_SHELL_EDGE_SLOPES_H_
#define CLOTHID_SIM_SHELL_EDGE_SLOPES_H_

#include <Eigen/Core>
#include <map>
#include <utility>
#include <vector>

#include "sim/mesh/clamped_edges.h"
#include "sim/mesh/mesh.h"

namespace clothid {

// Along `warp` in the plane of a triangle, and a right angle further [3 x 2].
Eigen::Matrix<double, 3, 2> TriangleAxes(const Mesh& mesh, int face, const Eigen::Vector3d& warp);

// Two edges of a triangle in axes of it [2 x 2].
Eigen::Matrix2d EdgesIn(const Eigen::Matrix<double, 3, 2>& axes, const Mesh& mesh, int face);

// A linear function of the nodes and, at a clamped edge, of the slope there.
struct NodeWeights {
  std::vector<int> nodes;
  Eigen::VectorXd weights;
  int slope = -1;  // the number of the edge, -1: none
  double slope_weight = 0.0;
};

// The slopes at clamped edges, on one mesh as they are given on another: A takes the direction across the edge there to
// alpha of that across it here, and beta along it.
class GivenSlopes {
 public:
  // All of them must outlive it.
  GivenSlopes(const std::vector<ClampedEdge>& clamped, const Mesh& chosen_on, const Mesh& mesh);

  int Find(int face, int side) const;  // the number of the edge `side` of `face`; -1: it is not clamped
  int face(int number) const { return clamped_[static_cast<std::size_t>(number)].face; }
  NodeWeights Of(int number, int side) const;  // into the triangle of the edge

 private:
  const std::vector<ClampedEdge>& clamped_;
  const Mesh &chosen_on_, &mesh_;
  std::map<std::pair<int, int>, int> numbers_;  // of edges (low, high)
};

// The slopes of all edges, each towards its first triangle. Which of two is the first depends neither on numbers nor on
// axes: the one nearer to the middle of the cloth. Of a clamped edge it is the one that leaves the clamp.
class EdgeSlopes {
 public:
  // `areas` [F] m^2, of the triangles at rest.
  EdgeSlopes(const Mesh& mesh, const Eigen::VectorXd& areas, const GivenSlopes& given);

  // The slope out of the face is `sign` times `slope`.
  const NodeWeights& slope(int face, int side) const {
    const int place = place_(side, face);
    return slopes_[static_cast<std::size_t>(place >= 0 ? place : -1 - place)];
  }
  double sign(int face, int side) const { return place_(side, face) >= 0 ? -1.0 : 1.0; }

 private:
  Eigen::Matrix3Xi place_;  // [3 x F] in slopes_; of the second triangle -1 - place
  std::vector<NodeWeights> slopes_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_SHELL_EDGE_SLOPES_H_
