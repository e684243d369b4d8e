// Linear air drag relative to the wind, the same in every direction: f_j = c_d a_j (w(t, X_j) - v_j), a_j a third of
// the adjacent rest area.
#ifndef CLOTHID_SIM_FORCE_AIR_DRAG_H_
#define CLOTHID_SIM_FORCE_AIR_DRAG_H_

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "sim/scene/scene.h"

namespace clothid {

// dw/dtheta of `Wind::At`, theta the parameter `id` of a wind.
Eigen::Vector3d WindDerivative(const Wind& wind, ParameterId id, double time, const RestPlace& place);

class AirDrag {
 public:
  explicit AirDrag(const Scene& scene);

  // a_j [N], m^2; with drag by pieces times their share of the level.
  const Eigen::VectorXd& areas() const { return areas_; }
  void SetAreas(Eigen::VectorXd areas) { areas_ = std::move(areas); }

  // w at time t and rest position X_j, m/s, and its derivative by the parameter `id` of the wind.
  Eigen::Vector3d WindAt(int node, double time, const Wind& wind) const { return wind.At(time, places_[node]); }
  Eigen::Vector3d WindDerivativeAt(int node, double time, const Wind& wind, ParameterId id) const {
    return WindDerivative(wind, id, time, places_[node]);
  }

 private:
  Eigen::VectorXd areas_;
  std::vector<RestPlace> places_;  // [N]
};

}  // namespace clothid

#endif  // CLOTHID_SIM_FORCE_AIR_DRAG_H_
