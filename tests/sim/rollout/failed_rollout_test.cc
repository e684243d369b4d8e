// A failed rollout is never a number: random scenes that the solver is not given enough iterations for.
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "sim/derivative/sensitivity.h"
#include "sim/rollout/simulator.h"
#include "tests/sim/property_seeds.h"
#include "tests/sim/random_scene.h"
#include "tests/sim/step/step_residual.h"

namespace clothid::failed_rollout_test {
namespace {

// What a failure says, and that nothing comes after it.
void ExpectFailureIsTold(const Rollout& rollout) {
  const StepFailure& failure = *rollout.failure;
  EXPECT_EQ(failure.step, rollout.num_steps() + 1);
  EXPECT_EQ(rollout.counts.failed_steps, 1);
  EXPECT_GT(failure.residual, failure.tolerance);
  EXPECT_FALSE(failure.reason.empty());
  const std::string text = failure.ToString();
  EXPECT_NE(text.find("step " + std::to_string(failure.step) + " " + failure.reason), std::string::npos) << text;
  EXPECT_NE(text.find("residual "), std::string::npos) << text;
}

TEST(FailedRolloutTest, EveryStepMeetsItsToleranceOrIsTheEnd) {
  const std::vector<std::uint64_t> seeds = PropertySeeds(60);
  int failed = 0, succeeded = 0;
  for (const std::uint64_t seed : seeds) {
    RandomScene random = MakeRandomScene(seed);
    SCOPED_TRACE(random.description);
    random.scene.solver.max_newton_iterations = static_cast<int>(1 + seed % 4);
    random.scene.solver.max_substep_halvings = static_cast<int>(seed % 2);
    random.scene.material.stretch_stiffness *= 100.0;
    Simulator simulator(random.scene);
    const Parameters parameters = random.scene.nominal_parameters();
    const int num_steps = random.scene.num_steps();
    const Rollout rollout = Simulate(parameters, num_steps, &simulator);
    ++(rollout.ok() ? succeeded : failed);
    if (rollout.ok()) {
      EXPECT_EQ(rollout.num_steps(), num_steps);
    } else {
      ExpectFailureIsTold(rollout);
    }
    for (std::size_t i = 0; i < rollout.records.size(); ++i) {
      const StepResidual residual = ResidualOf(rollout, i, &simulator);
      EXPECT_LE(residual.relative, residual.tolerance) << "solve " << i;
    }
    int last_seen = -1;
    const auto visitor = [&](int step, const Eigen::VectorXd&, const Eigen::MatrixXd&) { last_seen = step; };
    const SensitivityResult forward =
        PushForward(parameters, num_steps, {{{ParameterKind::kStretchStiffness}}, {}, {}, {}}, visitor, &simulator);
    EXPECT_EQ(forward.failure.has_value(), !rollout.ok());
    EXPECT_EQ(last_seen, rollout.num_steps());
  }
  EXPECT_GE(failed, 0.25 * static_cast<double>(seeds.size()));
  EXPECT_GE(succeeded, 0.1 * static_cast<double>(seeds.size()));
}

}  // namespace
}  // namespace clothid::failed_rollout_test
