// Observers of passes hear of every step, whatever the passes are made of, and change nothing.
#include "costs/prediction/pass_step.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "costs/rollout_cost.h"
#include "tests/costs/synthetic_motion.h"

namespace clothid::pass_step_test {
namespace {

std::vector<ParameterBlock> BlocksOf(const RecordedMotion& motion, const std::vector<std::string>& names) {
  std::vector<ParameterBlock> blocks;
  for (const std::string& name : names) blocks.push_back(MakeParameterBlock(name, motion, {}));
  return blocks;
}

struct Observed {
  double cost = 0.0;
  Eigen::VectorXd gradient;
  std::vector<PassStep> steps;
};

Observed Evaluate(const RecordedMotion& motion, const std::vector<std::string>& names, RolloutCostOptions options,
                  bool is_observed) {
  Observed observed;
  if (is_observed) options.on_step = [&observed](const PassStep& step) { observed.steps.push_back(step); };
  const std::vector<ParameterBlock> blocks = BlocksOf(motion, names);
  const RolloutCost cost(motion, blocks, options);
  EXPECT_TRUE(cost.EvaluateGradient(StartOf(blocks), &observed.cost, &observed.gradient)) << cost.last_failure();
  return observed;
}

// Expects the steps to be those of `passes`, each from its first to its last.
void ExpectPasses(const std::vector<PassStep>& steps, int num_steps, const std::vector<RolloutPass>& passes) {
  ASSERT_EQ(steps.size(), passes.size() * num_steps);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const std::size_t pass = i / num_steps;
    EXPECT_EQ(steps[i].pass, passes[pass]) << i;
    EXPECT_EQ(steps[i].num_done, static_cast<int>(i % num_steps) + 1) << i;
    EXPECT_EQ(steps[i].num_steps, num_steps) << i;
    EXPECT_EQ(steps[i].passes_left, static_cast<int>(passes.size() - 1 - pass)) << i;
  }
}

void ExpectObserved(const RecordedMotion& motion, const std::vector<std::string>& names,
                    const RolloutCostOptions& options, int num_steps, const std::vector<RolloutPass>& passes) {
  const Observed alone = Evaluate(motion, names, options, /*is_observed=*/false);
  const Observed observed = Evaluate(motion, names, options, /*is_observed=*/true);
  EXPECT_EQ(observed.cost, alone.cost);
  EXPECT_EQ(observed.gradient, alone.gradient);
  ExpectPasses(observed.steps, num_steps, passes);
}

RecordedMotion SphereMotion() {
  MotionOptions options;
  options.true_values = {{"mu", 0.35}, {"k_stretch", 90.0}};
  return MakeMotion(SphereScene(), options);
}

TEST(PassStepTest, AdjointIsARolloutAndAReverseSweep) {
  ExpectObserved(SphereMotion(), {"mu", "k_stretch"}, {}, 20, {RolloutPass::kRollout, RolloutPass::kReverseSweep});
}

// The steps that the reverse sweep makes again are part of it.
TEST(PassStepTest, CheckpointsMakeNoOtherPasses) {
  RolloutCostOptions options;
  options.memory_limit = 1;
  ExpectObserved(SphereMotion(), {"mu", "k_stretch"}, options, 20, {RolloutPass::kRollout, RolloutPass::kReverseSweep});
}

TEST(PassStepTest, SensitivitiesComeWithTheRollout) {
  RolloutCostOptions options;
  options.jacobian = JacobianMethod::kSensitivity;
  ExpectObserved(SphereMotion(), {"mu", "k_stretch"}, options, 20, {RolloutPass::kForwardSweep});
}

TEST(PassStepTest, ForwardDifferencesAreARolloutPerParameter) {
  RolloutCostOptions options;
  options.jacobian = JacobianMethod::kNumeric;
  ExpectObserved(SphereMotion(), {"mu", "k_stretch"}, options, 20, std::vector<RolloutPass>(3, RolloutPass::kRollout));
}

TEST(PassStepTest, ParametersOfARecordingHaveTheSamePasses) {
  RolloutCostOptions options;
  ExpectObserved(SphereMotion(), {"k_stretch", "shift.x"}, options, 20,
                 {RolloutPass::kRollout, RolloutPass::kReverseSweep});
  options.jacobian = JacobianMethod::kSensitivity;
  ExpectObserved(SphereMotion(), {"k_stretch", "shift.x"}, options, 20, {RolloutPass::kForwardSweep});
}

// One point, whose second question needs the reverse sweep alone.
TEST(PassStepTest, WhatIsKnownTakesNoPass) {
  const RecordedMotion motion = SphereMotion();
  const std::vector<ParameterBlock> blocks = BlocksOf(motion, {"mu", "k_stretch"});
  std::vector<PassStep> steps;
  RolloutCostOptions options;
  options.on_step = [&steps](const PassStep& step) { steps.push_back(step); };
  const RolloutCost cost(motion, blocks, options);
  double value = 0.0;
  Eigen::VectorXd gradient;
  ASSERT_TRUE(cost.EvaluateGradient(StartOf(blocks), &value, nullptr));
  ExpectPasses(steps, 20, {RolloutPass::kRollout});
  steps.clear();
  ASSERT_TRUE(cost.EvaluateGradient(StartOf(blocks), &value, &gradient));
  ExpectPasses(steps, 20, {RolloutPass::kReverseSweep});
  steps.clear();
  ASSERT_TRUE(cost.EvaluateGradient(StartOf(blocks), &value, &gradient));
  EXPECT_TRUE(steps.empty());
}

}  // namespace
}  // namespace clothid::pass_step_test
