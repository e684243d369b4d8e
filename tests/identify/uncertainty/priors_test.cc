// What is believed beforehand and what is measured, together: problems whose answer is known.
#include "identify/uncertainty/priors.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <random>

#include "identify/uncertainty/uncertainty.h"

namespace clothid::priors_test {
namespace {

ParameterBlock Log(const std::string& name, double median = std::nan(""), double factor = std::nan("")) {
  ParameterBlock block;
  block.name = name;
  block.scale = ParameterScale::kLog;
  block.start = 1.0;
  block.lower_bound = 1e-4;
  block.upper_bound = 1e4;
  block.prior = {median, factor};
  return block;
}

ParameterBlock Friction(double mean = std::nan(""), double std = std::nan("")) {
  ParameterBlock block;
  block.name = "mu";
  block.start = 0.5;
  block.upper_bound = 2.0;
  block.prior = {mean, std};
  return block;
}

Eigen::MatrixXd RandomMatrix(int rows, int columns) {
  std::mt19937_64 generator(5);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd matrix(rows, columns);
  for (double& entry : matrix.reshaped()) entry = normal(generator);
  return matrix;
}

// Of measurements with sigma known, at q; residuals with the standard deviation `scale`.
Linearization Measured(const Eigen::MatrixXd& jacobian, double scale, const Eigen::VectorXd& gradient) {
  Linearization linearization;
  linearization.jacobian = jacobian;
  linearization.gradient = gradient;
  linearization.num_measurements = 1000;
  linearization.squared_residual = scale * scale * static_cast<double>(1000 - jacobian.cols());
  return linearization;
}

TEST(PriorsTest, CostHasItsGradientAndCurvature) {
  std::vector<ParameterBlock> blocks = {Log("k_bend", 1e-2, 2.0), Log("drag"), Friction(0.3, 0.1)};
  blocks[2].frozen = true;
  const Eigen::Vector3d q(std::log(3e-2), 0.4, 0.65);
  EXPECT_NEAR(PriorCost(blocks, q), 0.5 * std::pow(std::log(3.0) / std::log(2.0), 2) + 0.5 * 3.5 * 3.5, 1e-12);
  const double step = 1e-4;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d move = step * Eigen::Vector3d::Unit(i);
    const double above = PriorCost(blocks, q + move), below = PriorCost(blocks, q - move);
    EXPECT_NEAR(PriorGradient(blocks, q)[i], (above - below) / (2.0 * step), 1e-7) << i;
    EXPECT_NEAR(PriorPrecisions(blocks)[i], (above - 2.0 * PriorCost(blocks, q) + below) / (step * step), 1e-4) << i;
  }
  EXPECT_EQ(PriorPrecisions(blocks)[1], 0.0);
  const Eigen::MatrixXd rows = WithPriorRows(blocks, Eigen::MatrixXd::Zero(0, 3), 1.0);
  EXPECT_LT(((rows.transpose() * rows).diagonal() - PriorPrecisions(blocks)).norm(), 1e-12);
}

// Three knots of a wind, each linked to the one before, and a parameter of another kind.
std::vector<ParameterBlock> LinkedBlocks() {
  std::vector<ParameterBlock> blocks(4);
  for (int i = 0; i < 4; ++i) {
    blocks[i].name = i < 3 ? "wind.y." + std::to_string(i + 1) : "wind.shear.x";
    blocks[i].is_signed = true;
    blocks[i].unit = 10.0;
    blocks[i].lower_bound = -10.0;
    blocks[i].upper_bound = 10.0;
    if (i == 0 || i == 3) continue;
    blocks[i].linked_to = i - 1;
    blocks[i].link_spread = 0.5 * i;
  }
  return blocks;
}

TEST(PriorsTest, RowsOfLinksLeaveOtherUnknownsAlone) {
  const std::vector<ParameterBlock> blocks = LinkedBlocks();
  const Eigen::MatrixXd rows = WithPriorRows(blocks, Eigen::MatrixXd::Ones(1, 7), 1.0);
  ASSERT_EQ(rows.rows(), 3);
  EXPECT_EQ(rows.bottomLeftCorner(2, 4), LinkRows(blocks));
  EXPECT_EQ(rows.bottomRightCorner(2, 3), Eigen::MatrixXd::Zero(2, 3));
}

TEST(PriorsTest, LinksHaveTheirGradientAndCurvature) {
  const std::vector<ParameterBlock> blocks = LinkedBlocks();
  EXPECT_TRUE(HasLinks(blocks));
  EXPECT_FALSE(HasPriors(blocks));
  EXPECT_TRUE(IsKnot(blocks, 0) && IsKnot(blocks, 2) && !IsKnot(blocks, 3));
  const Eigen::Vector4d q(0.1, 0.15, -0.05, 0.3);
  EXPECT_NEAR(PriorCost(blocks, q), 0.5 * (std::pow(0.5 / 0.5, 2) + std::pow(-2.0 / 1.0, 2)), 1e-12);
  const double step = 1e-4;
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector4d move = step * Eigen::Vector4d::Unit(i);
    EXPECT_NEAR(PriorGradient(blocks, q)[i], (PriorCost(blocks, q + move) - PriorCost(blocks, q - move)) / (2.0 * step),
                1e-6);
    const Eigen::VectorXd change = PriorGradient(blocks, q + move) - PriorGradient(blocks, q - move);
    EXPECT_LT((PriorHessian(blocks).col(i) - change / (2.0 * step)).norm(), 1e-6);
  }
}

