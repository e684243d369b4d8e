// Boxes with sharp or round edges, and what is a box: a table.
#ifndef CLOTHID_SIM_OBSTACLE_BOX_H_
#define CLOTHID_SIM_OBSTACLE_BOX_H_

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "sim/obstacle/obstacle.h"
#include "sim/obstacle/shape_frame.h"

namespace clothid {

// All points within `radius` (r) of a core, the box of the half lengths b = size/2 - r. In the box's own axes, with
// q_i = |x_i| - b_i and s_i = sign x_i:
//
//   outside the core  w_i = s_i max(q_i, 0), phi = |w| - r, n = w/|w|, dn/dx = (diag(q_i > 0) - n n^T)/|w|
//   inside            phi = q_k - r, n = s_k e_k, dn/dx = 0, of the nearest face k
//
// which is 0 over a face, a cylinder's over an edge and a sphere's over a corner. With r > 0 n is continuous but on
// the medial set within the core, where two faces are equally near: there it is that of the first of them, at x_k = 0
// that of the side s_k = 1. On the edges of a sharp box, where |w| is lost to rounding, n is that of a face, dn/dx = 0.
class Box : public Obstacle {
 public:
  // `size` holds the full lengths (m) along the axes that `rotation`, of any length > 0, turns x, y and z to. `radius`
  // lies in [0, half the smallest length].
  Box(const Eigen::Vector3d& center, const Eigen::Vector3d& size,
      const Eigen::Quaterniond& rotation = Eigen::Quaterniond::Identity(), double radius = 0.0);

  // A table: `top` (m) is the middle of its upper face, which `normal` looks out of. `size` (m) holds its lengths along
  // `along`, projected onto that face, and across it; its edges are round with `radius`.
  static Box Table(const Eigen::Vector3d& top, const Eigen::Vector3d& normal, const Eigen::Vector3d& along,
                   const Eigen::Vector2d& size, double thickness, double radius);

  SurfacePoint Closest(const Eigen::Vector3d& position) const override;

  const Eigen::Vector3d& center() const { return frame_.origin; }
  const Eigen::Vector3d& size() const { return size_; }
  Eigen::Quaterniond rotation() const { return Eigen::Quaterniond(frame_.axes); }
  double radius() const { return radius_; }

 private:
  Eigen::Vector3d size_, core_;  // m: full lengths; b
  double radius_;
  ShapeFrame frame_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_OBSTACLE_BOX_H_
