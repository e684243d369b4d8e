#include "sim/cloth/air_drag.h"

#include <cmath>

namespace clothid {

namespace {

// Of what the shear is a factor of.
Eigen::Vector3d UnshearedDerivative(const Wind& wind, ParameterId id, double time, const RestPlace& place) {
  const double angle = wind.GustAngle(time, place);
  const double share = id.knot == kMeanWind ? 1.0 : wind.profile.Weight(id.knot, time);
  switch (id.kind) {
    case ParameterKind::kWindX:
      return share * Eigen::Vector3d::UnitX();
    case ParameterKind::kWindY:
      return share * Eigen::Vector3d::UnitY();
    case ParameterKind::kWindZ:
      return share * Eigen::Vector3d::UnitZ();
    case ParameterKind::kGustX:
      return std::sin(angle) * Eigen::Vector3d::UnitX();
    case ParameterKind::kGustY:
      return std::sin(angle) * Eigen::Vector3d::UnitY();
    case ParameterKind::kGustZ:
      return std::sin(angle) * Eigen::Vector3d::UnitZ();
    case ParameterKind::kGustFrequency:
      return time * std::cos(angle) * wind.gust;
    case ParameterKind::kGustPhase:
      return std::cos(angle) * wind.gust;
    case ParameterKind::kGustWaveX:
      return place.position.x() * std::cos(angle) * wind.gust;
    case ParameterKind::kGustWaveY:
      return place.position.y() * std::cos(angle) * wind.gust;
    case ParameterKind::kGustWaveZ:
      return place.position.z() * std::cos(angle) * wind.gust;
    default:
      return Eigen::Vector3d::Zero();
  }
}

// 0, 1 or 2 of a component of the shear; -1 of another kind.
int ShearAxis(ParameterKind kind) {
  return kind == ParameterKind::kWindShearX   ? 0
         : kind == ParameterKind::kWindShearY ? 1
         : kind == ParameterKind::kWindShearZ ? 2
                                              : -1;
}

}  // namespace

Eigen::Vector3d WindDerivative(const Wind& wind, ParameterId id, double time, const RestPlace& place) {
  const int axis = ShearAxis(id.kind);
  if (axis < 0) return wind.ShearFactor(place) * UnshearedDerivative(wind, id, time, place);
  Wind unsheared = wind;
  unsheared.shear.setZero();
  return place.from_center[axis] * unsheared.At(time, place);
}

AirDrag::AirDrag(const Scene& scene)
    : areas_(NodeAreas(scene.mesh)), places_(RestPlaces(scene.mesh.rest_positions, areas_)) {}

}  // namespace clothid
