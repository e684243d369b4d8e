// What a cost function does when it is called: what is asked for, once, and a reason where it fails.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <limits>

#include "costs/rollout_cost.h"
#include "tests/costs/cost_rows.h"

namespace clothid::rollout_cost_calls_test {
namespace {

TEST(RolloutCostCallsTest, AnswersWhatIsAskedFor) {
  const RecordedMotion motion = SwingMotion();
  const std::vector<ParameterBlock> blocks = MakeBlocks(motion.scene, {"k_stretch", "k_bend"});
  for (JacobianMethod method : {JacobianMethod::kAdjoint, JacobianMethod::kSensitivity, JacobianMethod::kNumeric}) {
    const RolloutCost cost(motion, blocks, WithJacobian(method));
    const CeresRows all = EvaluateAll(cost, StartOf(blocks));
    const RolloutCost fresh(motion, blocks, WithJacobian(method));
    const CeresRows second = Evaluate(fresh, StartOf(blocks), {false, true});
    ASSERT_TRUE(second.ok);
    EXPECT_TRUE(second.jacobian.col(0).array().isNaN().all());
    EXPECT_NEAR(second.gradient()[1], all.gradient()[1], 1e-10 * std::abs(all.gradient()[1]));
    // What was left out the first time is differentiated when it is asked for.
    ExpectNear(EvaluateAll(fresh, StartOf(blocks)).gradient(), all.gradient(), 1e-10);

    const Eigen::VectorXd start = StartOf(blocks);
    const double* parameters[] = {start.data(), start.data() + 1};
    Eigen::VectorXd residuals(cost.num_residuals());
    ASSERT_TRUE(cost.Evaluate(parameters, residuals.data(), nullptr));
    EXPECT_EQ(residuals, all.residuals);
    EXPECT_EQ(residuals.head(residuals.size() - 1).norm(), 0.0);
  }
}

TEST(RolloutCostCallsTest, DoesNothingTwice) {
  const RecordedMotion motion = SwingMotion();
  const std::vector<ParameterBlock> blocks = MakeBlocks(motion.scene, {"k_stretch", "k_bend"});
  const Eigen::VectorXd start = StartOf(blocks);
  const auto run = [&](JacobianMethod method) {
    const RolloutCost cost(motion, blocks, WithJacobian(method));
    const double first = CostAt(cost, start);
    EXPECT_EQ(CostAt(cost, start), first);
    EvaluateAll(cost, start);
    EvaluateAll(cost, start);
    Eigen::MatrixXd predicted;
    EXPECT_TRUE(cost.Predict(start, &predicted));
    return cost.statistics();
  };
  const CostStatistics adjoint = run(JacobianMethod::kAdjoint), sensitivity = run(JacobianMethod::kSensitivity),
                       numeric = run(JacobianMethod::kNumeric);
  EXPECT_EQ(adjoint.rollouts, 1);
  EXPECT_EQ(adjoint.sweeps, 1);
  EXPECT_EQ(sensitivity.rollouts, 1);
  EXPECT_EQ(sensitivity.sweeps, 1);
  EXPECT_EQ(numeric.rollouts, 3);
  EXPECT_EQ(numeric.sweeps, 0);
  EXPECT_EQ(adjoint.counts.steps, 20);
  EXPECT_EQ(numeric.counts.steps, 60);
}

// Neither a sweep nor a rollout for derivatives, and the cost of any other way, also of what is asked for after it.
TEST(RolloutCostCallsTest, EvaluatesACostAlone) {
  const RecordedMotion motion = SwingMotion();
  const std::vector<ParameterBlock> blocks = MakeBlocks(motion.scene, {"k_stretch", "k_bend"});
  const Eigen::VectorXd start = StartOf(blocks);
  for (JacobianMethod method : {JacobianMethod::kAdjoint, JacobianMethod::kSensitivity, JacobianMethod::kNumeric}) {
    const RolloutCost cost(motion, blocks, WithJacobian(method)), other(motion, blocks, WithJacobian(method));
    double alone = 0.0;
    ASSERT_TRUE(cost.EvaluateCost(start, &alone));
    EXPECT_EQ(cost.statistics().rollouts, 1);
    EXPECT_EQ(cost.statistics().sweeps, 0);
    EXPECT_NEAR(alone, CostAt(other, start), 1e-12 * alone);
    ExpectNear(EvaluateAll(cost, start).gradient(), EvaluateAll(other, start).gradient(), 1e-10);
    ASSERT_TRUE(cost.EvaluateCost(start, &alone));
    EXPECT_EQ(cost.statistics().rollouts, method == JacobianMethod::kNumeric ? 3 : 2)
        << "what is known is not made again";
  }
}

TEST(RolloutCostCallsTest, KeepsOnePoint) {
  const RecordedMotion motion = SwingMotion();
  const std::vector<ParameterBlock> blocks = MakeBlocks(motion.scene, {"k_stretch", "k_bend"});
  const Eigen::VectorXd start = StartOf(blocks), other = start.array() + 0.01;
  const RolloutCost cost(motion, blocks, WithJacobian(JacobianMethod::kAdjoint));
  const CeresRows rows = EvaluateAll(cost, start);
  const double other_cost = CostAt(cost, other);
  cost.KeepOnly(start);
  EXPECT_EQ(EvaluateAll(cost, start).residuals, rows.residuals);
  EXPECT_EQ(cost.statistics().rollouts, 2);
  EXPECT_EQ(CostAt(cost, other), other_cost);
  EXPECT_EQ(cost.statistics().rollouts, 3);
}

TEST(RolloutCostCallsTest, FrozenBlocksHaveNoGradient) {
  const RecordedMotion motion = SwingMotion();
  std::vector<ParameterBlock> blocks = MakeBlocks(motion.scene, {"k_stretch", "k_bend"});
  blocks[0].frozen = true;
  for (JacobianMethod method : {JacobianMethod::kAdjoint, JacobianMethod::kSensitivity}) {
    const RolloutCost cost(motion, blocks, WithJacobian(method));
    double value = 0.0;
    Eigen::VectorXd gradient;
    ASSERT_TRUE(cost.EvaluateGradient(StartOf(blocks), &value, &gradient));
    EXPECT_EQ(gradient[0], 0.0);
    EXPECT_NE(gradient[1], 0.0);
  }
}

TEST(RolloutCostCallsTest, ZeroResidualHasZeroGradient) {
  const RecordedMotion motion = MakeMotion(SwingScene(), {});
  const std::vector<ParameterBlock> blocks = MakeBlocks(motion.scene, {"k_stretch"});
  const RolloutCost cost(motion, blocks, WithJacobian(JacobianMethod::kAdjoint));
  const CeresRows rows = EvaluateAll(cost, StartOf(blocks));
  ASSERT_TRUE(rows.ok) << cost.last_failure();
  EXPECT_LT(rows.cost(), 1e-15);
  EXPECT_GT(rows.jacobian.norm(), 0.0);  // the modes still tell the curvature
}

TEST(RolloutCostCallsTest, FailuresReturnFalseWithAReason) {
  const RecordedMotion motion = SwingMotion();
  const std::vector<ParameterBlock> blocks = MakeBlocks(motion.scene, {"k_stretch"});
  std::atomic<bool> cancel{false};
  for (JacobianMethod method : {JacobianMethod::kAdjoint, JacobianMethod::kSensitivity, JacobianMethod::kNumeric}) {
    cancel = false;
    RolloutCostOptions options = WithJacobian(method);
    options.cancel = &cancel;
    const RolloutCost cost(motion, blocks, options);
    for (double bad : {std::numeric_limits<double>::quiet_NaN(), 1e4}) {  // exp(1e4) overflows
      EXPECT_FALSE(EvaluateAll(cost, Eigen::VectorXd::Constant(1, bad)).ok);
      EXPECT_NE(cost.last_failure().find("synthetic: "), std::string::npos) << cost.last_failure();
    }
    EXPECT_TRUE(EvaluateAll(cost, StartOf(blocks)).ok);
    EXPECT_TRUE(cost.last_failure().empty()) << cost.last_failure();
    cancel = true;
    EXPECT_FALSE(EvaluateAll(cost, StartOf(blocks).array() + 0.1).ok);
    EXPECT_FALSE(cost.last_failure().empty());
    Eigen::MatrixXd predicted;
    EXPECT_FALSE(cost.Predict(StartOf(blocks).array() + 0.1, &predicted));
    EXPECT_TRUE(EvaluateAll(cost, StartOf(blocks)).ok) << "cached before";
  }
}

// Somebody stopped it, so nothing is known of the point.
TEST(RolloutCostCallsTest, WhatWasCancelledIsEvaluatedWhenItIsAskedForAgain) {
  const RecordedMotion motion = SwingMotion();
  const std::vector<ParameterBlock> blocks = MakeBlocks(motion.scene, {"k_stretch", "k_bend"});
  const Eigen::VectorXd start = StartOf(blocks);
  for (JacobianMethod method : {JacobianMethod::kAdjoint, JacobianMethod::kSensitivity, JacobianMethod::kNumeric}) {
    std::atomic<bool> cancel{false};
    RolloutCostOptions options = WithJacobian(method);
    const CeresRows expected = EvaluateAll(RolloutCost(motion, blocks, options), start);
    options.cancel = &cancel;
    const RolloutCost cost(motion, blocks, options);
    cancel = true;
    EXPECT_FALSE(EvaluateAll(cost, start).ok);
    EXPECT_FALSE(cost.last_failure().empty());
    cancel = false;
    const CeresRows rows = EvaluateAll(cost, start);
    ASSERT_TRUE(rows.ok) << cost.last_failure();
    EXPECT_TRUE(cost.last_failure().empty());
    EXPECT_EQ(rows.residuals, expected.residuals);
    ExpectNear(rows.gradient(), expected.gradient(), 1e-12);

    // What was known before stays known: the cost, where exact rows were cancelled.
    const Eigen::VectorXd near = start.array() + 1e-3;
    const double value = CostAt(cost, near);
    const int rollouts = cost.statistics().rollouts;
    cancel = true;
    Eigen::MatrixXd jacobian;
    Eigen::VectorXd residuals;
    EXPECT_EQ(cost.Linearize(near, {}, &jacobian, &residuals), method == JacobianMethod::kSensitivity);
    const int cancelled = cost.statistics().rollouts - rollouts;
    EXPECT_EQ(CostAt(cost, near), value);
    cancel = false;
    EXPECT_EQ(CostAt(cost, near), value);
    EXPECT_EQ(cost.statistics().rollouts, rollouts + cancelled);
    EXPECT_TRUE(cost.Linearize(near, {}, &jacobian, &residuals)) << cost.last_failure();
  }
}

TEST(RolloutCostCallsTest, AStepThatDoesNotConvergeIsNamed) {
  RecordedMotion motion = SwingMotion();
  motion.scene.solver.step_tolerance = 1e-15;  // below rounding
  motion.scene.solver.max_newton_iterations = 1;
  motion.scene.solver.max_substep_halvings = 0;
  const std::vector<ParameterBlock> blocks = MakeBlocks(motion.scene, {"k_stretch"});
  const RolloutCost cost(motion, blocks, {});
  ASSERT_FALSE(EvaluateAll(cost, StartOf(blocks)).ok);
  EXPECT_NE(cost.last_failure().find("step "), std::string::npos) << cost.last_failure();
}

}  // namespace
}  // namespace clothid::rollout_cost_calls_test
