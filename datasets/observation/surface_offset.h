// Where the nearest point of a cloth lies from a measured point, as a vector, and how both change with the nodes.
//
// With c = sum_k w_k x_k the nearest point of the cloth (datasets/observation/cloth_surface.h), e = q - c:
//
//   face:    e = h n,  h = n . (q - x_0),    dn = -sum_k g_k (n . dx_k),   dh = -n . sum_k w_k dx_k
//            w_k = b_k(q),                   dw_k = g_k . sum_i (h g_i n^T - w_i) dx_i
//   edge:    e = q - x_0 - t l,  l = x_1 - x_0,  t = l . (q - x_0)/|l|^2,  w = (1 - t, t)
//   vertex:  e = q - x_0
//
// n is the normal of the face, b its barycentric coordinates, g their gradients in its plane. Unlike the normal
// e/|e|, all of these are smooth where the point is on the cloth. From one feature to the next e and w are continuous.
//
// Beside a border noise may carry a point beyond the cloth. With c on the border, n and h = n . (q - c) of a face
// there, t = q - c - h n the part along the cloth, and the allowance a of a distance:
//   e = h n + max(0, 1 - a/|t|) t
#ifndef CLOTHID_DATASETS_OBSERVATION_SURFACE_OFFSET_H_
#define CLOTHID_DATASETS_OBSERVATION_SURFACE_OFFSET_H_

#include <Eigen/Core>
#include <array>

namespace clothid {

struct SearchTriangle;  // sim/geometry/triangle_tree.h

struct SurfaceOffset {
  // Three columns a node.
  using NodeColumns = Eigen::Matrix<double, 3, 9>;

  int num_nodes = 0;  // 1 to 3
  std::array<int, 3> nodes = {0, 0, 0};
  Eigen::Vector3d weights = Eigen::Vector3d::Zero();  // w
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();   // e, m
  NodeColumns offset_gradient = NodeColumns::Zero();  // de/dx of the nodes
  NodeColumns weight_gradient = NodeColumns::Zero();  // dw/dx of the nodes, 1/m
};

// Of the point q. Nodes are numbered 0, 1, 2 as the corners are.
SurfaceOffset OffsetToFace(const SearchTriangle& triangle, const Eigen::Vector3d& q);
SurfaceOffset OffsetToEdge(const Eigen::Vector3d& start, const Eigen::Vector3d& end, const Eigen::Vector3d& q);
SurfaceOffset OffsetToVertex(const Eigen::Vector3d& vertex, const Eigen::Vector3d& q);
// Of a point beside the border. `to_border`: its offset to the border, of corners of `triangle`.
SurfaceOffset OffsetBesideFace(const SearchTriangle& triangle, double allowance, SurfaceOffset to_border);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_OBSERVATION_SURFACE_OFFSET_H_
