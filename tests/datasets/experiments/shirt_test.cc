// The shirt of datasets/garment is sewn onto its body and stays on it while it moves.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <string>

#include "sim/rollout/rollout.h"
#include "sim/rollout/simulator.h"
#include "sim/scene/scene_json.h"

namespace clothid::shirt_test {
namespace {

TEST(ShirtTest, IsSewnAndWorn) {
  constexpr int kNumSteps = 90;  // the body moves from step 48 on
  const Scene scene = ReadScene(std::string(CLOTHID_SOURCE_DIR) + "/datasets/garment/shirt.scene.json");
  Simulator simulator(scene);
  const Rollout rollout = Simulate(scene.nominal_parameters(), kNumSteps, &simulator);
  ASSERT_TRUE(rollout.ok()) << rollout.failure->ToString();
  const Eigen::VectorXd& end = rollout.positions(kNumSteps);
  const auto place = [&](int node) { return Eigen::Vector3d(end.segment<3>(3 * node)); };

  double widest = 0.0;
  for (const SeamLink& link : scene.mesh.links) {
    const Eigen::Vector3d target = (1.0 - link.share) * place(link.edge[0]) + link.share * place(link.edge[1]);
    widest = std::max(widest, (place(link.node) - target).norm());
  }
  EXPECT_GE(scene.mesh.links.size(), 40u);
  EXPECT_LE(widest, 0.002);

  const SurfacesAt surfaces(scene, kNumSteps * scene.time_step);
  double highest = -1.0, deepest = 0.0;
  for (int node = 0; node < scene.mesh.num_nodes(); ++node) {
    highest = std::max(highest, place(node).z());
    deepest = std::min(deepest, surfaces.Nearest(place(node)).gap);
  }
  EXPECT_GE(highest, -0.06);  // the shoulders reach up to -0.055
  EXPECT_GE(deepest, -0.005);
}

}  // namespace
}  // namespace clothid::shirt_test
