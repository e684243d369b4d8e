// How an obstacle moves over one implicit solve: not at all, as a rigid body, or as a surface that deforms.
#ifndef CLOTHID_SIM_OBSTACLE_OBSTACLE_MOTION_H_
#define CLOTHID_SIM_OBSTACLE_OBSTACLE_MOTION_H_

#include <Eigen/Core>
#include <memory>

#include "sim/obstacle/affine_motion.h"
#include "sim/obstacle/deformed_surface.h"

namespace clothid {

class ObstacleMotion {
 public:
  ObstacleMotion() = default;  // stands still
  explicit ObstacleMotion(const AffineMotion& body);
  explicit ObstacleMotion(std::shared_ptr<const DeformedSurface> surface);

  bool moves() const { return moves_; }
  const AffineMotion& body() const { return body_; }                 // of one that does not deform
  const DeformedSurface* surface() const { return surface_.get(); }  // null of all others

  // Of `shape`, in axes of the body; of what deforms of its surface.
  MovedSurfacePoint Closest(const Obstacle& shape, const Eigen::Vector3d& position) const;
  // How it moves at `position`: what deforms as its face does that is nearest.
  AffineMotion Near(const Eigen::Vector3d& position) const;
  // V at a place whose closest point is on `face` of what deforms.
  Eigen::Vector3d VelocityAt(const Eigen::Vector3d& position, int face) const;

 private:
  bool moves_ = false;
  AffineMotion body_;
  std::shared_ptr<const DeformedSurface> surface_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_OBSTACLE_OBSTACLE_MOTION_H_
