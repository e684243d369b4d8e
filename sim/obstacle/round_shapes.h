// Shapes of revolution: cylinder, torus and bowl.
//
// Each has an axis a. A point at the distance rho from the axis lies in the direction e (a unit vector) of it, and
// de/dx = t t^T/rho, t = a x e. To a circle about the axis, of the radius R at the height H, the offset of a point at
// the height z is (rho - R) e + (z - H) a = d n, and with m = a x t in the place of n, turned by a right angle about t,
//
//   dn/dx = m m^T/d + (n . e) t t^T/rho
//
// On the axis, where e has no direction, it is one across the axis, and de/dx = 0.
#ifndef CLOTHID_SIM_OBSTACLE_ROUND_SHAPES_H_
#define CLOTHID_SIM_OBSTACLE_ROUND_SHAPES_H_

#include <Eigen/Core>

#include "sim/obstacle/obstacle.h"
#include "sim/obstacle/shape_frame.h"

namespace clothid {

// All points within `radius` of the axis between two flat ends, in the middle of which lie `from` and `to`. Beyond side
// and end the circle of the rim is nearest. Inside phi = max(rho - radius, |z| - length/2), z from the middle: where
// both are equal n is that of the side, in the middle that of the upper end, on the rim that of the side, with dn/dx =
// 0.
class Cylinder : public Obstacle {
 public:
  Cylinder(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius);
  SurfacePoint Closest(const Eigen::Vector3d& position) const override;

  Eigen::Vector3d from() const { return frame_.origin - half_length_ * axis(); }
  Eigen::Vector3d to() const { return frame_.origin + half_length_ * axis(); }
  double radius() const { return radius_; }

 private:
  Eigen::Vector3d axis() const { return frame_.axes.col(2); }

  ShapeFrame frame_;
  double half_length_, radius_;
};

// All points within `tube_radius` of a circle of `radius` about `axis`. phi = d - tube_radius, finite but without a
// derivative on the axis (see above) and on the circle, where n = e and dn/dx = 0.
class Torus : public Obstacle {
 public:
  // `tube_radius` is smaller than `radius`: the ring has a hole.
  Torus(const Eigen::Vector3d& center, const Eigen::Vector3d& axis, double radius, double tube_radius);
  SurfacePoint Closest(const Eigen::Vector3d& position) const override;

  const Eigen::Vector3d& center() const { return frame_.origin; }
  Eigen::Vector3d axis() const { return frame_.axes.col(2); }
  double radius() const { return radius_; }
  double tube_radius() const { return tube_radius_; }

 private:
  ShapeFrame frame_;
  double radius_, tube_radius_;
};

// A piece of a spherical shell that opens towards `axis`: all points within half the thickness of a cap of a sphere.
// The cap has the radius R = `radius` + `thickness`/2 about `center`, so that the inside is a sphere of `radius`, and
// reaches from the bottom to the angle `angle` of the rim, which is round. With r = |x - center|, in a direction of the
// cap
//
//   phi = |r - R| - thickness/2, n = +-(x - center)/r, dn/dx = +-(I - n n^T)/r, + for r >= R
//
// else phi is the distance to the circle of the rim less thickness/2. n jumps on the medial set: on the cap itself, in
// the middle of the shell, and on the axis beyond the centre. At the centre n is the axis and dn/dx = 0.
class Bowl : public Obstacle {
 public:
  // `angle` (rad) is that at the centre from the bottom to the rim: pi/2 for half a sphere. It lies in (0, pi), and the
  // opening of a bowl deeper than that must be wider than the shell is thick.
  Bowl(const Eigen::Vector3d& center, const Eigen::Vector3d& axis, double radius, double angle, double thickness);
  SurfacePoint Closest(const Eigen::Vector3d& position) const override;

  const Eigen::Vector3d& center() const { return frame_.origin; }
  Eigen::Vector3d axis() const { return frame_.axes.col(2); }
  double radius() const { return middle_radius_ - 0.5 * thickness_; }
  double angle() const { return angle_; }
  double thickness() const { return thickness_; }

 private:
  ShapeFrame frame_;
  double angle_, thickness_, middle_radius_;  // R
  double rim_radius_, rim_height_;            // m, of its circle
};

}  // namespace clothid

#endif  // CLOTHID_SIM_OBSTACLE_ROUND_SHAPES_H_
