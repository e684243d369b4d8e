// Rows, gradients and caches of the cost function, in each of its forms.
#include "costs/rollout_cost.h"

#include <ceres/gradient_checker.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <tuple>

#include "costs/full_residual_cost.h"
#include "tests/costs/cost_rows.h"
#include "tests/costs/synthetic_motion.h"

namespace clothid::rollout_cost_test {
namespace {

Eigen::VectorXd CentralDifferences(const ceres::CostFunction& cost, const Eigen::VectorXd& coordinates) {
  const double step = 1e-5;
  Eigen::VectorXd gradient(coordinates.size());
  for (Eigen::Index i = 0; i < coordinates.size(); ++i) {
    Eigen::VectorXd above = coordinates, below = coordinates;
    above[i] += step;
    below[i] -= step;
    gradient[i] = (CostAt(cost, above) - CostAt(cost, below)) / (2.0 * step);
  }
  return gradient;
}

const std::vector<std::string> kSwingNames = {"k_stretch", "k_bend", "density", "drag"};
const std::vector<std::string> kSphereNames = {"mu", "k_stretch", "k_bend"};

RecordedMotion SphereMotion() {
  MotionOptions options;
  options.true_values = {{"mu", 0.35}, {"k_stretch", 90.0}};
  options.sigma = 1e-3;
  return MakeMotion(SphereScene(), options);
}

struct Case {
  const char* name;
  RecordedMotion (*motion)();
  const std::vector<std::string>* parameters;
};

class RolloutCostTest : public testing::TestWithParam<Case> {
 protected:
  RolloutCostTest() : motion_(GetParam().motion()), blocks_(MakeBlocks(motion_.scene, *GetParam().parameters)) {}

