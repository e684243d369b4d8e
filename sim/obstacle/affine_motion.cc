#include "sim/obstacle/affine_motion.h"

#include <Eigen/LU>
#include <utility>

namespace clothid {
namespace {

VelocityField FieldOf(const AffineMap& velocity, const Eigen::Matrix3d& to_body, const Eigen::Vector3d& origin) {
  VelocityField field;
  field.gradient = velocity.leftCols<3>() * to_body;
  field.constant = velocity.col(3) - field.gradient * origin;
  return field;
}

SolveMaps MapsAt(const AffineMap& pose) {
  SolveMaps maps;
  maps.start = pose;
  return maps;
}

Eigen::Matrix3d Projection(const Eigen::Vector3d& normal) {
  return Eigen::Matrix3d::Identity() - normal * normal.transpose();
}

}  // namespace

AffineMotion::AffineMotion(const SolveMaps& maps)
    : to_body_(maps.start.leftCols<3>().inverse()),
      origin_(maps.start.col(3)),
      velocity_(FieldOf(maps.velocity, to_body_, origin_)),
      velocity_change_(FieldOf(maps.velocity_change, to_body_, origin_)) {}

MovedSurfacePoint AffineMotion::Closest(const Obstacle& shape, const Eigen::Vector3d& position) const {
  MovedSurfacePoint result;
  result.surface = shape.Closest(ToBody(position));
  SurfacePoint& surface = result.surface;
  surface.normal = to_body_.transpose() * surface.normal;
  result.slope = surface.normal.norm();
  surface.normal /= result.slope;
  if (surface.normal_gradient.isZero(0.0)) return result;
  surface.normal_gradient =
      Projection(surface.normal) * (to_body_.transpose() * surface.normal_gradient * to_body_) / result.slope;
  return result;
}

// With y = dL p + da, what the change moves the body's point at x by: dp = -L^-1 y, dgap = -s n . y,
// dn = -N y - (I - n n^T) L^-T dL^T n, dV = dE p - W y.
MotionChange AffineMotion::Differentiate(const SolveMaps& change, const Eigen::Vector3d& position,
                                         const Eigen::Vector3d& normal, const Eigen::Matrix3d& normal_gradient) const {
  const Eigen::Vector3d place = ToBody(position);
  const Eigen::Vector3d moved = Apply(change.start, place);
  MotionChange result;
  result.distance = -normal.dot(moved);
  result.normal = -normal_gradient * moved -
                  Projection(normal) * (to_body_.transpose() * (change.start.leftCols<3>().transpose() * normal));
  result.velocity = Apply(change.velocity, place) - velocity_.gradient * moved;
  result.velocity_change = Apply(change.velocity_change, place) - velocity_change_.gradient * moved;
  return result;
}

MovedShape::MovedShape(std::shared_ptr<const Obstacle> shape, const AffineMap& pose)
    : shape_(std::move(shape)), motion_(MapsAt(pose)) {}

SurfacePoint MovedShape::Closest(const Eigen::Vector3d& position) const {
  return motion_.Closest(*shape_, position).surface;
}

}  // namespace clothid
