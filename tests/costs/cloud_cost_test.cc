// Costs and derivatives of recordings of point clouds, alone and beside tracked points.
#include <ceres/gradient_checker.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "costs/full_residual_cost.h"
#include "costs/rollout_cost.h"
#include "costs/rows/residual_basis.h"
#include "tests/costs/synthetic_clouds.h"
#include "tests/costs/synthetic_motion.h"

namespace clothid::cloud_cost_test {
namespace {

const std::vector<std::string> kNames = {"mu", "k_stretch", "k_bend"};

// Clouds alone, clouds beside tracked points, and tracked points that are not material.
enum class Kind { kAlone, kBesidePoints, kSliding };

// Frames between the steps of a cloth that slides on a ball; clouds of 40 points, with 2 mm of noise.
RecordedMotion CloudMotion(Kind kind) {
  MotionOptions options;
  options.true_values = {{"mu", 0.35}, {"k_stretch", 90.0}};
  options.frame_interval = 0.0125;
  options.sigma = 1e-3;
  if (kind == Kind::kSliding) {
    RecordedMotion motion = MakeMotion(SphereScene(), options);
    SlidePoints(/*borders=*/true, 12, &motion);
    motion.positions.col(3).setConstant(std::numeric_limits<double>::quiet_NaN());
    std::mt19937_64 generator(13);
    std::normal_distribution<double> normal(0.0, 2e-3);
    for (double& position : motion.positions.reshaped()) position += normal(generator);
    return motion;
  }
  const bool keep_points = kind == Kind::kBesidePoints;
  RecordedMotion motion = MakeMotion(SphereScene(), options);
  AddClouds(40, 2e-3, keep_points, &motion);
  motion.cloud_sigma = 2e-3;
  if (keep_points) motion.positions.col(5).setConstant(std::numeric_limits<double>::quiet_NaN());
  motion.clouds[3].resize(3, 0);
  return motion;
}

class CloudCostTest : public testing::TestWithParam<Kind> {
 protected:
  CloudCostTest() : motion_(CloudMotion(GetParam())), blocks_(MakeBlocks(motion_.scene, kNames)) {}

  RolloutCost Cost(JacobianMethod method, const std::string& loss) const {
    RolloutCostOptions options;
    options.jacobian = method;
    options.loss = ParseRobustLoss(loss);
    return RolloutCost(motion_, blocks_, options);
  }

