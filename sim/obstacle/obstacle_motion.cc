#include "sim/obstacle/obstacle_motion.h"

#include <utility>

namespace clothid {

ObstacleMotion::ObstacleMotion(const AffineMotion& body) : moves_(true), body_(body) {}

ObstacleMotion::ObstacleMotion(std::shared_ptr<const DeformedSurface> surface)
    : moves_(true), surface_(std::move(surface)) {}

MovedSurfacePoint ObstacleMotion::Closest(const Obstacle& shape, const Eigen::Vector3d& position) const {
  return surface_ != nullptr ? surface_->Closest(position) : body_.Closest(shape, position);
}

AffineMotion ObstacleMotion::Near(const Eigen::Vector3d& position) const {
  return surface_ != nullptr ? surface_->MotionNear(position) : body_;
}

Eigen::Vector3d ObstacleMotion::VelocityAt(const Eigen::Vector3d& position, int face) const {
  return surface_ != nullptr ? surface_->MotionOf(face).velocity().At(position) : body_.velocity().At(position);
}

}  // namespace clothid
