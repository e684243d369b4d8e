#include "sim/scene/warp.h"

#include <Eigen/Geometry>
#include <cmath>

#include "sim/base/error.h"

namespace clothid {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kLeastShare = 1e-3;  // of the direction that must lie in the plane of a triangle

Eigen::Vector3d Normal(const Mesh& mesh, int face) {
  const Eigen::Vector3d corner = RestCorner(mesh, face, 0);
  return (RestCorner(mesh, face, 1) - corner).cross(RestCorner(mesh, face, 2) - corner).normalized();
}

Eigen::Vector3d InPlane(const Eigen::Vector3d& direction, const Eigen::Vector3d& normal) {
  return direction - direction.dot(normal) * normal;
}

Eigen::Vector3d DirectionOf(const Warp& warp, int face) {
  return warp.directions.cols() > 0 ? Eigen::Vector3d(warp.directions.col(face)) : warp.direction;
}

}  // namespace

Eigen::Matrix3Xd WarpDirections(const Warp& warp, const Mesh& mesh) {
  const double radians = warp.angle * kPi / 180.0, cosine = std::cos(radians), sine = std::sin(radians);
  Eigen::Matrix3Xd directions(3, mesh.num_faces());
  for (int face = 0; face < mesh.num_faces(); ++face) {
    const Eigen::Vector3d normal = Normal(mesh, face), first = InPlane(DirectionOf(warp, face), normal).normalized();
    directions.col(face) = cosine * first + sine * normal.cross(first);
  }
  return directions;
}

void ValidateWarp(const Warp& warp, const Mesh& mesh, const std::string& source) {
  if (!std::isfinite(warp.angle)) {
    throw Error(ErrorKind::kBadData, source + ": key 'materials.warp_angle': expected a finite number");
  }
  const auto expect = [&source](bool condition, const std::string& expected) {
    if (!condition) throw Error(ErrorKind::kBadData, source + ": key 'materials.warp_direction': expected " + expected);
  };
  const bool has_one = warp.directions.cols() == 0;
  expect(has_one || warp.directions.cols() == mesh.num_faces(),
         "one direction, or one for each of the " + std::to_string(mesh.num_faces()) + " triangles, found " +
             std::to_string(warp.directions.cols()));
  for (int face = 0; face < mesh.num_faces(); ++face) {
    const Eigen::Vector3d direction = DirectionOf(warp, face);
    const double length = direction.norm();
    expect(std::isfinite(length) && length > 0.0,
           has_one ? "a direction, not zero" : "a direction, not zero, for triangle " + std::to_string(face));
    expect(InPlane(direction, Normal(mesh, face)).norm() > kLeastShare * length,
           "a direction along the cloth; triangle " + std::to_string(face) + " is perpendicular to it");
  }
}

}  // namespace clothid
