// The unknowns of a start: what they do to a rollout, their derivatives three ways, and what is believed of them.
#include "costs/start/unknown_start.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "costs/rollout_cost.h"
#include "tests/costs/start/forget_start.h"
#include "tests/costs/synthetic_motion.h"

namespace clothid::unknown_start_test {
namespace {

constexpr double kNoise = 1e-3;

RecordedMotion NoisySphere(StartSource source) {
  Scene scene = SphereScene();
  scene.material.damping = 0.01;
  MotionOptions options;
  options.noise = options.sigma = kNoise;
  return ForgetStart(source, MakeMotion(scene, options));
}

// Somewhere off the base [p + n].
Eigen::VectorXd SomePoint(const RolloutCost& cost) {
  const std::vector<ParameterBlock>& blocks = cost.model().blocks();
  Eigen::VectorXd point(cost.model().num_coordinates());
  point.head(static_cast<Eigen::Index>(blocks.size())) = StartOf(blocks);
  std::srand(3);
  point.tail(cost.model().num_start_unknowns()).setRandom();
  point.tail(cost.model().num_start_unknowns()) *= 2e-4;
  return point;
}

double CostAt(const RolloutCost& cost, const Eigen::VectorXd& point) {
  double value = 0.0;
  EXPECT_TRUE(cost.EvaluateGradient(point, &value, nullptr)) << cost.last_failure();
  return value;
}

Eigen::MatrixXd AllUnknowns(const RolloutCost& cost) {
  return Eigen::MatrixXd::Identity(cost.model().num_unknowns(), cost.model().num_unknowns());
}

class UnknownStartTest : public ::testing::TestWithParam<StartSource> {};

TEST_P(UnknownStartTest, AdjointEqualsSensitivityEqualsDifferences) {
  const RecordedMotion motion = NoisySphere(GetParam());
  const RolloutCost cost(motion, MakeBlocks(motion.scene, {"mu", "k_stretch"}), {});
  const UnknownStart& start = *cost.model().unknown_start();
  EXPECT_EQ(start.num_position_unknowns(), 3 * 20) << "every free node";
  EXPECT_EQ(start.num_handle_unknowns(), 3 * 5);
  EXPECT_EQ(start.size(), 75 + (GetParam() == StartSource::kMoving ? 60 : 0));
  const Eigen::VectorXd point = SomePoint(cost);
  double value = 0.0;
  Eigen::VectorXd gradient, residuals;
  Eigen::MatrixXd jacobian;
  ASSERT_TRUE(cost.EvaluateGradient(point, &value, &gradient));
  ASSERT_TRUE(cost.Linearize(point, AllUnknowns(cost), &jacobian, &residuals));
  EXPECT_NEAR(value, 0.5 * residuals.squaredNorm(), 1e-9 * value);
  // The matrix is made to kStartAdjointTolerance.
  EXPECT_LE((jacobian.transpose() * residuals - gradient).norm(), 1e-2 * gradient.norm());
  int checked = 0;
  for (Eigen::Index i = 0; i < point.size(); i += 7) {
    double best = 1.0;
    for (const double step : {1e-6, 1e-7, 1e-5}) {
      Eigen::VectorXd plus = point, minus = point;
      plus[i] += step;
      minus[i] -= step;
      const double difference = (CostAt(cost, plus) - CostAt(cost, minus)) / (2.0 * step);
      best = std::min(best, std::abs(difference - gradient[i]));
    }
    EXPECT_LE(best, 1e-5 * std::abs(gradient[i]) + 1e-7 * gradient.norm()) << i;
    ++checked;
  }
  EXPECT_GE(checked, 11);
}

// The path of the handles is off by what their sensor scatters and by one vector beside it.
TEST_P(UnknownStartTest, HandlesMayBeShiftedBesides) {
  const RecordedMotion motion = NoisySphere(GetParam());
  std::vector<ParameterBlock> blocks;
  for (const char* name : {"handle_shift.z", "k_stretch", "v0.x", "handle_shift.y"}) {
    blocks.push_back(MakeParameterBlock(name, motion, {}));
  }
  const RolloutCost cost(motion, blocks, {});
  Eigen::VectorXd point = SomePoint(cost), gradient, residuals;
  point[0] = 0.05;
  point[3] = -0.1;
  double value = 0.0;
  Eigen::MatrixXd jacobian;
  ASSERT_TRUE(cost.EvaluateGradient(point, &value, &gradient)) << cost.last_failure();
  ASSERT_TRUE(cost.Linearize(point, AllUnknowns(cost), &jacobian, &residuals));
  EXPECT_LE((jacobian.transpose() * residuals - gradient).norm(), 1e-2 * gradient.norm());
  for (const Eigen::Index i : {0, 2, 3, 40, 70}) {
    Eigen::VectorXd plus = point, minus = point;
    plus[i] += 1e-6;
    minus[i] -= 1e-6;
    const double difference = (CostAt(cost, plus) - CostAt(cost, minus)) / 2e-6;
    EXPECT_NEAR(gradient[i], difference, 1e-5 * std::abs(gradient[i]) + 1e-6 * gradient.norm()) << i;
  }
}

TEST_P(UnknownStartTest, RowsAreThoseOfTheCost) {
  const RecordedMotion motion = NoisySphere(GetParam());
  RolloutCostOptions options;
  options.jacobian = JacobianMethod::kSensitivity;
  const RolloutCost cost(motion, MakeBlocks(motion.scene, {"k_stretch"}), options);
  const Eigen::VectorXd point = SomePoint(cost);
  const int n = cost.model().num_start_unknowns();
  ASSERT_EQ(cost.parameter_block_sizes(), (std::vector<std::int32_t>{1, n}));
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  Eigen::VectorXd residuals(cost.num_residuals()), own(cost.num_residuals());
  RowMajor of_start(cost.num_residuals(), n);
  const double* parameters[] = {point.data(), point.data() + 1};
  double* jacobians[] = {own.data(), of_start.data()};
  ASSERT_TRUE(cost.Evaluate(parameters, residuals.data(), jacobians));
  double value = 0.0;
  Eigen::VectorXd gradient;
  ASSERT_TRUE(cost.EvaluateGradient(point, &value, &gradient));
  EXPECT_NEAR(0.5 * residuals.squaredNorm(), value, 1e-9 * value);
  EXPECT_NEAR(own.dot(residuals), gradient[0], 1e-2 * gradient.norm());
  EXPECT_LE((of_start.transpose() * residuals - gradient.tail(n)).norm(), 1e-2 * gradient.norm());
}

// A parameter that takes the start with it: the derivative is the sum of two columns.
TEST_P(UnknownStartTest, RunsAlongCombinations) {
  const RecordedMotion motion = NoisySphere(GetParam());
  const RolloutCost cost(motion, MakeBlocks(motion.scene, {"mu", "k_stretch"}), {});
  const Eigen::VectorXd point = SomePoint(cost);
  std::srand(5);
  const Eigen::MatrixXd follow = 1e-3 * Eigen::MatrixXd::Random(cost.model().num_start_unknowns(), 2);
  Eigen::MatrixXd along, scores;
  Eigen::VectorXd residuals, gradient;
  ASSERT_TRUE(cost.Linearize(point, follow, &along, &residuals, &scores));
  double value = 0.0;
  ASSERT_TRUE(cost.EvaluateGradient(point, &value, &gradient));
  const Eigen::VectorXd expected = gradient.head(2) + follow.transpose() * gradient.tail(follow.rows());
  EXPECT_LE(((along.leftCols(2) + along.rightCols(2)).transpose() * residuals - expected).norm(),
            1e-8 * gradient.norm());
  EXPECT_NEAR(0.5 * residuals.squaredNorm(), value, 1e-9 * value);
  EXPECT_EQ(scores.rows(), 4);
  EXPECT_EQ(scores.cols(), motion.num_frames());
}

std::string SourceName(const ::testing::TestParamInfo<StartSource>& source) {
  return source.param == StartSource::kRest ? "Rest" : "Moving";
}

INSTANTIATE_TEST_SUITE_P(Starts, UnknownStartTest, ::testing::Values(StartSource::kRest, StartSource::kMoving),
                         SourceName);

// Without noise the measured start is the true one: no prior pulls it away by more than its own doubt.
TEST(StartPriorTest, IsCentredNearTheBase) {
  const RecordedMotion motion = NoisySphere(StartSource::kRest);
  const UnknownStart start(motion);
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(start.size());
  EXPECT_LT(2.0 * start.PriorAt(zero), start.size()) << "the base is no surprise to it";
  // A strain of 30 % of the whole cloth is.
  Eigen::VectorXd stretched = zero;
  const Eigen::MatrixXd& directions = start.directions().initial_positions;
  const Eigen::VectorXd wanted = 0.3 * motion.scene.initial_positions;
  stretched = directions.colPivHouseholderQr().solve(wanted);
  EXPECT_GT(start.PriorAt(stretched), 20.0 * start.PriorAt(zero));
}

// What is believed of angles does not depend on the law: the doubt of a bent cloth is the same but for its borders.
TEST(StartPriorTest, BendingCostsAlikeByEitherLaw) {
  RecordedMotion motion = NoisySphere(StartSource::kRest);
  double rises[2];
  for (const BendingLaw law : {BendingLaw::kEdges, BendingLaw::kPatches}) {
    motion.scene.bending.law = law;
    const UnknownStart start(motion);
    const Eigen::MatrixXd& directions = start.directions().initial_positions;
    Eigen::VectorXd bent = Eigen::VectorXd::Zero(directions.rows());
    for (int node = 0; node < motion.scene.mesh.num_nodes(); ++node) {
      const double y = motion.scene.mesh.rest_positions(1, node);
      bent[3 * node + 2] = 5.0 * y * y;
    }
    const Eigen::VectorXd there = directions.colPivHouseholderQr().solve(bent), back = -there;
    const Eigen::VectorXd zero = Eigen::VectorXd::Zero(start.size());
    rises[static_cast<int>(law)] = start.PriorAt(there) + start.PriorAt(back) - 2.0 * start.PriorAt(zero);
  }
  EXPECT_GT(rises[1], 0.8 * rises[0]);
  EXPECT_LT(rises[1], 1.6 * rises[0]);
}

// Handles are believed to be where they were measured: twenty-one times, with an error of kNoise each.
TEST(StartPriorTest, HandlesAreAsSureAsTheirMean) {
  const RecordedMotion motion = NoisySphere(StartSource::kRest);
  const UnknownStart start(motion);
  Eigen::VectorXd off = Eigen::VectorXd::Zero(start.size());
  for (int i = 0; i < start.num_handle_unknowns(); i += 3) off[start.num_position_unknowns() + i] = kNoise;
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(start.size());
  const double rise = 2.0 * (start.PriorAt(off) - start.PriorAt(zero));
  EXPECT_GT(rise, 0.7 * 5 * motion.num_frames()) << "five handles";
  EXPECT_LT(rise, 1.5 * 5 * motion.num_frames());
}

}  // namespace
}  // namespace clothid::unknown_start_test
