// The signed distance of a point to a cloth whose nodes stand at given places, and its derivative with respect to them.
//
// With c the closest point on the triangles, c = sum_k w_k x_k over the nodes of the nearest face, edge or vertex:
//
//   face:                n its normal,                    d = n . (q - c),           dd/dx_k = -w_k n
//   edge, vertex within: n = s (q - c)/|q - c|,           d = s |q - c|,             dd/dx_k = -w_k n
//   border:              d_n = n . (q - c), n the normal of a face at the border,
//                        t = |(q - c) - d_n n|, the part along the cloth, outwards,
//                        d = s sqrt(d_n^2 + max(0, t - allowance)^2)
//
// s = +-1 is the side of the cloth that q is on: of n, or of the pseudonormal of the edge or vertex. That c moves, too,
// does not matter to first order (the envelope theorem), so the derivatives are exact wherever the nearest feature
// does not change. d_n is the height above the plane of the face, so that dd_n/dx_k = -b_k n with b the barycentric
// coordinates of q in that plane, and t^2 = |q - c|^2 - d_n^2.
//
// The allowance is for noise. A point that noise has carried beyond the border has no counterpart that would push the
// border back, so that every such point would pull the cloth outwards; within the allowance it counts by its height.
//
// d^2 is continuously differentiable but for kinks: where two parts of the cloth are equally near (half way between two
// layers, or on the axis of a fold), and in the plane of a border vertex or of a crooked border, where the face whose
// normal counts changes. Beyond the border d changes its sign with d_n, which d^2 does not see.
//
// A point that is known to lie on the border has a second distance, along the cloth. With c the closest point on the
// border, a polyline, n the normal of the face at it and m the unit vector in the plane of this face that points away
// from the cloth:
//   u = m . (q - c),   du/dx_k = -w_k m + (n . (q - c)) (m . grad b_k) n
// positive beyond the border. At an edge m is normal to it; at a vertex it is the direction of q - c in the plane,
// turned outwards by u's sign. The second term is how the plane turns with the nodes: with u and d_n as above |q - c|^2
// = u^2 + d_n^2, whose left side has the derivative -2 sum_k w_k (q - c) . dx_k by the envelope theorem. u is as smooth
// as d is, with its sign also where the point is on the border: a Gauss-Newton method sees nothing of a kink there.
//
// The nearest layer counts. Of a cloth folded onto itself a point of the upper layer may be nearer to the lower one;
// nothing tells them apart. And the distance is one-sided: cloth where nothing was measured is no error.
#ifndef CLOTHID_DATASETS_OBSERVATION_CLOTH_SURFACE_H_
#define CLOTHID_DATASETS_OBSERVATION_CLOTH_SURFACE_H_

#include <Eigen/Core>
#include <array>
#include <memory>

#include "datasets/observation/surface_offset.h"

namespace clothid {

class TriangleTree;  // sim/geometry/triangle_tree.h

struct SurfaceDistance {
  double distance = 0.0;  // d, m
  int num_nodes = 0;      // 1 to 3: of the feature, or of the face at a border
  std::array<int, 3> nodes = {0, 0, 0};
  Eigen::Vector3d weights = Eigen::Vector3d::Zero();   // w: c = sum_k weights[k] x[nodes[k]]
  Eigen::Vector3d closest = Eigen::Vector3d::Zero();   // c, m
  Eigen::Matrix3d gradient = Eigen::Matrix3d::Zero();  // column k: dd/dx of nodes[k]
};

// The faces, edges and vertices of a mesh, wherever its nodes are. Immutable; copies share their data.
class ClothTopology {
 public:
  // `faces` [3 x F] as of a mesh that `ValidateMesh` accepts.
  ClothTopology(const Eigen::Matrix3Xi& faces, int num_nodes);

  bool has_border() const;

 private:
  friend class ClothSurface;
  struct Data;
  std::shared_ptr<const Data> data_;
};

// A topology with its nodes in place. Immutable; `Measure` may be called from several threads.
class ClothSurface {
 public:
  // `nodes` [3N] m, finite.
  ClothSurface(const ClothTopology& topology, const Eigen::VectorXd& nodes);

  // Of the point q. `allowance` >= 0, m. Of features that are equally near the same one is always taken.
  SurfaceDistance Measure(const Eigen::Vector3d& q, double allowance) const;
  // u of the point q, and the closest point of the border. There must be a border.
  SurfaceDistance MeasureToBorder(const Eigen::Vector3d& q) const;
  // The same as vectors, with the nearest point: e, |e| = |d|, and q less the closest point of the border.
  SurfaceOffset Offset(const Eigen::Vector3d& q, double allowance) const;
  SurfaceOffset OffsetToBorder(const Eigen::Vector3d& q) const;

 private:
  // The edge or vertex of the border that is nearest to q, and m there: at an edge; at a vertex the sum of both.
  struct BorderFeature {
    int feature = 0;
    Eigen::Vector3d outwards = Eigen::Vector3d::Zero();
  };
  BorderFeature NearestBorder(const Eigen::Vector3d& q) const;
  // The offset to an edge or a vertex, whose nodes it has.
  SurfaceOffset OffsetToLine(const Eigen::Vector3d& q, int feature) const;
  SurfaceDistance MeasureFace(const Eigen::Vector3d& q, int face) const;
  SurfaceDistance MeasureWithin(const Eigen::Vector3d& q, int feature) const;
  SurfaceDistance MeasureBorder(const Eigen::Vector3d& q, int feature, double allowance) const;
  // c and its weights, for a feature of one or two nodes.
  SurfaceDistance Project(const Eigen::Vector3d& q, int feature) const;
  // The same, of the nodes of the first face that has the feature.
  SurfaceDistance ProjectOnFace(const Eigen::Vector3d& q, int feature) const;
  // u, with c on this edge or vertex. `outwards`: m at an edge; at a vertex any vector on the side beyond the border.
  SurfaceDistance Beyond(const Eigen::Vector3d& q, int feature, const Eigen::Vector3d& outwards) const;
  // m at an edge of the border.
  Eigen::Vector3d Outwards(int edge) const;
  Eigen::Vector3d Pseudonormal(int feature) const;
  Eigen::Vector3d Position(int node) const { return nodes_.segment<3>(3 * static_cast<Eigen::Index>(node)); }

  std::shared_ptr<const ClothTopology::Data> topology_;
  Eigen::VectorXd nodes_;  // [3N]
  std::shared_ptr<const TriangleTree> tree_;
};

}  // namespace clothid

#endif  // CLOTHID_DATASETS_OBSERVATION_CLOTH_SURFACE_H_