  RecordedMotion motion_;
  std::vector<ParameterBlock> blocks_;
};

std::string NameOf(const testing::TestParamInfo<Kind>& test) {
  return test.param == Kind::kAlone ? "Alone" : test.param == Kind::kBesidePoints ? "BesidePoints" : "Sliding";
}

INSTANTIATE_TEST_SUITE_P(Kinds, CloudCostTest, testing::Values(Kind::kAlone, Kind::kBesidePoints, Kind::kSliding),
                         NameOf);

Eigen::VectorXd GradientOf(const RolloutCost& cost, const Eigen::VectorXd& coordinates, double* value) {
  Eigen::VectorXd gradient;
  EXPECT_TRUE(cost.EvaluateGradient(coordinates, value, &gradient)) << cost.last_failure();
  return gradient;
}

double CostAt(const RolloutCost& cost, const Eigen::VectorXd& coordinates) {
  double value = 0.0;
  EXPECT_TRUE(cost.EvaluateGradient(coordinates, &value, nullptr)) << cost.last_failure();
  return value;
}

TEST_P(CloudCostTest, AdjointIsSensitivityIsCentralDifferences) {
  for (const char* loss : {"none", "huber:1"}) {
    const RolloutCost adjoint = Cost(JacobianMethod::kAdjoint, loss),
                      sensitivity = Cost(JacobianMethod::kSensitivity, loss);
    const Eigen::VectorXd start = StartOf(blocks_);
    double adjoint_value = 0.0, value = 0.0;
    const Eigen::VectorXd by_adjoint = GradientOf(adjoint, start, &adjoint_value),
                          by_sensitivity = GradientOf(sensitivity, start, &value);
    EXPECT_NEAR(adjoint_value, value, 1e-12 * value);
    for (Eigen::Index i = 0; i < start.size(); ++i) {
      EXPECT_NEAR(by_adjoint[i], by_sensitivity[i], 1e-10 * std::abs(by_sensitivity[i])) << kNames[i];
      const double step = 1e-5;
      Eigen::VectorXd above = start, below = start;
      above[i] += step;
      below[i] -= step;
      const double difference = (CostAt(adjoint, above) - CostAt(adjoint, below)) / (2.0 * step);
      EXPECT_NEAR(by_adjoint[i], difference, 2e-6 * std::abs(difference)) << kNames[i];
    }
  }
}

// The rigid correction and the time offset act on the nodes that a cloud is measured against.
TEST_P(CloudCostTest, ParametersOfTheRecordingHaveTheirDerivatives) {
  const std::vector<std::string> names = {"k_stretch", "time_offset", "shift.x", "turn.y", "v0.z"};
  std::vector<ParameterBlock> blocks;
  for (const std::string& name : names) blocks.push_back(MakeParameterBlock(name, motion_, {}));
  Eigen::VectorXd point(5);
  point << blocks[0].ToCoordinate(blocks[0].start), 0.1, 0.01, -0.05, 0.02;
  RolloutCostOptions options;
  const RolloutCost adjoint(motion_, blocks, options);
  options.jacobian = JacobianMethod::kSensitivity;
  const RolloutCost sensitivity(motion_, blocks, options);
  double adjoint_value = 0.0, value = 0.0;
  const Eigen::VectorXd by_adjoint = GradientOf(adjoint, point, &adjoint_value),
                        by_sensitivity = GradientOf(sensitivity, point, &value);
  EXPECT_NEAR(adjoint_value, value, 1e-12 * value);
  for (Eigen::Index i = 0; i < point.size(); ++i) {
    EXPECT_NEAR(by_adjoint[i], by_sensitivity[i], 1e-10 * by_sensitivity.norm()) << names[i];
    const double step = 1e-5;
    Eigen::VectorXd above = point, below = point;
    above[i] += step;
    below[i] -= step;
    const double difference = (CostAt(adjoint, above) - CostAt(adjoint, below)) / (2.0 * step);
    EXPECT_NEAR(by_adjoint[i], difference, 2e-6 * std::abs(difference) + 1e-7 * by_sensitivity.norm()) << names[i];
  }
}

TEST_P(CloudCostTest, EveryMethodHasTheGaussNewtonMatrixOfTheFullJacobian) {
  const FullResidualCost full(motion_, blocks_);
  const Eigen::VectorXd start = StartOf(blocks_);
  Eigen::VectorXd e(full.num_residuals());
  Eigen::MatrixXd j(full.num_residuals(), start.size());
  std::vector<const double*> parameters;
  std::vector<double*> columns;
  for (Eigen::Index i = 0; i < start.size(); ++i) {
    parameters.push_back(start.data() + i);
    columns.push_back(j.col(i).data());
  }
  ASSERT_TRUE(full.Evaluate(parameters.data(), e.data(), columns.data())) << full.last_failure();
  EXPECT_EQ(e.size(), Observation(motion_).num_residuals());
  const Eigen::MatrixXd hessian = j.transpose() * j;
  for (JacobianMethod method : {JacobianMethod::kAdjoint, JacobianMethod::kSensitivity, JacobianMethod::kNumeric}) {
    const RolloutCost cost = Cost(method, "none");
    Eigen::MatrixXd jacobian;
    Eigen::VectorXd residuals;
    ASSERT_TRUE(cost.Linearize(start, {}, &jacobian, &residuals)) << cost.last_failure();
    EXPECT_LT((jacobian.transpose() * jacobian - hessian).norm(), 1e-11 * hessian.norm());
    EXPECT_NEAR(residuals.norm(), e.norm(), 1e-12 * e.norm());
  }
  const RolloutCost numeric = Cost(JacobianMethod::kNumeric, "none");
  double value = 0.0;
  const Eigen::VectorXd gradient = GradientOf(numeric, start, &value);
  EXPECT_LT((gradient - j.transpose() * e).norm(), 1e-3 * gradient.norm());
}

// The rows for Ceres: the subspace holds the range of J once there are differences along every parameter.
TEST_P(CloudCostTest, DifferencesOfResidualsWidenTheSubspace) {
  const RolloutCost cost = Cost(JacobianMethod::kAdjoint, "none");
  const Eigen::VectorXd start = StartOf(blocks_);
  for (Eigen::Index i = 0; i < start.size(); ++i) {
    Eigen::VectorXd near = start;
    near[i] += 1e-4;
    CostAt(cost, near);
  }
  Eigen::VectorXd rows(cost.num_residuals());
  Eigen::MatrixXd jacobian(cost.num_residuals(), start.size());
  std::vector<const double*> parameters;
  std::vector<double*> columns;
  for (Eigen::Index i = 0; i < start.size(); ++i) {
    parameters.push_back(start.data() + i);
    columns.push_back(jacobian.col(i).data());
  }
  ASSERT_TRUE(cost.Evaluate(parameters.data(), rows.data(), columns.data())) << cost.last_failure();
  Eigen::MatrixXd whole;
  Eigen::VectorXd unused;
  ASSERT_TRUE(cost.Linearize(start, {}, &whole, &unused));
  EXPECT_GT(jacobian.squaredNorm(), (1.0 - 1e-3) * whole.squaredNorm());
  EXPECT_LT(jacobian.squaredNorm(), (1.0 + 1e-9) * whole.squaredNorm());
}

TEST_P(CloudCostTest, ModesAreShiftsOfTheClothToFirstOrder) {
  const Observation observation(motion_);
  const RolloutCost cost = Cost(JacobianMethod::kAdjoint, "none");
  Eigen::MatrixXd predicted;
  ASSERT_TRUE(cost.Predict(StartOf(blocks_), &predicted));
  const Eigen::MatrixXd modes = DisplacementModes(observation, ResidualDerivative(&observation, predicted));
  const Eigen::Vector3d shift(0.3, -0.5, 0.2);
  const double step = 1e-7;
  const Eigen::VectorXd pattern = shift.replicate(predicted.rows() / 3, 1);
  const Eigen::VectorXd difference = (observation.Residuals(predicted.colwise() + step * pattern) -
                                      observation.Residuals(predicted.colwise() - step * pattern)) /
                                     (2.0 * step);
  EXPECT_LT((modes * shift.replicate(kNumTimeWindows, 1) - difference).norm(), 1e-5 * difference.norm());
}

TEST(CloudLossTest, EveryPointOfACloudIsWeighedAlone) {
  RecordedMotion motion = CloudMotion(Kind::kBesidePoints);
  const Observation observation(motion);
  Eigen::VectorXd e = Eigen::VectorXd::Zero(observation.num_residuals()), weights;
  const int end = observation.first_row(1);
  e.segment(end - 3, 3) << 0.5, -8.0, 2.0;
  const double cost = LossWeights(ParseRobustLoss("huber:2"), observation, 0, e, &weights);
  EXPECT_NEAR(cost, 0.5 * (0.25 + (2.0 * 2.0 * 8.0 - 4.0) + 4.0), 1e-12);
  EXPECT_NEAR(weights[end - 2], 0.5, 1e-14);
  EXPECT_EQ(weights[end - 1], 1.0);
  EXPECT_EQ(weights[end - 3], 1.0);
}

}  // namespace
}  // namespace clothid::cloud_cost_test