// Rows for links count as measurements do: the covariance is s^2 (J^T J + L^T L)^-1.
TEST(PriorsTest, LinksAreAsSureAsTheMeasurements) {
  const std::vector<ParameterBlock> blocks = LinkedBlocks();
  const Eigen::MatrixXd jacobian = 50.0 * RandomMatrix(6, 4), links = LinkRows(blocks);
  const Eigen::MatrixXd inverse = (jacobian.transpose() * jacobian + links.transpose() * links).inverse();
  const Posterior posterior(blocks, jacobian, {0, 1, 2, 3});
  const Eigen::MatrixXd part = inverse * links.transpose() * links * inverse;
  for (int i = 0; i < 4; ++i) {
    EXPECT_NEAR(posterior.Covariance(i, i, 3.0), 9.0 * inverse(i, i), 1e-10 * inverse(i, i));
    EXPECT_NEAR(posterior.LinkPart(i, i), part(i, i), 1e-10 * part.norm());
  }
  const Eigen::Vector4d q = Eigen::Vector4d::Zero();
  const Uncertainty uncertainty = EstimateUncertainty(blocks, q, Measured(jacobian, 2.0, Eigen::Vector4d::Zero()));
  for (int i = 0; i < 4; ++i) {
    EXPECT_NEAR(uncertainty.parameters[i].coordinate_std, 2.0 * std::sqrt(inverse(i, i)), 1e-6);
    EXPECT_TRUE(uncertainty.parameters[i].visible);
  }
}

TEST(PriorsTest, AKnotIsSeenByWhatIsLeftWithoutItsOwnLinks) {
  const std::vector<ParameterBlock> blocks = LinkedBlocks();
  Eigen::MatrixXd jacobian = 0.3 * RandomMatrix(6, 4);
  const ScaledJacobian all(blocks, WithPriorRows(blocks, jacobian, 1.0), {0, 1, 2, 3});
  for (int i = 0; i < 3; ++i) {
    std::vector<ParameterBlock> others = blocks;
    for (int j = 1; j < 3; ++j) {
      if (j == i || blocks[j].linked_to == i) others[j].linked_to = kNoBlock;
    }
    const ScaledJacobian left(blocks, WithPriorRows(others, jacobian, 1.0), {0, 1, 2, 3});
    EXPECT_NEAR(VisibleWithoutLinks(blocks, all, i), left.VisibleChange(i), 1e-8) << i;
  }
  jacobian.col(2).setZero();  // after the last frame
  jacobian *= 300.0;
  const Uncertainty uncertainty =
      EstimateUncertainty(blocks, Eigen::Vector4d::Zero(), Measured(jacobian, 1.0, Eigen::Vector4d::Zero()));
  EXPECT_TRUE(uncertainty.parameters[1].identifiable);
  EXPECT_FALSE(uncertainty.parameters[2].visible);
  EXPECT_FALSE(uncertainty.parameters[2].identifiable);
  EXPECT_NEAR(uncertainty.parameters[2].coordinate_std,
              std::hypot(uncertainty.parameters[1].coordinate_std, blocks[2].LinkStd()), 1e-4);
}

TEST(PriorsTest, PrecisionsAddUp) {
  const std::vector<ParameterBlock> blocks = {Log("k_bend", 2.0, 1.1), Log("k_stretch")};
  const Eigen::MatrixXd jacobian = 5.0 * RandomMatrix(40, 2);
  Eigen::Matrix2d precision = jacobian.transpose() * jacobian, prior = Eigen::Matrix2d::Zero();
  prior(0, 0) = std::pow(std::log(1.1), -2);
  const Eigen::Matrix2d inverse = (precision + prior).inverse();
  const Eigen::Vector2d q(std::log(2.0), 0.3);
  for (const double scale : {1.0, 3.0}) {
    const Uncertainty result = EstimateUncertainty(blocks, q, Measured(jacobian, scale, Eigen::Vector2d::Zero()));
    EXPECT_NEAR(result.residual_scale, scale, 1e-12);
    const Eigen::Matrix2d covariance = inverse * (scale * scale * precision + prior) * inverse;
    if (scale == 1.0) {
      EXPECT_LT((covariance - inverse).norm(), 1e-12);
    }
    for (int i = 0; i < 2; ++i) {
      const ParameterUncertainty& parameter = result.parameters[i];
      EXPECT_NEAR(parameter.coordinate_std, std::sqrt(covariance(i, i)), 1e-8);
      // The rise of twice the cost where it goes off by one standard deviation.
      EXPECT_NEAR(std::pow(parameter.cost_scale, 2), covariance(i, i) / inverse(i, i), 1e-9);
    }
    EXPECT_NEAR(result.correlation(0, 1), covariance(0, 1) / std::sqrt(covariance(0, 0) * covariance(1, 1)), 1e-9);
    ASSERT_TRUE(result.parameters[0].beside_prior);
    EXPECT_FALSE(result.parameters[1].beside_prior);
    const Eigen::Matrix2d alone = scale * scale * precision.inverse();
    EXPECT_NEAR(result.parameters[0].beside_prior->other_std, std::sqrt(alone(0, 0)), 1e-9);
    EXPECT_TRUE(result.parameters[0].identifiable) << "the recording alone tells it";
  }
}

