// Nodes that an obstacle takes along.
#include "sim/scene/attached_handles.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>

#include "tests/sim/moving_paths.h"
#include "tests/sim/plain_scenes.h"

namespace clothid {
namespace {

TEST(AttachedHandlesTest, MoveWithTheBodyExactlyAtTheEndsOfSteps) {
  Scene scene = ClothScene(SquareGrid(5, 0.3), 0.01);
  scene.integrator = Integrator::kSdirk2;
  scene.start_time = 0.1;
  scene.duration = 0.4;
  scene.handles.nodes = {0, 4};
  const auto body = PathThrough(
      0.0, 1.0, 51, [](double t) { return Eigen::Vector3d(0.1 * std::sin(4.0 * t), 0.2 * t, 0.05 * t * t); },
      [](double t) { return Eigen::Vector3d(0.5 * t, std::sin(3.0 * t), 0.2); });
  scene.handles.path = AttachedPath(scene, scene.handles.nodes, *body);
  const Rollout rollout = SimulateNominal(scene, scene.num_steps());
  const AffineMap start = body->At(scene.start_time).pose;
  for (int step = 0; step <= scene.num_steps(); ++step) {
    const AffineMap pose = body->At(scene.start_time + step * scene.time_step).pose;
    for (const int node : scene.handles.nodes) {
      const Eigen::Vector3d first = rollout.positions(0).segment<3>(3 * node);
      const Eigen::Vector3d carried = Apply(pose, start.leftCols<3>().transpose() * (first - start.col(3)));
      EXPECT_LE((rollout.positions(step).segment<3>(3 * node) - carried).norm(), 1e-12) << step;
    }
  }
}

}  // namespace
}  // namespace clothid
