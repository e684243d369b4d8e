// Linear air drag relative to the wind: f_j = c_d a_j (w(t, X_j) - v_j), a_j a third of the adjacent rest area.
#ifndef CLOTHID_SIM_CLOTH_AIR_DRAG_H_
#define CLOTHID_SIM_CLOTH_AIR_DRAG_H_

#include <Eigen/Core>

#include "sim/scene/scene.h"

namespace clothid {

class AirDrag {
 public:
  explicit AirDrag(const Scene& scene);

  // a_j [N], m^2.
  const Eigen::VectorXd& areas() const { return areas_; }

  // w at time t and rest position X_j, m/s.
  Eigen::Vector3d WindAt(int node, double time) const;

 private:
  Eigen::VectorXd areas_;
  Eigen::VectorXd phases_;  // wave_vector . X_j [N], rad
  Wind wind_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_CLOTH_AIR_DRAG_H_
