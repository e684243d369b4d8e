// Where contacts go from one obstacle to another, the motion is not a continuous function of its parameters.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "sim/rollout/rollout.h"
#include "sim/rollout/simulator.h"
#include "tests/sim/shipped_scenes.h"

namespace clothid::obstacle_switches_test {
namespace {

constexpr int kScanPoints = 65;

// One of kScanPoints rollouts along a line of parameters.
struct ScanPoint {
  Eigen::VectorXd positions;   // at the end [3N] m
  std::vector<int> obstacles;  // of every contact in every step
};

enum class Line { kStart, kFriction };

// `pair`: a cloth slides down one plane and up another, whose friction is higher. kStart: up to 0.64 mm further along
// its way at the start; kFriction: up to 0.002 more friction of the first plane.
std::vector<ScanPoint> Scan(Line line, bool with_second_plane) {
  std::vector<ScanPoint> points;
  for (int i = 0; i < kScanPoints; ++i) {
    const double fraction = i / (kScanPoints - 1.0);
    Scene scene = ShippedScene("pair", 10);
    if (!with_second_plane) scene.obstacles.pop_back();
    Parameters parameters = scene.nominal_parameters();
    if (line == Line::kStart) scene.initial_positions += 0.64e-3 * fraction * scene.initial_velocities;
    if (line == Line::kFriction) parameters.friction_coefficients[0] += 0.002 * fraction;
    Simulator simulator(scene);
    const Rollout rollout = Simulate(parameters, scene.num_steps(), &simulator);
    EXPECT_TRUE(rollout.ok());
    ScanPoint point{rollout.positions(rollout.num_steps()), {}};
    for (const StepRecord& record : rollout.records) {
      for (const ContactRecord& contact : record.contacts.nodes) point.obstacles.push_back(contact.obstacle);
    }
    points.push_back(point);
  }
  return points;
}

// The farthest that a node moves from one point to the next but `stride` - 1, m. `only_same_obstacles`: of those pairs
// in which every contact is with the same obstacle.
double LargestJump(const std::vector<ScanPoint>& points, int stride, bool only_same_obstacles = false) {
  double largest = 0.0;
  for (int i = 0; i + stride < kScanPoints; i += stride) {
    const ScanPoint &a = points[i], &b = points[i + stride];
    if (only_same_obstacles && a.obstacles != b.obstacles) continue;
    const Eigen::VectorXd move = b.positions - a.positions;
    for (Eigen::Index k = 0; k < move.size(); k += 3) largest = std::max(largest, move.segment<3>(k).norm());
  }
  return largest;
}

TEST(ObstacleSwitchesTest, AreCountedAndNothingElseHappensToTheContacts) {
  const Scene scene = ShippedScene("pair", 10);
  Simulator simulator(scene);
  const Rollout rollout = Simulate(scene.nominal_parameters(), scene.num_steps(), &simulator);
  ASSERT_TRUE(rollout.ok());
  EXPECT_GT(rollout.counts.obstacle_switches, 50);
  EXPECT_EQ(rollout.counts.nodes_joined, 0);
  EXPECT_EQ(rollout.counts.nodes_left, 0);
  EXPECT_EQ(rollout.counts.failed_steps, 0);
  EXPECT_EQ(rollout.counts.substeps, 0);
}

class ObstacleSwitchesAlongALineTest : public testing::TestWithParam<Line> {};

TEST_P(ObstacleSwitchesAlongALineTest, MakeTheMotionJump) {
  const std::vector<ScanPoint> two = Scan(GetParam(), true), one = Scan(GetParam(), false);
  EXPECT_GT(LargestJump(two, 1), 0.85 * LargestJump(two, 2)) << "a jump is as large for steps half as long";
  EXPECT_GT(LargestJump(two, 1), 1e-4);
  EXPECT_LT(LargestJump(two, 1), 1e-3) << "a node takes the other friction one step earlier or later";
  const double smooth = LargestJump(two, 1, /*only_same_obstacles=*/true);
  EXPECT_GT(smooth, 0.0);
  EXPECT_LT(smooth, 0.2 * LargestJump(two, 1)) << "without a switch there is no jump";
  EXPECT_LT(LargestJump(one, 1), 0.6 * LargestJump(one, 2)) << "on one plane nothing jumps";
}

INSTANTIATE_TEST_SUITE_P(Lines, ObstacleSwitchesAlongALineTest, testing::Values(Line::kStart, Line::kFriction),
                         [](const auto& test) { return test.param == Line::kStart ? "Start" : "Friction"; });

}  // namespace
}  // namespace clothid::obstacle_switches_test
