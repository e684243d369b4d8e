// Scenes of a plain cloth in the air, for tests against closed forms.
#ifndef CLOTHID_TESTS_SIM_PLAIN_SCENES_H_
#define CLOTHID_TESTS_SIM_PLAIN_SCENES_H_

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>

#include "sim/mesh/mesh.h"
#include "sim/rollout/rollout.h"
#include "sim/rollout/simulator.h"
#include "sim/scene/scene.h"

namespace clothid {

inline constexpr double kPi = 3.14159265358979323846;

// A square of cloth at rest, in the air, with a tight step tolerance; by backward Euler, unless a test says otherwise.
inline Scene ClothScene(const GridOptions& grid, double time_step) {
  Scene scene;
  scene.integrator = Integrator::kEuler;
  scene.time_step = time_step;
  scene.mesh = MakeGrid(grid);
  scene.initial_positions = scene.mesh.rest_positions.reshaped();
  scene.initial_velocities = Eigen::VectorXd::Zero(scene.initial_positions.size());
  scene.solver.step_tolerance = 1e-12;
  return scene;
}

inline GridOptions SquareGrid(int nodes, double size) {
  GridOptions grid;
  grid.nodes = {nodes, nodes};
  grid.size = {size, size};
  return grid;
}

inline Rollout SimulateNominal(const Scene& scene, int num_steps) {
  Simulator simulator(scene);
  Rollout rollout = Simulate(scene.nominal_parameters(), num_steps, &simulator);
  EXPECT_TRUE(rollout.ok()) << rollout.failure->ToString();
  return rollout;
}

// Makes the cloth of `scene` a sleeve about the z axis, at rest: `num_rings` rings of `ring_size` nodes each, the
// highest first. Where the rings move along z alone, each as a whole, all of their nodes are alike.
inline void PutSleeve(int num_rings, int ring_size, double radius, double row_height, Scene* scene) {
  Mesh& mesh = scene->mesh;
  mesh.rest_positions.resize(3, num_rings * ring_size);
  mesh.faces.resize(3, 2 * (num_rings - 1) * ring_size);
  for (int ring = 0; ring < num_rings; ++ring) {
    for (int i = 0; i < ring_size; ++i) {
      const double angle = 2.0 * kPi * i / ring_size;
      mesh.rest_positions.col(ring * ring_size + i) << radius * std::cos(angle), radius * std::sin(angle),
          -ring * row_height;
    }
  }
  for (int quad = 0; quad < (num_rings - 1) * ring_size; ++quad) {
    const int next = quad % ring_size == ring_size - 1 ? quad + 1 - ring_size : quad + 1;
    mesh.faces.col(2 * quad) << quad, quad + ring_size, next;
    mesh.faces.col(2 * quad + 1) << next, quad + ring_size, next + ring_size;
  }
  scene->initial_positions = mesh.rest_positions.reshaped();
  scene->initial_velocities = Eigen::VectorXd::Zero(scene->initial_positions.size());
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_SIM_PLAIN_SCENES_H_
