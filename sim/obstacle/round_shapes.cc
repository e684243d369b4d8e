#include "sim/obstacle/round_shapes.h"

#include <cmath>

#include "sim/base/error.h"
#include "sim/obstacle/shape_checks.h"

namespace clothid {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// A point as its distance from the third axis and its height along it.
struct Meridian {
  double rho = 0.0, height = 0.0;                // m
  Vector3d outward = Vector3d::UnitX();          // e
  Matrix3d outward_gradient = Matrix3d::Zero();  // de/dx
};

Meridian MeridianOf(const Vector3d& local, double size) {
  Meridian at;
  at.rho = std::hypot(local.x(), local.y());
  at.height = local.z();
  if (at.rho <= kSingular * size) return at;
  at.outward = Vector3d(local.x() / at.rho, local.y() / at.rho, 0.0);
  const Vector3d around(-at.outward.y(), at.outward.x(), 0.0);  // t
  at.outward_gradient = around * around.transpose() / at.rho;
  return at;
}

// Distance to the circle of `radius` at `height`, and its derivatives.
SurfacePoint FromCircle(const Meridian& at, double radius, double height) {
  const double across = at.rho - radius, along = at.height - height;
  SurfacePoint result;
  result.gap = std::hypot(across, along);
  result.normal = at.outward;
  if (result.gap <= kSingular * radius) return result;
  const double sine = across / result.gap, cosine = along / result.gap;
  const Vector3d turned = sine * Vector3d::UnitZ() - cosine * at.outward;  // m
  result.normal = sine * at.outward + cosine * Vector3d::UnitZ();
  result.normal_gradient = turned * turned.transpose() / result.gap + sine * at.outward_gradient;
  return result;
}

}  // namespace

Cylinder::Cylinder(const Vector3d& from, const Vector3d& to, double radius)
    : frame_(ShapeFrame::About(
          from + 0.5 * (to - from),
          CheckedDirection(CheckedPoint(to) - CheckedPoint(from), "a cylinder's two ends must be different points"))),
      half_length_(0.5 * (to - from).stableNorm()),
      radius_(CheckedLength(radius, "a cylinder's radius must be positive and finite")) {}

SurfacePoint Cylinder::Closest(const Vector3d& position) const {
  const Meridian at = MeridianOf(frame_.ToLocal(position), radius_);
  const double end = at.height < 0.0 ? -1.0 : 1.0;
  const double beyond_side = at.rho - radius_, beyond_end = std::abs(at.height) - half_length_;
  if (beyond_side > 0.0 && beyond_end > 0.0) return frame_.ToWorld(FromCircle(at, radius_, end * half_length_));
  SurfacePoint local;
  if (beyond_side >= beyond_end) {
    local.gap = beyond_side;
    local.normal = at.outward;
    local.normal_gradient = at.outward_gradient;
  } else {
    local.gap = beyond_end;
    local.normal = end * Vector3d::UnitZ();
  }
  return frame_.ToWorld(local);
}

Torus::Torus(const Vector3d& center, const Vector3d& axis, double radius, double tube_radius)
    : frame_(ShapeFrame::About(CheckedPoint(center),
                               CheckedDirection(axis, "a torus's axis must be finite and longer than zero"))),
      radius_(CheckedLength(radius, "a torus's radius must be positive and finite")),
      tube_radius_(CheckedLength(tube_radius, "a torus's tube_radius must be positive and finite")) {
  if (!(tube_radius < radius)) {
    throw Error(ErrorKind::kBadData, "a torus's tube_radius must be smaller than its radius");
  }
}

SurfacePoint Torus::Closest(const Vector3d& position) const {
  SurfacePoint local = FromCircle(MeridianOf(frame_.ToLocal(position), radius_), radius_, 0.0);
  local.gap -= tube_radius_;
  return frame_.ToWorld(local);
}

Bowl::Bowl(const Vector3d& center, const Vector3d& axis, double radius, double angle, double thickness)
    : frame_(ShapeFrame::About(CheckedPoint(center),
                               CheckedDirection(axis, "a bowl's axis must be finite and longer than zero"))),
      angle_(angle),
      thickness_(CheckedLength(thickness, "a bowl's thickness must be positive and finite")),
      middle_radius_(CheckedLength(radius, "a bowl's radius must be positive and finite") + 0.5 * thickness),
      rim_radius_(middle_radius_ * std::sin(angle)),
      rim_height_(-middle_radius_ * std::cos(angle)) {
  if (!(angle > 0.0 && angle < M_PI)) {
    throw Error(ErrorKind::kBadData, "a bowl's angle must be more than 0 and less than 180 degrees");
  }
  if (angle > M_PI_2 && !(rim_radius_ > 0.5 * thickness)) {
    throw Error(ErrorKind::kBadData, "a bowl's opening must be wider than its shell is thick: a smaller angle");
  }
}

SurfacePoint Bowl::Closest(const Vector3d& position) const {
  const Vector3d x = frame_.ToLocal(position);
  const Meridian at = MeridianOf(x, middle_radius_);
  // sin(angle - that of x) >= 0, times R and |x|
  const bool is_within_angle = rim_height_ * at.rho - rim_radius_ * at.height >= 0.0;
  const double r = x.stableNorm();
  SurfacePoint local;
  if (r <= kSingular * middle_radius_) {
    local.gap = middle_radius_;
  } else if (is_within_angle) {
    const double side = r < middle_radius_ ? -1.0 : 1.0;
    const Vector3d away = x / r;
    local.gap = std::abs(r - middle_radius_);
    local.normal = side * away;
    local.normal_gradient = (side / r) * (Matrix3d::Identity() - away * away.transpose());
  } else {
    local = FromCircle(at, rim_radius_, rim_height_);
  }
  local.gap -= 0.5 * thickness_;
  return frame_.ToWorld(local);
}

}  // namespace clothid
