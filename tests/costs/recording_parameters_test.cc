// Derivatives with respect to a recording's own parameters: adjoint = sensitivity = central differences.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "costs/full_residual_cost.h"
#include "costs/rollout_cost.h"
#include "sim/base/error.h"
#include "tests/costs/synthetic_motion.h"

namespace clothid::recording_parameters_test {
namespace {

const std::vector<std::string> kNames = {"time_offset", "k_stretch", "shift.x", "shift.y", "shift.z", "turn.x",
                                         "turn.y",      "v0.x",      "turn.z",  "v0.y",    "mu",      "v0.z"};

std::vector<ParameterBlock> BlocksOf(const RecordedMotion& motion, const std::vector<std::string>& names) {
  std::vector<ParameterBlock> blocks;
  for (const std::string& name : names) blocks.push_back(MakeParameterBlock(name, motion, {}));
  return blocks;
}

// Off zero, so that no derivative is that of a special case; the offset moves every frame against the steps.
Eigen::VectorXd SomePoint(const std::vector<ParameterBlock>& blocks, double time_offset) {
  const std::map<std::string, double> values = {{"time_offset", time_offset},
                                                {"shift.x", 0.01},
                                                {"shift.y", -0.02},
                                                {"shift.z", 0.005},
                                                {"turn.x", 0.05},
                                                {"turn.y", -0.03},
                                                {"turn.z", 0.08},
                                                {"v0.x", 0.2},
                                                {"v0.y", -0.1},
                                                {"v0.z", 0.1}};
  Eigen::VectorXd point = StartOf(blocks);
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const auto it = values.find(blocks[i].name);
    if (it != values.end()) point[i] = blocks[i].ToCoordinate(it->second);
  }
  return point;
}

RecordedMotion SwingAtSteps() {
  MotionOptions options;
  options.true_values = {{"k_stretch", 90.0}};
  options.noise = 1e-3;
  return MakeMotion(SwingScene(), options);
}

RecordedMotion SphereBetweenSteps() {
  MotionOptions options;
  options.true_values = {{"mu", 0.35}, {"k_stretch", 90.0}};
  options.sigma = 1e-3;
  options.frame_interval = 0.0125;
  return MakeMotion(SphereScene(), options);
}

RecordedMotion MarkersBetweenSteps() { return WithMarkers(SphereBetweenSteps()); }

struct Case {
  const char* name;
  RecordedMotion (*motion)();
  double time_offset;  // s
};

class RecordingParametersTest : public testing::TestWithParam<Case> {
 protected:
  RecordingParametersTest()
      : motion_(GetParam().motion()),
        blocks_(BlocksOf(motion_, kNames)),
        point_(SomePoint(blocks_, GetParam().time_offset)) {}

  double CostAt(const RolloutCost& cost, const Eigen::VectorXd& coordinates) const {
    double value = 0.0;
    EXPECT_TRUE(cost.EvaluateGradient(coordinates, &value, nullptr)) << cost.last_failure();
    return value;
  }

