// The scenes of datasets/folding and datasets/garment/cuff: a cloth that meets itself does not pass through itself.
#include <gtest/gtest.h>

#include <string>

#include "sim/contact/intersections.h"
#include "sim/rollout/rollout.h"
#include "sim/rollout/simulator.h"
#include "sim/scene/scene_json.h"

namespace clothid::folding_test {
namespace {

// Pairs of triangles that cut each other over the first steps of a scene.
int NumIntersections(const std::string& name, int num_steps) {
  const Scene scene = ReadScene(std::string(CLOTHID_SOURCE_DIR) + "/datasets/" + name + ".scene.json");
  Simulator simulator(scene);
  const Rollout rollout = Simulate(scene.nominal_parameters(), num_steps, &simulator);
  EXPECT_TRUE(rollout.ok()) << rollout.failure->ToString();
  EXPECT_GT(rollout.counts.self_contacts, 100);
  IntersectionCounter counter(scene.mesh);
  int count = 0;
  for (int step = 0; step <= rollout.num_steps(); ++step) count += counter.Count(rollout.positions(step)).count;
  return count;
}

TEST(FoldingTest, AStripSlidesOnItself) { EXPECT_EQ(NumIntersections("folding/slide", 100), 0); }

TEST(FoldingTest, AClothIsFolded) { EXPECT_EQ(NumIntersections("folding/fold", 180), 0); }

TEST(FoldingTest, ACuffIsTurnedUp) { EXPECT_EQ(NumIntersections("garment/cuff", 80), 0); }

}  // namespace
}  // namespace clothid::folding_test
