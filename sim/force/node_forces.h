// What acts on every node by itself: inertia, gravity, the scene's node force and the drag that is the same in every
// direction (air_drag.h). Over a solve of size h, to the gradient of sim/step/step_problem.h
//
//   M (v - v_n) - h (rho b g_0 + node_force + c_d a (w - v)),   M = rho b + rho_a a
// with the areas a of a node, a third of those of its triangles, b those times the factors of a density that varies,
// and rho_a the added mass, which has no weight.
#ifndef CLOTHID_SIM_FORCE_NODE_FORCES_H_
#define CLOTHID_SIM_FORCE_NODE_FORCES_H_

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "sim/force/air_drag.h"
#include "sim/force/force_term.h"
#include "sim/scene/parameters.h"
#include "sim/scene/scene.h"

namespace clothid {

// Of a node over a solve.
struct NodeMotion {
  int node;
  double time_step;          // h, s
  double time;               // at the end, s
  Eigen::Vector3d change;    // v - v_n, m/s
  Eigen::Vector3d velocity;  // v, m/s
};
// From the velocities at both ends [3N].
inline NodeMotion MotionOf(int node, double time_step, double time, const Eigen::VectorXd& start_velocities,
                           const Eigen::VectorXd& velocities) {
  const Eigen::Vector3d velocity = velocities.segment<3>(3 * node);
  return {node, time_step, time, velocity - start_velocities.segment<3>(3 * node), velocity};
}

class NodeForces {
 public:
  explicit NodeForces(const Scene& scene);

  void SetVariation(const ForceVariation& variation, const Mesh& mesh);

  const Eigen::VectorXd& areas() const { return areas_; }                                              // a [N] m^2
  const Eigen::VectorXd& mass_areas() const { return mass_areas_.size() > 0 ? mass_areas_ : areas_; }  // b [N] m^2
  bool has_density_field() const { return mass_areas_.size() > 0; }
  const AirDrag* drag() const { return drag_ ? &*drag_ : nullptr; }  // null: the scene has none

  // M, kg.
  double mass(const Material& material, int node) const {
    return material.density * mass_areas()[node] + material.added_mass * areas_[node];
  }
  // c_d a, kg/s; 0 without drag.
  double drag(const Material& material, int node) const { return drag_ ? material.drag * drag_->areas()[node] : 0.0; }
  // M + h c_d a, kg, what g gains by v, is ArealSlope a + FurtherSlope: the one of constants that are the same all over
  // the cloth, kg/m^2, the other what they vary by.
  double ArealSlope(const Material& material, double time_step) const {
    return material.areal_inertia() + (drag_ ? time_step * material.drag : 0.0);
  }
  double FurtherSlope(const Material& material, double time_step, int node) const;

  // What stands above, N s, and its derivative by the parameter `id`, zero for one that it does not have.
  bool DependOn(ParameterId id) const;
  Eigen::Vector3d Impulse(const NodeMotion& motion, const Parameters& parameters) const;
  Eigen::Vector3d ImpulseDerivative(ParameterId id, const NodeMotion& motion, const Parameters& parameters) const;
  // dM/dtheta of every node [N]; null for a parameter that has no part in it.
  const Eigen::VectorXd* MassSlopes(ParameterId id) const;

 private:
  const Eigen::VectorXd& DragAreas(ParameterId id) const;  // that c_d `id` multiplies

  Eigen::Vector3d gravity_, node_force_;
  Eigen::VectorXd areas_;
  Eigen::VectorXd mass_areas_;  // empty where the density does not vary
  std::optional<AirDrag> drag_;
  // Of each piece of the cloth, and last of the whole, its areas at every node [N] m^2; empty: one.
  std::vector<Eigen::VectorXd> piece_areas_;
  bool has_density_pieces_ = false;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_FORCE_NODE_FORCES_H_
