// Cloths that are moved by their handles, and rollouts of them with the forces there.
#ifndef CLOTHID_TESTS_SIM_HELD_ROLLOUTS_H_
#define CLOTHID_TESTS_SIM_HELD_ROLLOUTS_H_

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "sim/rollout/handle_forces.h"
#include "sim/rollout/rollout.h"
#include "sim/rollout/simulator.h"
#include "tests/sim/plain_scenes.h"

namespace clothid {

inline constexpr Integrator kIntegrators[] = {Integrator::kEuler, Integrator::kSdirk2};
using HandleGroups = std::vector<std::vector<int>>;  // of handles

// A rollout with the forces of groups of its handles.
struct HeldRollout {
  Scene scene;
  Simulator simulator;
  Rollout rollout;
  HandleForces forces;
  Eigen::MatrixXd values;  // [3G x steps + 1]

  HeldRollout(const Scene& given, const HandleGroups& groups)
      : scene(given),
        simulator(scene),
        rollout(Simulate(scene.nominal_parameters(), scene.num_steps(), &simulator)),
        forces(simulator.model(), rollout.parameters, scene.num_steps(), groups) {
    EXPECT_TRUE(rollout.ok()) << rollout.failure->ToString();
    Eigen::MatrixXd states(3 * static_cast<Eigen::Index>(forces.nodes().size()), scene.num_steps() + 1);
    for (int step = 0; step <= scene.num_steps(); ++step) states.col(step) = forces.Gather(rollout.positions(step));
    values = forces.Over(states);
  }

  double total_mass() const {
    return rollout.parameters.material.density * simulator.model().nodes().mass_areas().sum();
  }
  Eigen::VectorXd AccelerationAt(int step) const {
    const double h = scene.time_step;
    return (rollout.positions(step + 1) - 2.0 * rollout.positions(step) + rollout.positions(step - 1)) / (h * h);
  }
};

inline std::vector<int> FirstRow(int count) {
  std::vector<int> nodes;
  for (int i = 0; i < count; ++i) nodes.push_back(i);
  return nodes;
}

// The handles move from where they are by `shift`(t), given at so many knots.
template <typename Shift>
void MoveHandles(int num_knots, const Shift& shift, Scene* scene) {
  const std::vector<int>& nodes = scene->handles.nodes;
  const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(num_knots, 0.0, scene->duration);
  Eigen::MatrixXd path(3 * static_cast<Eigen::Index>(nodes.size()), num_knots);
  for (int k = 0; k < num_knots; ++k) {
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      path.col(k).segment<3>(3 * static_cast<Eigen::Index>(i)) =
          scene->initial_positions.segment<3>(3 * nodes[i]) + shift(times[k]);
    }
  }
  scene->handles.path = HandlePath(times, path);
}

// Every term at once, its first row shaken.
inline Scene ShakenCloth(Integrator integrator, double time_step) {
  Scene scene = ClothScene(SquareGrid(6, 0.3), time_step);
  scene.integrator = integrator;
  scene.duration = 0.24;
  scene.handles.nodes = FirstRow(6);
  scene.material.bending_stiffness = 1e-4;
  scene.material.damping = 0.05;
  scene.material.drag = 0.1;
  scene.wind.mean = Eigen::Vector3d(0.3, 0.1, 0.2);
  scene.node_force = Eigen::Vector3d(1e-4, 0.0, 2e-4);
  MoveHandles(
      25, [](double t) { return Eigen::Vector3d(0.0, 0.02 * std::sin(15.0 * t), 0.03 * t * t); }, &scene);
  return scene;
}

// Drag by direction, pressure, a rest shape that is curved, and links at and beside the handles, one of which closes.
inline Scene WithEveryForce(Scene scene) {
  scene.material.normal_drag = 0.4;
  scene.material.tangential_drag = 0.15;
  scene.material.pressure = 1.5;
  scene.mesh.links = {{2, {14, 14}, 0.0, 3.0, 0.0}, {9, {3, 4}, 0.4, 5.0, 0.2}, {20, {27, 28}, 0.5, 4.0, 0.1}};
  for (int node = 0; node < scene.mesh.num_nodes(); ++node) {
    const double along = scene.mesh.rest_positions(0, node);
    scene.mesh.rest_positions(2, node) += 0.5 * along * along;
  }
  scene.initial_positions = scene.mesh.rest_positions.reshaped();
  return scene;
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_SIM_HELD_ROLLOUTS_H_
