// Rollouts that follow another one.
#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

#include "sim/rollout/rollout.h"
#include "sim/rollout/simulator.h"
#include "tests/sim/shipped_scenes.h"

namespace clothid::followed_rollout_test {
namespace {

class FollowedRolloutTest : public testing::TestWithParam<Integrator> {};

// With other parameters the steps start where the solution is not, with the same ones where it is.
TEST_P(FollowedRolloutTest, KeepsSolutionsAndSubsteps) {
  Scene scene = ShippedScene("drape", 8);
  scene.integrator = GetParam();
  scene.solver.max_newton_iterations = 3;  // too few for some steps, which are then cut
  Simulator simulator(scene);
  Parameters parameters = scene.nominal_parameters();
  const Rollout first = Simulate(parameters, scene.num_steps(), &simulator);
  ASSERT_TRUE(first.ok()) << first.failure->ToString();
  ASSERT_GT(first.counts.substeps, 0);
  RolloutOptions options;
  options.followed = &first;
  const Rollout same = Simulate(parameters, scene.num_steps(), &simulator, nullptr, options);
  // One iteration beyond the tolerance for each solve, and one more where a second stage starts a little elsewhere.
  const double most = GetParam() == Integrator::kEuler ? 1.1 : 2.1;
  EXPECT_LE(same.counts.newton_iterations, most * static_cast<double>(first.records.size()));
  EXPECT_EQ(same.last_record, first.last_record);
  EXPECT_LE((same.records.back().positions - first.records.back().positions).norm(), 1e-7 * ClothSize(scene.mesh));

  parameters.material.stretch_stiffness *= 1.0 + 1e-6;
  const Rollout other = Simulate(parameters, scene.num_steps(), &simulator, nullptr, options);
  EXPECT_EQ(other.last_record, first.last_record);
  const double change = (other.records.back().positions - first.records.back().positions).norm();
  EXPECT_GT(change, 0.0);
  EXPECT_LE(change, 1e-4 * ClothSize(scene.mesh));

  options.checkpoint_interval = 9;
  EXPECT_THROW(Simulate(parameters, scene.num_steps(), &simulator, nullptr, options), std::logic_error);
}

// A step that the followed rollout cut finer than the scene allows has no solution here, and the rollout says so.
INSTANTIATE_TEST_SUITE_P(Integrators, FollowedRolloutTest, testing::Values(Integrator::kEuler, Integrator::kSdirk2),
                         [](const auto& test) { return std::string(IntegratorName(test.param)); });

TEST(FollowedTooFarTest, TooManySubstepsAreAFailure) {
  Scene scene = ShippedScene("drape", 8);
  scene.solver.max_newton_iterations = 3;
  Simulator simulator(scene);
  const Parameters parameters = scene.nominal_parameters();
  const Rollout first = Simulate(parameters, scene.num_steps(), &simulator);
  ASSERT_TRUE(first.ok()) << first.failure->ToString();
  ASSERT_GT(first.counts.substeps, 0);
  scene.solver.max_substep_halvings = 0;
  scene.solver.max_newton_iterations = 100;
  Simulator without_substeps(scene);
  RolloutOptions options;
  options.followed = &first;
  const Rollout rollout = Simulate(parameters, scene.num_steps(), &without_substeps, nullptr, options);
  ASSERT_LT(rollout.num_steps(), scene.num_steps());
  ASSERT_FALSE(rollout.ok());
  EXPECT_EQ(rollout.failure->step, rollout.num_steps() + 1);
  EXPECT_EQ(rollout.counts.failed_steps, 1);
  EXPECT_NE(rollout.failure->ToString().find("2 solves in the rollout that it follows; expected at most 1"),
            std::string::npos)
      << rollout.failure->ToString();
}

}  // namespace
}  // namespace clothid::followed_rollout_test