  RecordedMotion motion_;
  std::vector<ParameterBlock> blocks_;
};

INSTANTIATE_TEST_SUITE_P(Scenes, RolloutCostTest,
                         testing::Values(Case{"Swing", &SwingMotion, &kSwingNames},
                                         Case{"Sphere", &SphereMotion, &kSphereNames}),
                         [](const auto& test) { return test.param.name; });

TEST_P(RolloutCostTest, GradientsAgreeWithCentralDifferences) {
  for (const char* loss : {"none", "huber:2", "cauchy:2"}) {
    for (JacobianMethod method : {JacobianMethod::kAdjoint, JacobianMethod::kSensitivity}) {
      RolloutCostOptions options = WithJacobian(method);
      options.loss = ParseRobustLoss(loss);
      const RolloutCost cost(motion_, blocks_, options);
      const Eigen::VectorXd start = StartOf(blocks_);
      const CeresRows rows = EvaluateAll(cost, start);
      ASSERT_TRUE(rows.ok) << cost.last_failure();
      ExpectNear(rows.gradient(), CentralDifferences(cost, start), 2e-6);
      EXPECT_NEAR(rows.cost(), CostAt(cost, start), 1e-12 * rows.cost());
    }
  }
}

TEST_P(RolloutCostTest, AdjointAgreesWithSensitivities) {
  for (const char* loss : {"none", "huber:2", "cauchy:2"}) {
    RolloutCostOptions options = WithJacobian(JacobianMethod::kAdjoint);
    options.loss = ParseRobustLoss(loss);
    const RolloutCost adjoint(motion_, blocks_, options);
    options.jacobian = JacobianMethod::kSensitivity;
    const RolloutCost sensitivity(motion_, blocks_, options);
    const CeresRows a = EvaluateAll(adjoint, StartOf(blocks_)), s = EvaluateAll(sensitivity, StartOf(blocks_));
    ASSERT_TRUE(a.ok && s.ok);
    EXPECT_NEAR(a.cost(), s.cost(), 1e-12 * s.cost());
    ExpectNear(a.gradient(), s.gradient(), 1e-8);
    // The subspace holds no more of the Gauss-Newton matrix than there is.
    const Eigen::MatrixXd rest = s.jacobian.transpose() * s.jacobian - a.jacobian.transpose() * a.jacobian;
    EXPECT_GT(rest.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff(), -1e-9 * s.jacobian.squaredNorm());

    double cost = 0.0;
    Eigen::VectorXd gradient;
    for (const RolloutCost* either : {&adjoint, &sensitivity}) {
      ASSERT_TRUE(either->EvaluateGradient(StartOf(blocks_), &cost, &gradient));
      EXPECT_NEAR(cost, s.cost(), 1e-12 * s.cost());
      ExpectNear(gradient, s.gradient(), 1e-8);
    }
  }
}

// The solver of steps is reset at checkpoints, so they agree to their tolerance.
TEST_P(RolloutCostTest, AMemoryLimitChangesNothing) {
  for (JacobianMethod method : {JacobianMethod::kAdjoint, JacobianMethod::kNumeric}) {
    RolloutCostOptions options = WithJacobian(method);
    const CeresRows free = EvaluateAll(RolloutCost(motion_, blocks_, options), StartOf(blocks_));
    options.memory_limit = 0;
    const RolloutCost cost(motion_, blocks_, options);
    const CeresRows limited = EvaluateAll(cost, StartOf(blocks_));
    ASSERT_TRUE(free.ok && limited.ok) << cost.last_failure();
    EXPECT_NEAR(limited.cost(), free.cost(), 1e-8 * free.cost());
    ExpectNear(limited.gradient(), free.gradient(), 1e-6);
    Eigen::MatrixXd predicted;
    ASSERT_TRUE(cost.Predict(StartOf(blocks_), &predicted));
    EXPECT_TRUE(predicted.allFinite());
    EXPECT_EQ(cost.statistics().rollouts,
              method == JacobianMethod::kAdjoint ? 1 : 1 + static_cast<int>(blocks_.size()));
  }
}

TEST_P(RolloutCostTest, GaussNewtonMatrixOfSensitivitiesIsThatOfTheFullJacobian) {
  const FullResidualCost full(motion_, blocks_);
  const CeresRows large = EvaluateAll(full, StartOf(blocks_));
  const CeresRows small =
      EvaluateAll(RolloutCost(motion_, blocks_, WithJacobian(JacobianMethod::kSensitivity)), StartOf(blocks_));
  ASSERT_TRUE(large.ok && small.ok);
  EXPECT_EQ(large.residuals.size(), Observation(motion_).num_residuals());
  EXPECT_EQ(small.residuals.size(), static_cast<Eigen::Index>(blocks_.size()) + 1);
  EXPECT_NEAR(small.cost(), large.cost(), 1e-12 * large.cost());
  ExpectNear(small.gradient(), large.gradient(), 1e-9);
  const Eigen::MatrixXd hessian = large.jacobian.transpose() * large.jacobian;
  EXPECT_LT((small.jacobian.transpose() * small.jacobian - hessian).norm(), 1e-11 * hessian.norm());

  const CeresRows numeric =
      EvaluateAll(RolloutCost(motion_, blocks_, WithJacobian(JacobianMethod::kNumeric)), StartOf(blocks_));
  EXPECT_LT((numeric.jacobian.transpose() * numeric.jacobian - hessian).norm(), 1e-3 * hessian.norm());
  EXPECT_LT((numeric.gradient() - large.gradient()).norm(), 1e-3 * large.gradient().norm());
}

// Ceres compares costs of points with Jacobians to those without.
TEST_P(RolloutCostTest, RowsAreOneFunctionOfTheParameters) {
  const Eigen::VectorXd start = StartOf(blocks_);
  const std::vector<bool> none(static_cast<std::size_t>(start.size()), false);
  for (const char* loss : {"none", "huber:2", "cauchy:2"}) {
    for (JacobianMethod method : {JacobianMethod::kAdjoint, JacobianMethod::kSensitivity, JacobianMethod::kNumeric}) {
      RolloutCostOptions options = WithJacobian(method);
      options.loss = ParseRobustLoss(loss);
      for (const bool starts_with_sensitivities : {false, true}) {
        options.starts_with_sensitivities = starts_with_sensitivities;
        const RolloutCost cost(motion_, blocks_, options), other(motion_, blocks_, options);
        const Eigen::VectorXd alone = Evaluate(cost, start, none).residuals;
        const CostStatistics at_trial_point = cost.statistics();
        const CeresRows with = EvaluateAll(cost, start);
        ASSERT_TRUE(with.ok) << cost.last_failure();
        EXPECT_EQ(with.residuals, alone);
        EXPECT_EQ(EvaluateAll(other, start).residuals, alone);
        EXPECT_EQ(Evaluate(other, start, none).residuals, alone);
        EXPECT_EQ(at_trial_point.rollouts, 1);
        EXPECT_EQ(at_trial_point.sweeps, method == JacobianMethod::kSensitivity ? 1 : 0);

        double value = 0.0;
        Eigen::VectorXd gradient;
        ASSERT_TRUE(cost.EvaluateGradient(start, &value, &gradient));
        EXPECT_NEAR(with.cost(), value, 1e-14 * value);
        ExpectNear(with.gradient(), gradient, 1e-8);
      }
    }
  }
}

TEST_P(RolloutCostTest, TheMatrixOfRobustRowsIsThatOfTheWeightedJacobian) {
  const CeresRows full = EvaluateAll(FullResidualCost(motion_, blocks_), StartOf(blocks_));
  for (const char* loss : {"none", "huber:2", "cauchy:2"}) {
    RolloutCostOptions options = WithJacobian(JacobianMethod::kSensitivity);
    options.loss = ParseRobustLoss(loss);
    const CeresRows rows = EvaluateAll(RolloutCost(motion_, blocks_, options), StartOf(blocks_));
    ASSERT_TRUE(full.ok && rows.ok);
    Eigen::VectorXd weights;
    const double cost = LossWeights(options.loss, Observation(motion_), 0, full.residuals, &weights);
    const Eigen::MatrixXd weighted = weights.asDiagonal() * full.jacobian;
    const Eigen::MatrixXd hessian = weighted.transpose() * weighted;
    EXPECT_LT((rows.jacobian.transpose() * rows.jacobian - hessian).norm(), 1e-11 * hessian.norm()) << loss;
    EXPECT_NEAR(rows.cost(), cost, 1e-12 * cost) << loss;
    // The last row alone is a derivative: that of sqrt(2 L).
    const Eigen::VectorXd gradient = weighted.transpose() * weights.cwiseProduct(full.residuals);
    ExpectNear(rows.jacobian.bottomRows(1).transpose() * std::sqrt(2.0 * cost), gradient, 1e-9);
  }
}

TEST_P(RolloutCostTest, DifferencesOfRolloutsWidenTheSubspace) {
  const RolloutCost cost(motion_, blocks_, WithJacobian(JacobianMethod::kAdjoint));
  const RolloutCost other(motion_, blocks_, WithJacobian(JacobianMethod::kAdjoint));
  const FullResidualCost full(motion_, blocks_);
  const Eigen::VectorXd start = StartOf(blocks_);
  const Eigen::MatrixXd large = EvaluateAll(full, start).jacobian;
  for (Eigen::Index i = 0; i < start.size(); ++i) {
    Eigen::VectorXd near = start;
    near[i] += 1e-4;
    CostAt(cost, near);
  }
  const CeresRows with = EvaluateAll(cost, start), without = EvaluateAll(other, start);
  ExpectNear(with.gradient(), without.gradient(), 1e-8);
  // One small step along every parameter: the subspace now holds the range of J.
  const double all = large.squaredNorm();
  EXPECT_GT(with.jacobian.squaredNorm(), (1.0 - 1e-4) * all);
  EXPECT_LT(without.jacobian.squaredNorm(), (1.0 - 1e-4) * all);
}

TEST_P(RolloutCostTest, AFirstForwardSweepOpensTheSubspace) {
  RolloutCostOptions options = WithJacobian(JacobianMethod::kAdjoint);
  options.starts_with_sensitivities = true;
  RolloutCost cost(motion_, blocks_, options);
  const RolloutCost sensitivity(motion_, blocks_, WithJacobian(JacobianMethod::kSensitivity));
  const Eigen::VectorXd start = StartOf(blocks_), near = start.array() + 1e-4;
  const CeresRows first = EvaluateAll(cost, start);
  ASSERT_TRUE(first.ok) << cost.last_failure();
  const Eigen::MatrixXd hessian = first.jacobian.transpose() * first.jacobian;
  const CeresRows exact = EvaluateAll(sensitivity, start);
  EXPECT_LT((hessian - exact.jacobian.transpose() * exact.jacobian).norm(), 1e-10 * hessian.norm());

  // From then on adjoint rows, in a subspace that the Jacobian of the point before has a place in.
  const CeresRows second = EvaluateAll(cost, near), all = EvaluateAll(sensitivity, near);
  EXPECT_EQ(cost.statistics().rollouts, 2);
  EXPECT_EQ(cost.statistics().sweeps, 2);
  ExpectNear(second.gradient(), all.gradient(), 1e-8);
  EXPECT_GT(second.jacobian.squaredNorm(), (1.0 - 1e-5) * all.jacobian.squaredNorm());
  cost.Restart();
  const Eigen::VectorXd far = start.array() + 0.1;
  ExpectNear(EvaluateAll(cost, far).gradient(), EvaluateAll(sensitivity, far).gradient(), 1e-8);
  EXPECT_EQ(cost.statistics().sweeps, 3);
}

// Near the solution, where the next point may be the last and its intervals need them.
TEST_P(RolloutCostTest, ExactRowsComeAlongWithTheRollout) {
  const Eigen::VectorXd start = StartOf(blocks_);
  const RolloutCost other(motion_, blocks_, WithJacobian(JacobianMethod::kAdjoint));
  const double alone = CostAt(other, start);
  for (const bool starts_with_sensitivities : {false, true}) {
    RolloutCostOptions options = WithJacobian(JacobianMethod::kAdjoint);
    options.starts_with_sensitivities = starts_with_sensitivities;
    const RolloutCost cost(motion_, blocks_, options);
    Eigen::MatrixXd jacobian;
    Eigen::VectorXd residuals;
    ASSERT_TRUE(cost.Linearize(start, {}, &jacobian, &residuals)) << cost.last_failure();
    const CeresRows rows = EvaluateAll(cost, start);
    EXPECT_EQ(cost.statistics().rollouts, 1);
    EXPECT_EQ(cost.statistics().sweeps, 1);
    EXPECT_EQ(CostAt(cost, start), alone) << "the cost is one function of the parameters";
    ExpectNear(rows.gradient(), jacobian.transpose() * residuals, 1e-12);
    ExpectNear(rows.gradient(), EvaluateAll(other, start).gradient(), 1e-8);
    const Eigen::MatrixXd hessian = jacobian.transpose() * jacobian;
    EXPECT_LT((rows.jacobian.transpose() * rows.jacobian - hessian).norm(), 1e-12 * hessian.norm());
  }
}

TEST_P(RolloutCostTest, RowsOfAKnownPointLeaveItsCostAlone) {
  RolloutCostOptions options = WithJacobian(JacobianMethod::kAdjoint);
  options.starts_with_sensitivities = true;
  const RolloutCost cost(motion_, blocks_, options);
  const Eigen::VectorXd start = StartOf(blocks_);
  const double alone = CostAt(cost, start);
  const CeresRows rows = EvaluateAll(cost, start);
  EXPECT_EQ(rows.cost(), alone);
  EXPECT_EQ(cost.statistics().rollouts, 2) << "the first Jacobian comes by a forward sweep also here";
  EXPECT_EQ(cost.statistics().sweeps, 1);
  Eigen::MatrixXd jacobian;
  Eigen::VectorXd residuals;
  ASSERT_TRUE(cost.Linearize(start, {}, &jacobian, &residuals));
  EXPECT_EQ(cost.statistics().sweeps, 1) << "these rows are exact";
}

TEST_P(RolloutCostTest, TheLastJacobianStaysInTheSubspace) {
  const RolloutCost cost(motion_, blocks_, WithJacobian(JacobianMethod::kAdjoint));
  const RolloutCost modes(motion_, blocks_, WithJacobian(JacobianMethod::kAdjoint));
  const Eigen::VectorXd start = StartOf(blocks_), near = start.array() + 1e-6;
  const double before = EvaluateAll(cost, start).jacobian.squaredNorm();
  const double after = EvaluateAll(cost, near).jacobian.squaredNorm();
  EXPECT_GT(after, (1.0 - 1e-4) * before);
  EXPECT_GT(after, (1.0 + 1e-6) * EvaluateAll(modes, near).jacobian.squaredNorm());
}

TEST_P(RolloutCostTest, PointsOfDifferentPrecisionAreKeptApart) {
  for (JacobianMethod method : {JacobianMethod::kAdjoint, JacobianMethod::kSensitivity}) {
    const RolloutCost cost(motion_, blocks_, WithJacobian(method));
    const RolloutCost only_full(motion_, blocks_, WithJacobian(method));
    const std::unique_ptr<RolloutCost> loose_cost = cost.AtPrecision(Precision::kLoose);
    const Eigen::VectorXd start = StartOf(blocks_);
    const double loose = EvaluateAll(*loose_cost, start).cost();
    const int loose_iterations = cost.statistics().counts.newton_iterations;
    const double full = EvaluateAll(cost, start).cost();
    EXPECT_NE(loose, full);
    EXPECT_NEAR(loose, full, 0.05 * full);
    EXPECT_EQ(full, EvaluateAll(only_full, start).cost());
    EXPECT_LT(loose_iterations, only_full.statistics().counts.newton_iterations);
    EXPECT_EQ(EvaluateAll(*loose_cost, start).cost(), loose);
    EXPECT_EQ(loose_cost->statistics().rollouts, 2);
    EXPECT_EQ(cost.statistics().rollouts, 2);
  }
}

TEST_P(RolloutCostTest, CeresChecksTheFullJacobian) {
  const FullResidualCost cost(motion_, blocks_);
  const Eigen::VectorXd start = StartOf(blocks_);
  std::vector<const double*> parameters;
  for (Eigen::Index i = 0; i < start.size(); ++i) parameters.push_back(start.data() + i);
  ceres::NumericDiffOptions options;
  options.ridders_relative_initial_step_size = 1e-6;  // Ceres starts 32 times above and extrapolates
  const ceres::GradientChecker checker(&cost, static_cast<const std::vector<const ceres::Manifold*>*>(nullptr),
                                       options);
  ceres::GradientChecker::ProbeResults results;
  // Single entries of J cross zero, so Ceres' relative errors are judged column by column.
  checker.Probe(parameters.data(), 1e-6, &results);
  ASSERT_TRUE(results.return_value) << results.error_log << cost.last_failure();
  for (std::size_t i = 0; i < results.jacobians.size(); ++i) {
    EXPECT_GT(results.jacobians[i].norm(), 0.0);
    EXPECT_LT((results.jacobians[i] - results.numeric_jacobians[i]).norm(), 1e-6 * results.jacobians[i].norm());
  }
}

TEST(RolloutCostTest, LinearizationIsThatOfTheFullResidualWithEveryMethod) {
  const Scene scene = SphereScene();
  MotionOptions truth;
  truth.true_values = {{"mu", 0.35}, {"k_stretch", 150.0}};
  const RecordedMotion motion = MakeMotion(scene, truth);
  const std::vector<ParameterBlock> blocks = MakeBlocks(scene, {"mu", "k_stretch", "density"});
  const Eigen::VectorXd start = StartOf(blocks);
  const CeresRows full = EvaluateAll(FullResidualCost(motion, blocks), start);
  const Eigen::MatrixXd hessian = full.jacobian.transpose() * full.jacobian;
  for (JacobianMethod method : {JacobianMethod::kAdjoint, JacobianMethod::kSensitivity, JacobianMethod::kNumeric}) {
    RolloutCostOptions options;
    options.jacobian = method;
    const RolloutCost cost(motion, blocks, options);
    Eigen::MatrixXd jacobian;
    Eigen::VectorXd residuals;
    Eigen::MatrixXd scores;
    ASSERT_TRUE(cost.Linearize(start, {}, &jacobian, &residuals, &scores)) << cost.last_failure();
    ASSERT_EQ(scores.cols(), motion.num_frames());
    EXPECT_LT((scores.rowwise().sum() - full.gradient()).norm(), 1e-10 * full.gradient().norm());
    EXPECT_TRUE(scores.col(0).isZero()) << "the first frame is the start, whatever the parameters";
    EXPECT_LT((jacobian.transpose() * jacobian - hessian).norm(), 1e-12 * hessian.norm());
    EXPECT_NEAR(residuals.squaredNorm(), 2.0 * full.cost(), 1e-12 * full.cost());
    EXPECT_LT((jacobian.transpose() * residuals - full.gradient()).norm(), 1e-10 * full.gradient().norm());
  }
}

// By the columns that the last exact rows left, by new ones and by a reverse sweep.
TEST(RolloutCostTest, PullsBackWhatTheFullJacobianDoes) {
  const RecordedMotion motion = SphereMotion();
  const std::vector<ParameterBlock> blocks = MakeBlocks(motion.scene, kSphereNames);
  const Eigen::VectorXd start = StartOf(blocks);
  const CeresRows full = EvaluateAll(FullResidualCost(motion, blocks), start);
  Eigen::MatrixXd here;
  ASSERT_TRUE(RolloutCost(motion, blocks, {}).Predict(start, &here));
  const Eigen::MatrixXd there = 1.01 * here;
  const Observation observation(motion);
  const Eigen::VectorXd change = observation.Residuals(there, {}) - observation.Residuals(here, {});
  const Eigen::VectorXd expected = full.jacobian.transpose() * change;
  for (const auto& [memory_limit, linearizes, num_sweeps] :
       {std::tuple{RolloutCostOptions().memory_limit, true, 0}, std::tuple{RolloutCostOptions().memory_limit, false, 1},
        std::tuple{std::size_t{1}, true, 1}}) {
    RolloutCostOptions options;
    options.memory_limit = memory_limit;
    const RolloutCost cost(motion, blocks, options);
    Eigen::MatrixXd jacobian;
    Eigen::VectorXd residuals, product;
    ASSERT_TRUE(!linearizes || cost.Linearize(start, {}, &jacobian, &residuals));
    const int sweeps = cost.statistics().sweeps;
    ASSERT_TRUE(cost.PullBackChange(start, there, {}, &product)) << cost.last_failure();
    EXPECT_EQ(cost.statistics().sweeps - sweeps, num_sweeps);
    ExpectNear(product, expected, 1e-9);
  }
}

}  // namespace
}  // namespace clothid::rollout_cost_test