  RecordedMotion motion_;
  std::vector<ParameterBlock> blocks_;
  Eigen::VectorXd point_;
};

INSTANTIATE_TEST_SUITE_P(Scenes, RecordingParametersTest,
                         testing::Values(Case{"SwingLate", &SwingAtSteps, 0.0037},
                                         Case{"SwingBeforeTheStart", &SwingAtSteps, -0.0113},
                                         Case{"Sphere", &SphereBetweenSteps, 0.0081},
                                         Case{"Markers", &MarkersBetweenSteps, -0.0042}),
                         [](const auto& test) { return test.param.name; });

TEST_P(RecordingParametersTest, AdjointAgreesWithSensitivities) {
  for (const char* loss : {"none", "huber:2"}) {
    RolloutCostOptions options;
    options.loss = ParseRobustLoss(loss);
    const RolloutCost adjoint(motion_, blocks_, options);
    options.jacobian = JacobianMethod::kSensitivity;
    const RolloutCost sensitivity(motion_, blocks_, options);
    double cost = 0.0, same_cost = 0.0;
    Eigen::VectorXd a, s;
    ASSERT_TRUE(adjoint.EvaluateGradient(point_, &cost, &a)) << adjoint.last_failure();
    ASSERT_TRUE(sensitivity.EvaluateGradient(point_, &same_cost, &s)) << sensitivity.last_failure();
    EXPECT_NEAR(cost, same_cost, 1e-12 * cost);
    for (Eigen::Index i = 0; i < a.size(); ++i) {
      EXPECT_NEAR(a[i], s[i], 1e-10 * (std::abs(s[i]) + 1e-3 * s.norm())) << blocks_[i].name << " " << loss;
    }
  }
}

TEST_P(RecordingParametersTest, GradientsAgreeWithCentralDifferences) {
  const double step = 1e-5;
  for (const char* loss : {"none", "huber:2"}) {
    RolloutCostOptions options;
    options.loss = ParseRobustLoss(loss);
    const RolloutCost cost(motion_, blocks_, options);
    double value = 0.0;
    Eigen::VectorXd gradient;
    ASSERT_TRUE(cost.EvaluateGradient(point_, &value, &gradient));
    for (Eigen::Index i = 0; i < gradient.size(); ++i) {
      Eigen::VectorXd above = point_, below = point_;
      above[i] += step;
      below[i] -= step;
      const double difference = (CostAt(cost, above) - CostAt(cost, below)) / (2.0 * step);
      EXPECT_NEAR(gradient[i], difference, 2e-6 * std::abs(difference) + 1e-7 * gradient.norm())
          << blocks_[i].name << " " << loss;
    }
  }
}

TEST_P(RecordingParametersTest, TheJacobianIsThatOfDifferences) {
  const FullResidualCost cost(motion_, blocks_);
  const double step = 1e-5;
  const auto evaluate = [&](const Eigen::VectorXd& coordinates, Eigen::MatrixXd* jacobian) {
    Eigen::VectorXd residuals(cost.num_residuals());
    std::vector<const double*> parameters;
    std::vector<double*> jacobians;
    if (jacobian != nullptr) jacobian->resize(cost.num_residuals(), coordinates.size());
    for (Eigen::Index i = 0; i < coordinates.size(); ++i) {
      parameters.push_back(coordinates.data() + i);
      if (jacobian != nullptr) jacobians.push_back(jacobian->col(i).data());
    }
    EXPECT_TRUE(cost.Evaluate(parameters.data(), residuals.data(), jacobian != nullptr ? jacobians.data() : nullptr));
    return residuals;
  };
  Eigen::MatrixXd jacobian;
  evaluate(point_, &jacobian);
  for (Eigen::Index i = 0; i < point_.size(); ++i) {
    Eigen::VectorXd above = point_, below = point_;
    above[i] += step;
    below[i] -= step;
    const Eigen::VectorXd difference = (evaluate(above, nullptr) - evaluate(below, nullptr)) / (2.0 * step);
    EXPECT_LE((jacobian.col(i) - difference).norm(), 2e-6 * difference.norm()) << blocks_[i].name;
  }
}

// Of a prediction made step by step with checkpoints, and of forward differences.
TEST_P(RecordingParametersTest, EveryWayGivesTheSameRows) {
  const auto rows = [&](const RolloutCostOptions& options) {
    const RolloutCost cost(motion_, blocks_, options);
    Eigen::MatrixXd jacobian;
    Eigen::VectorXd residuals(cost.num_residuals());
    jacobian.resize(cost.num_residuals(), point_.size());
    std::vector<const double*> parameters;
    std::vector<double*> jacobians;
    for (Eigen::Index i = 0; i < point_.size(); ++i) {
      parameters.push_back(point_.data() + i);
      jacobians.push_back(jacobian.col(i).data());
    }
    EXPECT_TRUE(cost.Evaluate(parameters.data(), residuals.data(), jacobians.data())) << cost.last_failure();
    return Eigen::VectorXd(jacobian.transpose() * residuals);
  };
  RolloutCostOptions options;
  const Eigen::VectorXd free = rows(options);
  options.memory_limit = 0;
  EXPECT_LT((rows(options) - free).norm(), 1e-6 * free.norm());
  options.jacobian = JacobianMethod::kNumeric;
  EXPECT_LT((rows(options) - free).norm(), 2e-3 * free.norm());
  options = {};
  options.starts_with_sensitivities = true;
  EXPECT_LT((rows(options) - free).norm(), 1e-9 * free.norm());
}

TEST(RecordingModelTest, AtZeroNothingIsCorrected) {
  const RecordedMotion motion = SphereBetweenSteps();
  RecordingModel plain(motion, BlocksOf(motion, {"k_stretch"}));
  const std::vector<ParameterBlock> blocks = BlocksOf(motion, {"k_stretch", "shift.x", "turn.y", "v0.z"});
  RecordingModel aligned(motion, blocks);
  Eigen::MatrixXd expected, predicted;
  ASSERT_TRUE(plain.Simulate(StartOf(BlocksOf(motion, {"k_stretch"})), {}, {}, &expected).ok());
  Eigen::VectorXd coordinates = StartOf(blocks);
  ASSERT_TRUE(aligned.Simulate(coordinates, {}, {}, &predicted).ok());
  EXPECT_LT((predicted - expected).cwiseAbs().maxCoeff(), 1e-15);
  // A start velocity does not stay for the next rollout.
  coordinates[3] = 0.5;
  ASSERT_TRUE(aligned.Simulate(coordinates, {}, {}, &predicted).ok());
  EXPECT_GT((predicted - expected).cwiseAbs().maxCoeff(), 1e-2);
  coordinates[3] = 0.0;
  ASSERT_TRUE(aligned.Simulate(coordinates, {}, {}, &predicted).ok());
  EXPECT_LT((predicted - expected).cwiseAbs().maxCoeff(), 1e-15);
}

// Standing handles and moving ones, a damped cloth, a time offset and a start velocity beside them.
TEST(HandleShiftTest, AdjointIsSensitivityIsCentralDifferences) {
  for (const bool moves : {false, true}) {
    Scene scene = SwingScene();
    scene.material.damping = 0.01;
    if (moves) {
      Eigen::MatrixXd places(6, 3);
      places.topRows(3) = Eigen::Vector3d(0.0, 0.0, 0.0).replicate(1, 3);
      places.bottomRows(3) = scene.initial_positions.segment<3>(12).replicate(1, 3);
      places.row(1) << 0.0, 0.02, 0.01;
      scene.handles.path = HandlePath(Eigen::Vector3d(0.0, 0.1, 0.2), places);
    }
    MotionOptions options;
    options.true_values = {{"k_stretch", 90.0}};
    options.noise = 1e-3;
    const RecordedMotion motion = MakeMotion(scene, options);
    const std::vector<ParameterBlock> blocks =
        BlocksOf(motion, {"handle_shift.z", "k_stretch", "v0.x", "handle_shift.x", "shift.y", "handle_shift.y"});
    Eigen::VectorXd point(6);
    point << 0.1, blocks[1].ToCoordinate(blocks[1].start), 0.1, -0.05, 0.02, 0.15;
    RolloutCostOptions method;
    const RolloutCost adjoint(motion, blocks, method);
    method.jacobian = JacobianMethod::kSensitivity;
    const RolloutCost sensitivity(motion, blocks, method);
    double value = 0.0, same_value = 0.0, above_value = 0.0, below_value = 0.0;
    Eigen::VectorXd a, s;
    ASSERT_TRUE(adjoint.EvaluateGradient(point, &value, &a)) << adjoint.last_failure();
    ASSERT_TRUE(sensitivity.EvaluateGradient(point, &same_value, &s)) << sensitivity.last_failure();
    for (Eigen::Index i = 0; i < a.size(); ++i) {
      EXPECT_NEAR(a[i], s[i], 1e-10 * s.norm()) << blocks[i].name << " " << moves;
      Eigen::VectorXd above = point, below = point;
      above[i] += 1e-5;
      below[i] -= 1e-5;
      ASSERT_TRUE(adjoint.EvaluateGradient(above, &above_value, nullptr));
      ASSERT_TRUE(adjoint.EvaluateGradient(below, &below_value, nullptr));
      EXPECT_NEAR(a[i], (above_value - below_value) / 2e-5, 2e-6 * std::abs(a[i]) + 1e-7 * s.norm())
          << blocks[i].name << " " << moves;
    }
  }
}

TEST(HandleShiftTest, MovesHandlesAtAllTimes) {
  const RecordedMotion motion = SwingAtSteps();
  const std::vector<ParameterBlock> blocks = BlocksOf(motion, {"handle_shift.y"});
  RecordingModel model(motion, blocks), plain(motion, {});
  Eigen::MatrixXd shifted, expected;
  ASSERT_TRUE(model.Simulate(Eigen::VectorXd::Constant(1, blocks[0].ToCoordinate(0.004)), {}, {}, &shifted).ok());
  ASSERT_TRUE(plain.Simulate({}, {}, {}, &expected).ok());
  const Eigen::MatrixXd moved = shifted - expected;
  for (const int node : {0, 4}) {
    EXPECT_LT((moved.middleRows<3>(3 * node).colwise() - Eigen::Vector3d(0.0, 0.004, 0.0)).norm(), 1e-12);
  }
  EXPECT_TRUE(moved.col(0).segment<3>(3).isZero(0.0));  // the start of a free node
  ASSERT_TRUE(model.Simulate(Eigen::VectorXd::Zero(1), {}, {}, &shifted).ok());
  EXPECT_LT((shifted - expected).norm(), 1e-12);
  RecordedMotion free = motion;
  free.scene.handles = {};
  EXPECT_THROW(BlocksOf(free, {"handle_shift.y"}), Error);
}

TEST(RecordingModelTest, TheTimeOffsetNeedsVelocities) {
  const RecordedMotion motion = SphereBetweenSteps();
  const std::vector<ParameterBlock> blocks = BlocksOf(motion, {"k_stretch", "time_offset"});
  RecordingModel model(motion, blocks);
  const Eigen::VectorXd coordinates = StartOf(blocks);
  const Eigen::VectorXd seeds = Eigen::VectorXd::Ones(model.observation().num_residuals());
  Eigen::MatrixXd predicted, velocities;
  const Rollout rollout = model.Simulate(coordinates, {}, {}, &predicted, &velocities);
  ASSERT_TRUE(rollout.ok());
  EXPECT_EQ(velocities.size(), predicted.size());
  const auto pull_back = [&](const Eigen::MatrixXd& given, const std::vector<int>& active) {
    return model.PullBack(rollout, predicted, given, coordinates, active, seeds, {}, Precision::kFull);
  };
  EXPECT_THROW(pull_back({}, {0, 1}), std::logic_error);
  EXPECT_EQ(pull_back({}, {0})(0), pull_back(velocities, {0, 1})(0));
}

// What no parameter of the recording asks for is left out.
TEST(RecordingModelTest, WithoutATimeOffsetThereAreNoVelocities) {
  const RecordedMotion motion = SphereBetweenSteps();
  const std::vector<ParameterBlock> blocks = BlocksOf(motion, {"k_stretch", "shift.x", "v0.x"});
  RecordingModel model(motion, blocks);
  Eigen::MatrixXd predicted, velocities = Eigen::MatrixXd::Ones(2, 2);
  ASSERT_TRUE(model.Simulate(StartOf(blocks), {}, {}, &predicted, &velocities).ok());
  EXPECT_EQ(velocities.size(), 0);
}

}  // namespace
}  // namespace clothid::recording_parameters_test
