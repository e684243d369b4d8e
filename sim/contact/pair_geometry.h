// The distance of two parts of a cloth, and its derivative: a vertex and a vertex, edge or face, or two edges.
//
// With X = (x_0 .. x_3) the nodes of a pair, three by four, its closest points p and q lie on the lines or planes of
// its two features:
//   e = p - q = X w,   w = w_0 + W beta,   (X W)^T e = 0,   n = e/|e|
// w_0 and W are constants of the kind, beta are at most two numbers:
//   vertex, vertex   (p; a)            w = (1, -1)
//   vertex, edge     (p; a, b)         w = (1, -1 + beta, -beta)
//   vertex, face     (p; a, b, c)      w = (1, -1 + beta_1 + beta_2, -beta_1, -beta_2)
//   edge, edge       (a, b; c, d)      w = (1 - beta_1, beta_1, -1 + beta_2, -beta_2)
// and so, with T = X W,
//   beta = -(T^T T)^-1 T^T X w_0,   dbeta = -(T^T T)^-1 (W^T dX^T e + T^T dX w),   dw = W dbeta
//   de = dX w + X dw,   d|e| = n . dX w,   dn = (I - n n^T) de/|e|
#ifndef CLOTHID_SIM_CONTACT_PAIR_GEOMETRY_H_
#define CLOTHID_SIM_CONTACT_PAIR_GEOMETRY_H_

#include <Eigen/Core>
#include <array>
#include <tuple>

namespace clothid {

enum class PairKind : char { kVertexVertex, kVertexEdge, kVertexFace, kEdgeEdge };

// Two features of a mesh, by their nodes in the order above; unused places are -1. Nodes of an edge or face ascend, and
// of two edges the one with the lower first node comes first, so that a pair has one name.
struct PairFeatures {
  PairKind kind = PairKind::kVertexVertex;
  std::array<int, 4> nodes = {-1, -1, -1, -1};

  int num_nodes() const;  // 2 to 4

  bool operator==(const PairFeatures& other) const { return kind == other.kind && nodes == other.nodes; }
  bool operator<(const PairFeatures& other) const { return std::tie(kind, nodes) < std::tie(other.kind, other.nodes); }
};

struct PairGeometry {
  Eigen::Vector4d weights = Eigen::Vector4d::Zero();  // w, zero in unused places
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // n, from the second feature to the first
  double distance = 0.0;                              // |e|, m
};

// By the three coordinates of every node in turn; zero in those of unused places.
struct PairGeometryGradient {
  Eigen::Matrix<double, 4, 12> weights = Eigen::Matrix<double, 4, 12>::Zero();  // 1/m
  Eigen::Matrix<double, 3, 12> normal = Eigen::Matrix<double, 3, 12>::Zero();   // 1/m
  Eigen::Matrix<double, 1, 12> distance = Eigen::Matrix<double, 1, 12>::Zero();
};

// At `positions` [3N] m, wherever on their lines or planes the closest points are. Where T^T T is singular (parallel
// edges, a face without area) or the distance is zero, the numbers are not finite.
PairGeometry EvaluatePair(const PairFeatures& pair, const Eigen::VectorXd& positions);
PairGeometryGradient DifferentiatePair(const PairFeatures& pair, const Eigen::VectorXd& positions);

}  // namespace clothid

#endif  // CLOTHID_SIM_CONTACT_PAIR_GEOMETRY_H_
