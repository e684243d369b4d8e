#include "sim/cloth/air_drag.h"

#include <cmath>

namespace clothid {

Eigen::Vector3d WindDerivative(const Wind& wind, ParameterId id, double time, double wave_phase) {
  const double angle = wind.frequency * time + wave_phase + wind.phase;
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
    default:
      return Eigen::Vector3d::Zero();
  }
}

AirDrag::AirDrag(const Scene& scene)
    : areas_(NodeAreas(scene.mesh)), phases_(scene.mesh.rest_positions.transpose() * scene.wind.wave_vector) {}

}  // namespace clothid
