// Covariance, intervals and hidden directions of problems whose answer is known.
#include "identify/uncertainty/uncertainty.h"

#include <ceres/autodiff_cost_function.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <random>

#include "identify/uncertainty/discretization_error.h"

namespace clothid::uncertainty_test {
namespace {

ParameterBlock Linear(const std::string& name, double lower, double upper) {
  ParameterBlock block;
  block.name = name;
  block.start = 0.5 * (lower + upper);
  block.lower_bound = lower;
  block.upper_bound = upper;
  return block;
}

ParameterBlock Log(const std::string& name) {
  ParameterBlock block = Linear(name, 1e-3, 1e3);
  block.scale = ParameterScale::kLog;
  return block;
}

Eigen::MatrixXd RandomMatrix(int rows, int columns) {
  std::mt19937_64 generator(3);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd matrix(rows, columns);
  for (double& entry : matrix.reshaped()) entry = normal(generator);
  return matrix;
}

Linearization MakeLinearization(const Eigen::MatrixXd& jacobian, double squared_residual, bool sigma_is_known) {
  Linearization linearization;
  linearization.jacobian = jacobian;
  linearization.gradient = Eigen::VectorXd::Zero(jacobian.cols());
  linearization.squared_residual = squared_residual;
  linearization.num_measurements = static_cast<int>(jacobian.rows());
  linearization.sigma_is_known = sigma_is_known;
  return linearization;
}

TEST(UncertaintyTest, CovarianceIsTheInverseOfTheNormalMatrix) {
  const std::vector<ParameterBlock> blocks = {Linear("mu", 0.0, 2.0), Log("k_stretch")};
  const Eigen::Vector2d q(0.7, std::log(5.0));
  const Eigen::MatrixXd jacobian = 1e3 * RandomMatrix(52, 2);
  const Eigen::Matrix2d inverse = (jacobian.transpose() * jacobian).inverse();
  // The residual of 50 degrees of freedom: s^2 = 4 from it, s^2 = 1/4 is below what a known sigma promises.
  struct Case {
    double squared_residual;
    bool sigma_is_known;
    double scale;
  };
  for (const Case& c :
       {Case{200.0, true, 2.0}, Case{12.5, true, 1.0}, Case{200.0, false, 2.0}, Case{12.5, false, 0.5}}) {
    const Uncertainty result =
        EstimateUncertainty(blocks, q, MakeLinearization(jacobian, c.squared_residual, c.sigma_is_known));
    EXPECT_NEAR(result.residual_scale, c.scale, 1e-12);
    const double mu_std = std::hypot(c.scale * std::sqrt(inverse(0, 0)), 0.7e-6);
    const double k_std = std::hypot(c.scale * std::sqrt(inverse(1, 1)), 1e-6);
    EXPECT_NEAR(result.parameters[0].std, mu_std, 1e-10 * mu_std);
    EXPECT_NEAR(result.parameters[1].std, 5.0 * k_std, 1e-10 * k_std);
    EXPECT_NEAR(result.parameters[0].lower95, 0.7 - 1.96 * mu_std, 1e-4 * mu_std);
    EXPECT_NEAR(result.parameters[1].upper95, 5.0 * std::exp(1.96 * k_std), 1e-3 * k_std);
    EXPECT_NEAR(result.correlation(0, 1), inverse(0, 1) / std::sqrt(inverse(0, 0) * inverse(1, 1)), 1e-10);
    EXPECT_TRUE(result.all_identifiable(blocks));
    EXPECT_TRUE(result.hidden_directions.empty());
  }
}

TEST(UncertaintyTest, MeasuresTheDistanceToTheMinimumOfTheModel) {
  const std::vector<ParameterBlock> blocks = {Linear("mu", 0.0, 2.0), Log("k_stretch"), Log("drag")};
  Linearization linearization = MakeLinearization(1e2 * RandomMatrix(52, 3), 1.0, true);
  const Eigen::Vector3d step(0.02, -0.03, 0.0);
  linearization.gradient = linearization.jacobian.transpose() * linearization.jacobian * step;
  const Uncertainty result = EstimateUncertainty(blocks, Eigen::Vector3d(0.5, 1.0, 2.0), linearization);
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(result.parameters[i].distance, std::abs(step[i]) / result.parameters[i].coordinate_std, 1e-8) << i;
  }
}

TEST(UncertaintyTest, WithoutNoiseTheIntervalIsTheOptimisersResolution) {
  const std::vector<ParameterBlock> blocks = {Linear("mu", 0.0, 2.0), Log("k_stretch")};
  const Eigen::MatrixXd jacobian = 1e3 * RandomMatrix(52, 2);
  const Uncertainty result =
      EstimateUncertainty(blocks, Eigen::Vector2d(0.5, 1.0), MakeLinearization(jacobian, 1e-20, false));
  EXPECT_NEAR(result.parameters[0].coordinate_std, 0.5e-6, 1e-12);
  EXPECT_NEAR(result.parameters[1].coordinate_std, 1e-6, 1e-12);
}

TEST(UncertaintyTest, IntervalsEndAtTheBounds) {
  const std::vector<ParameterBlock> blocks = {Linear("mu", 0.0, 2.0)};
  const Uncertainty result = EstimateUncertainty(blocks, Eigen::VectorXd::Constant(1, 0.1),
                                                 MakeLinearization(2.0 * Eigen::MatrixXd::Ones(4, 1), 0.0, true));
  EXPECT_TRUE(result.parameters[0].visible);
  EXPECT_TRUE(result.parameters[0].reaches_lower);
  EXPECT_FALSE(result.parameters[0].reaches_upper);
  EXPECT_FALSE(result.parameters[0].identifiable) << "the bound ends its interval, not the recording";
  EXPECT_NEAR(result.parameters[0].std, 0.25, 1e-9);
  EXPECT_EQ(result.parameters[0].lower95, 0.0);
  EXPECT_NEAR(result.parameters[0].upper95, 0.1 + 1.96 * 0.25, 1e-4);
}

// An interval that is hardly narrower than what was believed before: for mu from 0 to 2 a standard deviation of a third
// of 2/sqrt(12) = 0.577, for a stiffness a third of that of a factor of 1e4, although its bounds are a factor of 1e6.
TEST(UncertaintyTest, AnIntervalAsWideAsTheBeliefTellsHardlyAnything) {
  const double mu_limit = 2.0 / std::sqrt(12.0) / 3.0, k_limit = std::log(1e4) / std::sqrt(12.0) / 3.0;
  for (const double factor : {0.99, 1.01}) {
    const std::vector<ParameterBlock> blocks = {Linear("mu", 0.0, 2.0), Log("k_stretch")};
    Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(2, 2);
    jacobian.diagonal() << 1.0 / (factor * mu_limit), 1.0 / (factor * k_limit);
    const Uncertainty result =
        EstimateUncertainty(blocks, Eigen::Vector2d(1.0, 0.0), MakeLinearization(jacobian, 0.0, true));
    for (const ParameterUncertainty& parameter : result.parameters) {
      EXPECT_TRUE(parameter.visible);
      EXPECT_NEAR(parameter.share_of_belief, factor / 3.0, 1e-6);
      EXPECT_EQ(parameter.is_hardly_told(), factor > 1.0);
      EXPECT_EQ(parameter.identifiable, factor < 1.0);
      EXPECT_FALSE(std::isnan(parameter.lower95)) << "that it is wide is the answer";
    }
    EXPECT_NEAR(result.parameters[1].factor, std::exp(2.0 * kNormal95 * factor * k_limit), 1e-3);
  }
}

TEST(UncertaintyTest, AnIntervalFromBoundToBoundTellsNothing) {
  const std::vector<ParameterBlock> blocks = {Linear("mu", 0.9, 1.1)};
  const Uncertainty result = EstimateUncertainty(blocks, Eigen::VectorXd::Ones(1),
                                                 MakeLinearization(Eigen::MatrixXd::Constant(1, 1, 15.0), 0.0, true));
  EXPECT_TRUE(result.parameters[0].visible);
  EXPECT_TRUE(result.parameters[0].is_hardly_told());
  EXPECT_FALSE(result.parameters[0].identifiable);
}

// Of mu and k_stretch, which have standard deviations of 0.01 and 0.02 and no correlation; the model promises its
// minimum so many of them farther on in q of k_stretch, and a cost lower by half the square of that.
Uncertainty StalledBy(double distance) {
  const std::vector<ParameterBlock> blocks = {Linear("mu", 0.0, 2.0), Log("k_stretch")};
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(2, 2);
  jacobian.diagonal() << 100.0, 50.0;
  Linearization linearization = MakeLinearization(jacobian, 0.0, true);
  linearization.gradient = Eigen::Vector2d(0.0, 50.0 * distance);
  return EstimateUncertainty(blocks, Eigen::Vector2d(0.5, 0.0), linearization);
}

TEST(UncertaintyTest, AFitThatStalledFarFromItsMinimumHasNoInterval) {
  for (const double distance : {0.4, 0.5, 1.9, 2.1}) {
    const Uncertainty result = StalledBy(distance);
    EXPECT_NEAR(result.predicted_decrease, 0.5 * distance * distance, 1e-5);
    EXPECT_FALSE(result.parameters[0].stalled) << "it has no part in it";
    EXPECT_TRUE(std::isnan(result.parameters[0].stall_error));
    EXPECT_TRUE(result.parameters[0].identifiable);
    const ParameterUncertainty& k = result.parameters[1];
    EXPECT_EQ(k.stalled, distance > 2.0);
    EXPECT_EQ(k.identifiable, distance < 2.0);
    for (const double value : {k.std, k.lower95, k.upper95}) EXPECT_EQ(std::isnan(value), k.stalled);
    EXPECT_NEAR(k.coordinate_std, 0.02, 1e-6);
  }
}

// k_stretch is 1 at q = 0, so 0.02 of q are 0.02 of it.
TEST(UncertaintyTest, TheDistanceOfAStallIsPartOfTheInterval) {
  EXPECT_TRUE(std::isnan(StalledBy(0.4).parameters[1].stall_error)) << "0.08 s^2 are no stall";
  Uncertainty result = StalledBy(1.5);
  const ParameterUncertainty& k = result.parameters[1];
  EXPECT_NEAR(k.stall_error, 1.5 * 0.02, 1e-6);
  const double half_width = kNormal95 * 0.02 * std::hypot(1.0, 1.5);
  EXPECT_NEAR(std::log(k.upper95), half_width, 1e-6);
  EXPECT_NEAR(std::log(k.lower95), -half_width, 1e-6);
  EXPECT_NEAR(k.total_std(), 0.02 * std::hypot(1.0, 1.5), 1e-6);
  const std::vector<ParameterBlock> blocks = {Linear("mu", 0.0, 2.0), Log("k_stretch")};
  AddMemoryErrors(blocks, Eigen::Vector2d(0.5, 0.0), Eigen::Vector2d(0.0, 0.05), &result);
  EXPECT_NEAR(std::log(k.upper95), std::hypot(half_width, kNormal95 * 0.05), 1e-6) << "errors add up";
}

// Of two parameters that take part alike in no more than the limit each, both have stalled.
TEST(UncertaintyTest, AStallOfSeveralParametersIsSeen) {
  const std::vector<ParameterBlock> blocks = {Linear("mu", 0.0, 2.0), Linear("nu", 0.0, 2.0)};
  Linearization linearization = MakeLinearization(100.0 * Eigen::MatrixXd::Identity(2, 2), 0.0, true);
  for (const double distance : {0.4, 1.5}) {
    linearization.gradient = Eigen::Vector2d::Constant(100.0 * distance);
    const Uncertainty result = EstimateUncertainty(blocks, Eigen::Vector2d(0.5, 0.5), linearization);
    EXPECT_NEAR(result.predicted_decrease, distance * distance, 1e-5);
    for (const ParameterUncertainty& parameter : result.parameters) {
      EXPECT_EQ(parameter.stalled, distance > 1.0) << "the way to the minimum is longer than each of its parts";
      EXPECT_EQ(std::isnan(parameter.stall_error), parameter.stalled);
    }
  }
}

TEST(UncertaintyTest, StepsOfSomeResolutionsAreNoStall) {
  const std::vector<ParameterBlock> blocks = {Log("k_stretch")};
  for (const double resolutions : {1.0, 100.0}) {
    Linearization linearization = MakeLinearization(Eigen::MatrixXd::Constant(4, 1, 1e3), 1e-20, false);
    linearization.gradient = Eigen::VectorXd::Constant(1, 4e6 * resolutions * 1e-6);
    const Uncertainty result = EstimateUncertainty(blocks, Eigen::VectorXd::Zero(1), linearization);
    EXPECT_EQ(std::isnan(result.parameters[0].stall_error) && !result.parameters[0].stalled, resolutions < 10.0);
  }
}

TEST(UncertaintyTest, AParameterWithoutInfluenceSpoilsNoOther) {
  const std::vector<ParameterBlock> blocks = {Linear("mu", 0.0, 2.0), Log("k_stretch")};
  Eigen::MatrixXd jacobian = 100.0 * RandomMatrix(20, 2);
  jacobian.col(0).setZero();
  const Uncertainty result =
      EstimateUncertainty(blocks, Eigen::Vector2d(0.5, 0.0), MakeLinearization(jacobian, 0.0, true));
  EXPECT_FALSE(result.parameters[0].identifiable);
  EXPECT_EQ(result.parameters[0].visible_change, 0.0);
  EXPECT_TRUE(std::isnan(result.parameters[0].std));
  EXPECT_TRUE(result.parameters[1].identifiable);
  EXPECT_NEAR(result.parameters[1].coordinate_std, 1.0 / jacobian.col(1).norm(), 1e-9);
  EXPECT_TRUE(std::isnan(result.correlation(0, 1)));
  ASSERT_EQ(result.hidden_directions.size(), 1u);
  EXPECT_EQ(result.hidden_directions[0].words, "mu");
}

TEST(UncertaintyTest, VisibleChangeIsThatOfTheWholeRange) {
  // mu from 0 to 2 changes the single measurement by 2 a: visible beyond 2 standard deviations, so from a = 1 on.
  const std::vector<ParameterBlock> blocks = {Linear("mu", 0.0, 2.0)};
  for (const double a : {0.99, 1.01}) {
    const Uncertainty result = EstimateUncertainty(blocks, Eigen::VectorXd::Ones(1),
                                                   MakeLinearization(Eigen::MatrixXd::Constant(1, 1, a), 0.0, true));
    EXPECT_NEAR(result.parameters[0].visible_change, 2.0 * a, 1e-12);
    EXPECT_EQ(result.parameters[0].visible, a > 1.0);
  }
}

TEST(UncertaintyTest, UnexplainedResidualsHideWhatIsSmall) {
  const std::vector<ParameterBlock> blocks = {Linear("mu", 0.0, 2.0)};
  const Eigen::MatrixXd jacobian = Eigen::MatrixXd::Constant(101, 1, 0.5);  // moves the prediction by 10
  const auto visible = [&](double scale) {
    return EstimateUncertainty(blocks, Eigen::VectorXd::Ones(1),
                               MakeLinearization(jacobian, 100.0 * scale * scale, true))
        .parameters[0]
        .visible;
  };
  EXPECT_TRUE(visible(4.0));
  EXPECT_FALSE(visible(6.0));
}

// J u = 0 for the common factor of the first three.
TEST(UncertaintyTest, NamesACommonFactor) {
  const std::vector<ParameterBlock> blocks = {Log("k_stretch"), Log("k_bend"), Log("density"), Linear("mu", 0.0, 2.0)};
  Eigen::MatrixXd jacobian = 1e3 * RandomMatrix(30, 4);
  jacobian.col(2) = -jacobian.col(0) - jacobian.col(1);
  const Uncertainty result =
      EstimateUncertainty(blocks, Eigen::Vector4d(0.0, 0.0, 0.0, 1.0), MakeLinearization(jacobian, 0.0, true));
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(result.parameters[i].identifiable) << i;
  EXPECT_TRUE(result.parameters[3].identifiable);
  EXPECT_GT(result.parameters[3].std, 0.0);
  ASSERT_EQ(result.hidden_directions.size(), 1u);
  EXPECT_EQ(result.hidden_directions[0].words, "k_stretch, k_bend and density multiplied by one factor");
  EXPECT_LT((result.hidden_directions[0].coordinates - Eigen::Vector4d(1.0, 1.0, 1.0, 0.0)).norm(), 1e-6);
}

TEST(UncertaintyTest, NamesAnUnevenDirection) {
  const std::vector<ParameterBlock> blocks = {Log("k_stretch"), Log("density")};
  Eigen::MatrixXd jacobian(3, 2);
  jacobian << 1.0, 2.0, 2.0, 4.0, 3.0, 6.0;
  const Uncertainty result =
      EstimateUncertainty(blocks, Eigen::Vector2d::Zero(), MakeLinearization(1e3 * jacobian, 0.0, true));
  ASSERT_EQ(result.hidden_directions.size(), 1u);
  EXPECT_EQ(result.hidden_directions[0].words, "k_stretch times 2 and density times 0.707");
}

TEST(UncertaintyTest, AParameterAtItsBoundIsHeldThere) {
  const std::vector<ParameterBlock> blocks = {Linear("mu", 0.0, 2.0), Log("k_stretch")};
  const Eigen::MatrixXd jacobian = 1e2 * RandomMatrix(10, 2);
  const Uncertainty result =
      EstimateUncertainty(blocks, Eigen::Vector2d(2.0, 0.0), MakeLinearization(jacobian, 0.0, true));
  EXPECT_TRUE(result.parameters[0].at_bound);
  EXPECT_TRUE(result.parameters[0].visible);
  EXPECT_FALSE(result.parameters[0].identifiable) << "the cost still falls beyond";
  EXPECT_TRUE(std::isnan(result.parameters[0].std));
  EXPECT_FALSE(result.parameters[1].at_bound);
  EXPECT_NEAR(result.parameters[1].coordinate_std, 1.0 / jacobian.col(1).norm(), 1e-9);
}

TEST(UncertaintyTest, FrozenParametersAreLeftOut) {
  std::vector<ParameterBlock> blocks = {Log("density"), Log("k_stretch")};
  blocks[0].frozen = true;
  Eigen::MatrixXd jacobian = 1e2 * RandomMatrix(10, 2);
  jacobian.col(0).setZero();
  const Uncertainty result =
      EstimateUncertainty(blocks, Eigen::Vector2d::Zero(), MakeLinearization(jacobian, 0.0, true));
  EXPECT_TRUE(std::isnan(result.parameters[0].std));
  EXPECT_TRUE(result.hidden_directions.empty());
  EXPECT_TRUE(result.all_identifiable(blocks));
  EXPECT_EQ(result.singular_values.size(), 1);
}

// sum = (x + y - 3)/0.1 tells x and y only together; weighing y alone tells both.
struct Sum {
  template <typename T>
  bool operator()(const T* x, const T* y, T* residual) const {
    residual[0] = (*x + *y - 3.0) / 0.1;
    return true;
  }
};
struct Weight {
  template <typename T>
  bool operator()(const T* y, T* residual) const {
    residual[0] = (*y - 1.0) / 0.01;
    return true;
  }
};

TEST(UncertaintyTest, AResidualOfOnesOwnMakesACeresProblemIdentifiable) {
  double x = 2.0, y = 1.0;
  const std::vector<ParameterBlock> blocks = {Linear("x", 0.0, 4.0), Linear("y", 0.0, 4.0)};
  ceres::Problem problem;
  problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Sum, 1, 1, 1>(new Sum), nullptr, &x, &y);
  Uncertainty result = EstimateUncertainty(blocks, Eigen::Vector2d(x, y), Linearize({&x, &y}, 1, true, &problem));
  EXPECT_FALSE(result.all_identifiable(blocks));
  ASSERT_EQ(result.hidden_directions.size(), 1u);
  EXPECT_EQ(result.hidden_directions[0].words, "x plus 0.693 and y minus 0.693");
  problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Weight, 1, 1>(new Weight), nullptr, &y);
  result = EstimateUncertainty(blocks, Eigen::Vector2d(x, y), Linearize({&x, &y}, 2, true, &problem));
  EXPECT_TRUE(result.all_identifiable(blocks));
  EXPECT_NEAR(result.parameters[1].std, 0.01, 1e-9);
  EXPECT_NEAR(result.parameters[0].std, std::hypot(0.1, 0.01), 1e-9);
  EXPECT_NEAR(result.parameters[0].distance, 0.0, 1e-9);
}

}  // namespace
}  // namespace clothid::uncertainty_test
