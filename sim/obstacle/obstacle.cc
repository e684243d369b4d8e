#include "sim/obstacle/obstacle.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "sim/obstacle/shape_checks.h"

namespace clothid {
namespace {

double CheckedRadius(double radius) {
  return CheckedLength(radius, "an obstacle's radius must be positive and finite");
}

// Of a round surface at the offset `offset` from its centre line. `straight` projects on the directions in which the
// surface has no curvature; `fallback` is the normal where the offset has no direction.
SurfacePoint RoundSurface(const Eigen::Vector3d& offset, double radius, const Eigen::Matrix3d& straight,
                          const Eigen::Vector3d& fallback) {
  SurfacePoint result;
  const double distance = offset.stableNorm();
  result.gap = distance - radius;
  if (distance <= kSingular * radius) {
    result.normal = fallback;
    return result;
  }
  const Eigen::Vector3d n = offset / distance;
  result.normal = n;
  result.normal_gradient = (Eigen::Matrix3d::Identity() - n * n.transpose() - straight) / distance;
  return result;
}

}  // namespace

Plane::Plane(const Eigen::Vector3d& point, const Eigen::Vector3d& normal)
    : point_(CheckedPoint(point)),
      normal_(CheckedDirection(normal, "a plane's normal must be finite and longer than zero")) {}

SurfacePoint Plane::Closest(const Eigen::Vector3d& position) const {
  SurfacePoint result;
  result.gap = normal_.dot(position - point_);
  result.normal = normal_;
  return result;
}

Sphere::Sphere(const Eigen::Vector3d& center, double radius)
    : center_(CheckedPoint(center)), radius_(CheckedRadius(radius)) {}

SurfacePoint Sphere::Closest(const Eigen::Vector3d& position) const {
  return RoundSurface(position - center_, radius_, Eigen::Matrix3d::Zero(), Eigen::Vector3d::UnitZ());
}

Capsule::Capsule(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius)
    : from_(CheckedPoint(from)),
      axis_(CheckedDirection(CheckedPoint(to) - from, "a capsule's two ends must be different points")),
      length_((to - from).stableNorm()),
      radius_(CheckedRadius(radius)) {}

SurfacePoint Capsule::Closest(const Eigen::Vector3d& position) const {
  const Eigen::Vector3d from_start = position - from_;
  const double along = axis_.dot(from_start);
  const bool on_cylinder = along > 0.0 && along < length_;
  const Eigen::Vector3d offset = from_start - std::clamp(along, 0.0, length_) * axis_;
  const Eigen::Matrix3d straight = on_cylinder ? Eigen::Matrix3d(axis_ * axis_.transpose()) : Eigen::Matrix3d::Zero();
  return RoundSurface(offset, radius_, straight, axis_.unitOrthogonal());
}

}  // namespace clothid
