#include "sim/obstacle/box.h"

#include <cmath>

#include "sim/base/error.h"
#include "sim/obstacle/shape_checks.h"

namespace clothid {
namespace {

Eigen::Vector3d CheckedSize(const Eigen::Vector3d& size) {
  for (const double length : size) CheckedLength(length, "a box's lengths must be positive and finite");
  return size;
}

double CheckedRounding(double radius, const Eigen::Vector3d& size) {
  if (!(radius >= 0.0) || radius > 0.5 * size.minCoeff()) {
    throw Error(ErrorKind::kBadData, "the radius of a box's edges must be from 0 to half its smallest length");
  }
  return radius;
}

Eigen::Matrix3d CheckedRotation(const Eigen::Quaterniond& rotation) {
  const double length =
      CheckedLength(rotation.coeffs().stableNorm(), "a box's rotation must be finite and longer than zero");
  return Eigen::Quaterniond(rotation.coeffs() / length).toRotationMatrix();
}

}  // namespace

Box::Box(const Eigen::Vector3d& center, const Eigen::Vector3d& size, const Eigen::Quaterniond& rotation, double radius)
    : size_(CheckedSize(size)),
      core_(0.5 * size.array() - CheckedRounding(radius, size)),
      radius_(radius),
      frame_{CheckedPoint(center), CheckedRotation(rotation)} {}

Box Box::Table(const Eigen::Vector3d& top, const Eigen::Vector3d& normal, const Eigen::Vector3d& along,
               const Eigen::Vector2d& size, double thickness, double radius) {
  constexpr double kParallel = 1e-6;  // the sine of the angle between two directions that count as one
  const Eigen::Vector3d up = CheckedDirection(normal, "a table's normal must be finite and longer than zero");
  const Eigen::Vector3d side = CheckedDirection(along, "a table's sides must run along a direction longer than zero");
  const Eigen::Vector3d in_top = side - up.dot(side) * up;
  if (in_top.norm() < kParallel) {
    throw Error(ErrorKind::kBadData,
                "a table's sides must not run along its normal: choose another direction \"along\"");
  }
  Eigen::Matrix3d axes;
  axes.col(0) = in_top.normalized();
  axes.col(1) = up.cross(axes.col(0));
  axes.col(2) = up;
  return Box(top - 0.5 * thickness * up, {size[0], size[1], thickness}, Eigen::Quaterniond(axes), radius);
}

SurfacePoint Box::Closest(const Eigen::Vector3d& position) const {
  const Eigen::Vector3d x = frame_.ToLocal(position), beyond = x.cwiseAbs() - core_;  // q
  const Eigen::Vector3d side = (x.array() < 0.0).select(-Eigen::Array3d::Ones(), Eigen::Array3d::Ones());
  const Eigen::Vector3d offset = side.cwiseProduct(beyond.cwiseMax(0.0));
  const double distance = offset.stableNorm();
  const bool is_over_edge = (beyond.array() > 0.0).count() > 1;
  SurfacePoint local;
  if (is_over_edge && distance > kSingular * size_.maxCoeff()) {
    const Eigen::Vector3d n = local.normal = offset / distance;
    const Eigen::Vector3d is_beyond = (beyond.array() > 0.0).cast<double>();
    local.gap = distance - radius_;
    local.normal_gradient = (Eigen::Matrix3d(is_beyond.asDiagonal()) - n * n.transpose()) / distance;
  } else {
    Eigen::Index face = 0;
    const double height = beyond.maxCoeff(&face);
    local.gap = (is_over_edge ? distance : height) - radius_;
    local.normal = side[face] * Eigen::Vector3d::Unit(face);
  }
  return frame_.ToWorld(local);
}

}  // namespace clothid
