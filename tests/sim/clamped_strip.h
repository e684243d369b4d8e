// A strip that one row of nodes clamps, for tests against the theory of thin plates.
#ifndef CLOTHID_TESTS_SIM_CLAMPED_STRIP_H_
#define CLOTHID_TESTS_SIM_CLAMPED_STRIP_H_

#include <Eigen/Core>
#include <cmath>
#include <optional>

#include "sim/scene/attached_handles.h"
#include "tests/sim/moving_paths.h"
#include "tests/sim/plain_scenes.h"
#include "tests/sim/sheet_meshes.h"

namespace clothid {

// Along x in the xy plane, `cells` long, its first `held` columns held; under the load c = rho g L^3/D across it.
struct ClampedStrip {
  static constexpr double kLength = 0.1, kRigidity = 1e-4, kDensity = 0.2;  // m from the clamp, N m, kg/m^2

  ClampedStrip(SheetKind kind, int num_cells, double load, int held = 1) : columns(num_cells + held), rows(5) {
    const double spacing = kLength / num_cells;
    GridOptions grid;
    grid.nodes = {columns, rows};
    grid.size = {(columns - 1) * spacing, (rows - 1) * spacing};
    grid.origin = {(1 - held) * spacing, 0.0, 0.0};
    scene = ClothScene(grid, 0.3);
    scene.mesh = MakeSheet(kind, grid, held);
    scene.initial_positions = scene.mesh.rest_positions.reshaped();
    scene.material.density = kDensity;
    scene.material.stretch_stiffness = 1000.0;
    scene.material.bending_stiffness = kRigidity;
    scene.gravity = {0.0, 0.0, -load * kRigidity / (kDensity * std::pow(kLength, 3))};
    scene.solver.step_tolerance = 1e-10;
    for (int row = 0; row < rows; ++row) {
      for (int column = 0; column < held; ++column) scene.handles.nodes.push_back(row * columns + column);
    }
    ClampHandles({{scene.handles.nodes}}, &scene);
  }

  // The mean of the last column.
  Eigen::Vector3d Tip(const Eigen::VectorXd& positions) const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int row = 0; row < rows; ++row) sum += positions.segment<3>(3 * (row * columns + columns - 1));
    return sum / rows;
  }

  int columns, rows;
  Scene scene;
};

// `scene` with all of its handles in a jaw that turns by some .4 rad over a second.
inline Scene InATurningJaw(Scene scene) {
  const auto body = PathThrough(
      scene.start_time, scene.start_time + 1.0, 21, [](double t) { return Eigen::Vector3d(0.0, 0.02 * t, 0.0); },
      [](double t) { return Eigen::Vector3d(0.4 * t, 0.1 * t, -0.2 * t); });
  scene.handles.path = AttachedPath(scene, scene.handles.nodes, *body);
  ClampHandles({{scene.handles.nodes, std::nullopt, body}}, &scene);
  return scene;
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_SIM_CLAMPED_STRIP_H_
