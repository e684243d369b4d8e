#include "sim/obstacle/deformed_surface.h"

#include <utility>

namespace clothid {
namespace {

bool IsFlat(const SurfaceFeature& feature) { return feature.kind == SurfaceFeature::Kind::kPlane; }

}  // namespace

DeformedSurface::DeformedSurface(TriangulatedSurface start, MapsOfFace maps)
    : start_(std::move(start)), maps_(std::move(maps)) {}

// The third axis of A_0 is the normal but for terms of second order in the step, in the second stage of a step.
MovedSurfacePoint DeformedSurface::Closest(const Eigen::Vector3d& position) const {
  const NearestFeature nearest = start_.Nearest(position);
  MovedSurfacePoint result{nearest.point, 1.0, nearest.face};
  if (!IsFlat(nearest.feature)) return result;
  result.slope = 1.0 / nearest.point.normal.dot(maps_(nearest.face).start.col(2));
  result.surface.gap *= result.slope;
  return result;
}

AffineMotion DeformedSurface::MotionNear(const Eigen::Vector3d& position) const {
  return MotionOf(start_.Nearest(position).face);
}

// On edges and vertices, with the change dq of the closest point q of the face, and that of the direction a of an edge,
// da = (I - a a^T) dL L^-1 a: dgap = -n . dq, dn = -N dq - a (n . da).
MotionChange DeformedSurface::Differentiate(const MapsOfFace& change, const Eigen::Vector3d& position) const {
  const NearestFeature nearest = start_.Nearest(position);
  const Eigen::Vector3d& n = nearest.point.normal;
  const SolveMaps maps = change(nearest.face);
  const AffineMotion motion = MotionOf(nearest.face);
  MotionChange result = motion.Differentiate(maps, position, n, nearest.point.normal_gradient);
  if (IsFlat(nearest.feature)) return result;
  const Eigen::Vector3d& a = nearest.feature.along;  // zero of a vertex
  const Eigen::Vector3d moved = Apply(maps.start, motion.ToBody(position - nearest.point.gap * n));
  const Eigen::Vector3d turned = maps.start.leftCols<3>() * (motion.ToBody(position + a) - motion.ToBody(position));
  result.distance = -n.dot(moved);
  result.normal = -nearest.point.normal_gradient * moved - n.dot(turned) * a;  // n . a = 0
  return result;
}

}  // namespace clothid
