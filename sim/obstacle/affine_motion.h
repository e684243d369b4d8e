// How a rigid obstacle, or a face of one that deforms (deformed_surface.h), moves over one implicit solve, and what the
// contact law sees of that.
//
// A solve starts at x. The body's point there is p = A_0^-1 x, with A_0 = [L | a] the map from the body's axes to the
// world's at the start; the obstacle moves it with V = E p, E a map per s. So, with phi_b the shape's signed distance
// in the body's axes, n_b and N_b its derivatives:
//   gap = phi_b(p),   dgap/dx = s n,   n = L^-T n_b/s,   dn/dx = (I - n n^T) L^-T N_b L^-1/s,   s = |L^-T n_b|
//   V = W x + w,   W = E_L L^-1
// A pose has a rotation L, and s = 1; the second stage of a step starts from a map that is a rotation but for terms of
// second order in the step (sim/step/obstacle_motions.h).
#ifndef CLOTHID_SIM_OBSTACLE_AFFINE_MOTION_H_
#define CLOTHID_SIM_OBSTACLE_AFFINE_MOTION_H_

#include <Eigen/Core>
#include <memory>

#include "sim/obstacle/obstacle.h"
#include "sim/path/rigid_path.h"

namespace clothid {

// Of one solve.
struct SolveMaps {
  AffineMap start = AffineMap::Identity();        // A_0
  AffineMap velocity = AffineMap::Zero();         // E: V of the solve, from p
  AffineMap velocity_change = AffineMap::Zero();  // E less the map of the obstacle's velocity when the solve starts
};

// A velocity V = W x + w at a place x in world axes.
struct VelocityField {
  Eigen::Matrix3d gradient = Eigen::Matrix3d::Zero();  // W, 1/s
  Eigen::Vector3d constant = Eigen::Vector3d::Zero();  // w, m/s

  Eigen::Vector3d At(const Eigen::Vector3d& position) const { return gradient * position + constant; }
};

// The closest point of a surface that is somewhere else than its shape says. `SurfacePoint::gap` and `normal` are those
// above, and `slope` is s.
struct MovedSurfacePoint {
  SurfacePoint surface;
  double slope = 1.0;
  int face = 0;  // of a surface that deforms, that the point belongs to
};

// What a solve sees of a number that its maps depend on, at fixed x.
struct MotionChange {
  double distance = 0.0;  // dgap/s
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();         // V
  Eigen::Vector3d velocity_change = Eigen::Vector3d::Zero();  // what V has changed by since the solve started
};

class AffineMotion {
 public:
  AffineMotion() = default;  // stands still
  // The linear part of `maps.start` must be invertible.
  explicit AffineMotion(const SolveMaps& maps);

  const VelocityField& velocity() const { return velocity_; }
  const VelocityField& velocity_change() const { return velocity_change_; }

  Eigen::Vector3d ToBody(const Eigen::Vector3d& position) const { return to_body_ * (position - origin_); }  // p
  MovedSurfacePoint Closest(const Obstacle& shape, const Eigen::Vector3d& position) const;

  // Along a change of the maps, at a place where those are n and dn/dx.
  MotionChange Differentiate(const SolveMaps& change, const Eigen::Vector3d& position, const Eigen::Vector3d& normal,
                             const Eigen::Matrix3d& normal_gradient) const;

 private:
  Eigen::Matrix3d to_body_ = Eigen::Matrix3d::Identity();  // L^-1
  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();       // a
  VelocityField velocity_, velocity_change_;
};

// A shape at one time, in world axes.
class MovedShape : public Obstacle {
 public:
  MovedShape(std::shared_ptr<const Obstacle> shape, const AffineMap& pose);
  SurfacePoint Closest(const Eigen::Vector3d& position) const override;

 private:
  std::shared_ptr<const Obstacle> shape_;
  AffineMotion motion_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_OBSTACLE_AFFINE_MOTION_H_
