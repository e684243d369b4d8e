// A cloth that lies on itself, against closed forms.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "sim/cloth/cloth_model.h"
#include "sim/step/step_problem.h"
#include "sim/step/step_solver.h"
#include "tests/sim/plain_scenes.h"
#include "tests/sim/self_contact_scenes.h"

namespace clothid::self_contact_test {
namespace {

constexpr double kDegree = kPi / 180.0;

// The mean over the nodes from `first` on, m or m/s.
Eigen::Vector3d Mean(const Eigen::VectorXd& values, int first) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  const int num_nodes = static_cast<int>(values.size()) / 3;
  for (int node = first; node < num_nodes; ++node) sum += values.segment<3>(3 * node);
  return sum / (num_nodes - first);
}

class StripOnStripTest : public testing::TestWithParam<Integrator> {};

TEST_P(StripOnStripTest, SlidesWithTheAccelerationOfABlock) {
  const double angle = 25.0 * kDegree, friction = 0.3, h = 0.005;
  const Scene scene = LayersOnASlope(2, angle, friction, GetParam(), h);
  const int num_steps = 60;
  const Rollout rollout = SimulateNominal(scene, num_steps);
  ASSERT_EQ(rollout.num_steps(), num_steps);
  const int first = static_cast<int>(scene.handles.nodes.size());
  const double acceleration = 9.81 * (std::sin(angle) - friction * std::cos(angle)), time = num_steps * h;
  EXPECT_NEAR(Mean(rollout.records.back().velocities, first).x(), acceleration * time, 1e-6);
  // Backward Euler is ahead by half a step.
  const double late = GetParam() == Integrator::kEuler ? 0.5 * acceleration * h * time : 0.0;
  const double way = (Mean(rollout.positions(num_steps), first) - Mean(rollout.initial_positions, first)).x();
  EXPECT_NEAR(way, 0.5 * acceleration * time * time + late, 1e-6);
  EXPECT_EQ(rollout.counts.substeps, 0);
}

TEST_P(StripOnStripTest, HoldsBelowTheThreshold) {
  const double angle = 25.0 * kDegree;
  const Scene scene = LayersOnASlope(2, angle, 1.01 * std::tan(angle), GetParam(), 0.01);
  const Rollout rollout = SimulateNominal(scene, 1000);
  ASSERT_EQ(rollout.num_steps(), 1000);
  const double creep = (rollout.positions(1000) - rollout.positions(500)).lpNorm<Eigen::Infinity>() / 5.0;
  EXPECT_LT(creep, 1e-9);
  EXPECT_LT((rollout.positions(1000) - rollout.positions(100)).lpNorm<Eigen::Infinity>(), 1e-8);
}

TEST_P(StripOnStripTest, ThreeLayersHoldAndSlide) {
  const double angle = 25.0 * kDegree;
  const Rollout at_rest = SimulateNominal(LayersOnASlope(3, angle, 1.05 * std::tan(angle), GetParam(), 0.01), 200);
  ASSERT_EQ(at_rest.num_steps(), 200);
  EXPECT_LT((at_rest.positions(200) - at_rest.positions(100)).lpNorm<Eigen::Infinity>(), 1e-9);
  // All friction alike: the two slide together.
  const Scene scene = LayersOnASlope(3, angle, 0.3, GetParam(), 0.005);
  const Rollout rollout = SimulateNominal(scene, 40);
  ASSERT_EQ(rollout.num_steps(), 40);
  const double acceleration = 9.81 * (std::sin(angle) - 0.3 * std::cos(angle));
  const int first = static_cast<int>(scene.handles.nodes.size());
  EXPECT_NEAR(Mean(rollout.records.back().velocities, first).x(), 0.2 * acceleration, 1e-4);
}

INSTANTIATE_TEST_SUITE_P(Integrators, StripOnStripTest, testing::Values(Integrator::kEuler, Integrator::kSdirk2),
                         [](const auto& test) { return IntegratorName(test.param); });

// Two free sheets that collide keep their momentum.
TEST(SelfContactTest, KeepsMomentum) {
  Scene scene = CollidingSheets(Integrator::kSdirk2);
  const Eigen::VectorXd masses = 0.15 * NodeAreas(scene.mesh);
  const auto momentum = [&](const Eigen::VectorXd& velocities) -> Eigen::Vector3d {
    return velocities.reshaped(3, masses.size()) * masses;
  };
  for (const Integrator integrator : {Integrator::kEuler, Integrator::kSdirk2}) {
    scene.integrator = integrator;
    const Rollout rollout = SimulateNominal(scene, 20);
    ASSERT_EQ(rollout.num_steps(), 20);
    const Eigen::Vector3d before = momentum(scene.initial_velocities);
    const Eigen::Vector3d after = momentum(rollout.records.back().velocities);
    EXPECT_NEAR((after - before).norm(), 0.0, 1e-10 * before.norm());
    // It did meet: the upper sheet alone has lost some.
    EXPECT_GT((rollout.records.back().velocities - scene.initial_velocities).lpNorm<Eigen::Infinity>(), 0.05);
  }
}

// With a guess a solve goes an iteration beyond its tolerance, and ends with a factor where it is to, pairs or not.
TEST(SelfContactTest, ASolveWithPairsKeepsTheContractOfOneWithout) {
  const Scene scene = CollidingSheets(Integrator::kEuler);
  const Rollout rollout = SimulateNominal(scene, 20);
  std::size_t i = 1;
  while (i < rollout.records.size() && rollout.records[i].contacts.pairs.empty()) ++i;
  ASSERT_LT(i, rollout.records.size());
  const StepRecord &record = rollout.records[i], &before = rollout.records[i - 1];
  Simulator simulator(scene);
  StepSolver& solver = simulator.step_solver();
  const StepProblem problem(simulator.model(), rollout.parameters, {before.positions, before.velocities},
                            record.times(), &simulator.step_workspace());
  ASSERT_TRUE(problem.contacts().may_touch_itself());
  const Eigen::VectorXd guess = simulator.model().Gather(record.velocities);
  const auto residual = [&](const Eigen::VectorXd* from, bool end_with_factors) {
    StepPoint point;
    RolloutCounts counts;
    solver.Reset(end_with_factors);
    EXPECT_TRUE(solver.Solve(problem, 1e-4, from, &point, &counts));
    return point.relative_residual;
  };
  const double without = residual(nullptr, false);
  EXPECT_LE(residual(&guess, true), std::max(1e-3 * without, 1e-9));
  ASSERT_NE(solver.end_factor(), nullptr);
  EXPECT_NE(solver.end_factor()->cholesky, nullptr);
}

}  // namespace
}  // namespace clothid::self_contact_test
