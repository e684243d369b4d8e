// Scenes in which a cloth meets itself.
#ifndef CLOTHID_TESTS_SIM_SELF_CONTACT_SCENES_H_
#define CLOTHID_TESTS_SIM_SELF_CONTACT_SCENES_H_

#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "sim/mesh/mesh.h"
#include "sim/scene/scene.h"
#include "tests/sim/joined_mesh.h"
#include "tests/sim/plain_scenes.h"

namespace clothid {

// Layers that lie on each other, `thickness` apart; the lowest one is as large as its grid and held, those above are
// smaller and free. Gravity is turned by `angle` about the y axis: it pulls along x down the slope.
inline Scene LayersOnASlope(int num_layers, double angle, double friction, Integrator integrator, double time_step) {
  constexpr double kThickness = 0.003;
  GridOptions grid;
  grid.nodes = {21, 6};
  grid.size = {0.4, 0.1};
  std::vector<Mesh> parts = {MakeGrid(grid)};
  const int num_held = parts[0].num_nodes();
  for (int layer = 1; layer < num_layers; ++layer) {
    GridOptions upper = grid;
    upper.nodes = {8 - layer, 4};
    upper.size = {0.12 - 0.015 * layer, 0.055 - 0.01 * layer};
    upper.origin = {0.031 + 0.0071 * layer, 0.0213 + 0.0053 * layer, layer * kThickness};
    parts.push_back(MakeGrid(upper));
  }
  Scene scene;
  scene.mesh = JoinedMesh(parts);
  scene.initial_positions = scene.mesh.rest_positions.reshaped();
  scene.initial_velocities = Eigen::VectorXd::Zero(scene.initial_positions.size());
  for (int node = 0; node < num_held; ++node) scene.handles.nodes.push_back(node);
  scene.gravity = 9.81 * Eigen::Vector3d(std::sin(angle), 0.0, -std::cos(angle));
  scene.integrator = integrator;
  scene.time_step = time_step;
  scene.material.bending_stiffness = 1e-5;
  scene.self_contact = SelfContact{friction, kThickness};
  scene.solver.step_tolerance = 1e-11;
  return scene;
}

// Two free sheets without gravity, the smaller of which, nodes 49 and on, falls on the other one at an angle.
inline Scene CollidingSheets(Integrator integrator) {
  const GridOptions lower = SquareGrid(7, 0.1);
  GridOptions upper = SquareGrid(6, 0.08);
  upper.origin = {0.013, 0.007, 0.006};
  Scene scene = ClothScene(lower, 0.005);
  scene.integrator = integrator;
  scene.mesh = JoinedMesh({MakeGrid(lower), MakeGrid(upper)});
  scene.initial_positions = scene.mesh.rest_positions.reshaped();
  scene.initial_velocities = Eigen::VectorXd::Zero(scene.initial_positions.size());
  for (int node = 49; node < scene.mesh.num_nodes(); ++node) {
    scene.initial_velocities.segment<3>(3 * node) << 0.1, 0.05, -0.3;
  }
  scene.gravity.setZero();
  scene.self_contact = SelfContact{0.3, 0.003};
  return scene;
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_SIM_SELF_CONTACT_SCENES_H_
