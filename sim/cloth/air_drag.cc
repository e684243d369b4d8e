#include "sim/cloth/air_drag.h"

#include <cmath>

namespace clothid {

AirDrag::AirDrag(const Scene& scene)
    : areas_(NodeAreas(scene.mesh)),
      phases_(scene.mesh.rest_positions.transpose() * scene.wind.wave_vector),
      wind_(scene.wind) {}

Eigen::Vector3d AirDrag::WindAt(int node, double time) const {
  return wind_.mean + wind_.gust * std::sin(wind_.frequency * time + phases_[node]);
}

}  // namespace clothid
