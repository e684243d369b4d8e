#include "sim/force/air_drag.h"

#include <cmath>

namespace clothid {

namespace {

// Of what the shear is a factor of: mean + profile(t) + gust sin(angle).
Eigen::Vector3d UnshearedDerivative(const Wind& wind, ParameterId id, double time, const RestPlace& place) {
  const ParameterRow& row = RowOf(id.kind);
  if (row.term != ParameterTerm::kWind) return Eigen::Vector3d::Zero();
  const double angle = wind.GustAngle(time, place);
  if (row.wind_vector == &Wind::mean) {
    return (id.part == kWhole ? 1.0 : wind.profile.Weight(id.part, time)) * Eigen::Vector3d::Unit(id.axis);
  }
  if (row.wind_vector == &Wind::gust) return std::sin(angle) * Eigen::Vector3d::Unit(id.axis);
  // What else there is moves the angle: by its frequency, its wave vector or its phase.
  const double slope = row.wind_number == &Wind::frequency     ? time
                       : row.wind_vector == &Wind::wave_vector ? place.position[id.axis]
                                                               : 1.0;
  return slope * std::cos(angle) * wind.gust;
}

}  // namespace

Eigen::Vector3d WindDerivative(const Wind& wind, ParameterId id, double time, const RestPlace& place) {
  const ParameterRow& row = RowOf(id.kind);
  if (row.wind_vector != &Wind::shear) return wind.ShearFactor(place) * UnshearedDerivative(wind, id, time, place);
  Wind unsheared = wind;
  unsheared.shear.setZero();
  return place.from_center[id.axis] * unsheared.At(time, place);
}

AirDrag::AirDrag(const Scene& scene)
    : areas_(NodeAreas(scene.mesh)), places_(RestPlaces(scene.mesh.rest_positions, areas_)) {}

}  // namespace clothid