TEST(PriorsTest, MeasuresTheContradictionBetweenPriorAndRecording) {
  const double believed = std::log(2.0), measured = std::log(3.0), prior_std = std::log(1.2), std = 0.04;
  const std::vector<ParameterBlock> blocks = {Log("k_bend", 2.0, 1.2)};
  const double p = std::pow(prior_std, -2), d = std::pow(std, -2);
  const double estimate = (p * believed + d * measured) / (p + d);
  const Linearization linearization = Measured(Eigen::MatrixXd::Constant(1, 1, 1.0 / std), 1.0,
                                               Eigen::VectorXd::Constant(1, d * (estimate - measured)));
  const Uncertainty result = EstimateUncertainty(blocks, Eigen::VectorXd::Constant(1, estimate), linearization);
  const ToldBesidePrior& told = result.parameters[0].beside_prior.value();
  EXPECT_NEAR(told.other_value, 3.0, 1e-9);
  EXPECT_NEAR(told.other_std, std, 1e-9);
  EXPECT_NEAR(told.disagreement, (measured - believed) / std::hypot(prior_std, std), 1e-9);
  EXPECT_FALSE(told.disagrees());
  EXPECT_NEAR(told.share, std::sqrt(p / (p + d)), 1e-6);
  EXPECT_FALSE(told.adds_nothing());
  EXPECT_NEAR(result.predicted_decrease, 0.0, 1e-12) << "the estimate is where the whole cost is least";
}

TEST(PriorsTest, WhatOnlyThePriorKnowsIsNotIdentifiable) {
  const std::vector<ParameterBlock> blocks = {Friction(0.3, 0.05), Log("k_stretch")};
  Eigen::MatrixXd jacobian = 10.0 * RandomMatrix(30, 2);
  jacobian.col(0).setZero();
  const Uncertainty result =
      EstimateUncertainty(blocks, Eigen::Vector2d(0.3, 0.0), Measured(jacobian, 1.0, Eigen::Vector2d::Zero()));
  const ParameterUncertainty& mu = result.parameters[0];
  EXPECT_FALSE(mu.visible);
  EXPECT_FALSE(mu.identifiable) << "however narrow the prior is";
  EXPECT_FALSE(mu.is_hardly_told());
  EXPECT_NEAR(mu.std, 0.05, 1e-9);
  EXPECT_NEAR(mu.lower95, 0.3 - kNormal95 * 0.05, 1e-9);
  EXPECT_TRUE(mu.beside_prior->adds_nothing());
  EXPECT_EQ(mu.beside_prior->disagreement, 0.0);
  EXPECT_TRUE(result.parameters[1].identifiable);
  EXPECT_TRUE(result.hidden_directions.empty());
}

TEST(PriorsTest, WhatIsBelievedOfOneTellsTheOther) {
  // Only the ratio of the two is seen.
  Eigen::MatrixXd jacobian = 20.0 * RandomMatrix(30, 2);
  jacobian.col(1) = -jacobian.col(0);
  const auto estimate = [&](const std::vector<ParameterBlock>& blocks) {
    return EstimateUncertainty(blocks, Eigen::Vector2d::Zero(), Measured(jacobian, 1.0, Eigen::Vector2d::Zero()));
  };
  const Uncertainty unknown = estimate({Log("density"), Log("k_stretch")});
  EXPECT_FALSE(unknown.parameters[0].identifiable);
  EXPECT_FALSE(unknown.parameters[1].identifiable);
  EXPECT_EQ(unknown.hidden_directions.size(), 1u);
  const Uncertainty known = estimate({Log("density", 1.0, 1.1), Log("k_stretch")});
  EXPECT_TRUE(known.hidden_directions.empty());
  EXPECT_FALSE(known.parameters[0].identifiable);
  EXPECT_TRUE(known.parameters[0].beside_prior->adds_nothing());
  EXPECT_TRUE(known.parameters[1].identifiable);
  EXPECT_NEAR(known.parameters[1].coordinate_std, std::hypot(std::log(1.1), 1.0 / jacobian.col(0).norm()), 1e-6);
  const Uncertainty vague = estimate({Log("density", 1.0, 100.0), Log("k_stretch")});
  EXPECT_FALSE(vague.parameters[1].identifiable) << "the prior of the density says too little";
}

}  // namespace
}  // namespace clothid::priors_test
