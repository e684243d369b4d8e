// Errors and orders from estimates at several steps, and intervals with them.
#include "identify/uncertainty/discretization_error.h"

#include <gtest/gtest.h>

#include <cmath>

namespace clothid::discretization_error_test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// Estimates that are off by `error` at the step and by 2^-order of it at half of it.
DiscretizationError OfOrder(double order, double error) {
  const double truth = 0.3, ratio = std::exp2(order);
  return ErrorOfStep(truth + error, truth + error / ratio, truth + error * ratio);
}

TEST(DiscretizationErrorTest, FindsOrderAndErrorBetweenFirstAndSecondOrder) {
  for (const double order : {1.001, 1.3, 1.999}) {
    for (const double error : {-0.02, 1e-5}) {
      const DiscretizationError found = OfOrder(order, error);
      EXPECT_NEAR(found.order, order, 1e-6);
      EXPECT_NEAR(found.error, std::abs(error), 1e-9 * std::abs(error) + 1e-15);
    }
  }
}

TEST(DiscretizationErrorTest, TakesTheMostWhereThereIsNoClearOrder) {
  const auto expect_unclear = [](const DiscretizationError& found) {
    EXPECT_TRUE(std::isnan(found.order));
    EXPECT_NEAR(found.error, 0.02, 1e-15) << "twice the difference";
  };
  expect_unclear(ErrorOfStep(0.31, 0.30, kNaN));   // not fitted at twice the step
  expect_unclear(ErrorOfStep(0.31, 0.30, 0.29));   // it turns
  expect_unclear(ErrorOfStep(0.31, 0.30, 0.315));  // order -1
  expect_unclear(ErrorOfStep(0.31, 0.30, 0.39));   // order 3
  EXPECT_TRUE(std::isnan(ErrorOfStep(0.31, kNaN, 0.39).error)) << "without a fit at half the step nothing is known";
  EXPECT_EQ(ErrorOfStep(0.3, 0.3, 0.3).error, 0.0);
  EXPECT_NEAR(ErrorOfMesh(0.31, 0.30).error, 0.02, 1e-15);
  EXPECT_TRUE(std::isnan(ErrorOfMesh(0.31, kNaN).error));
}

ParameterBlock Block(ParameterScale scale, double lower, double upper) {
  ParameterBlock block;
  block.scale = scale;
  block.lower_bound = lower;
  block.upper_bound = upper;
  return block;
}

// Of mu = 0.3 +- 0.01 and k = 50 +- 2 %.
struct Example {
  std::vector<ParameterBlock> blocks = {Block(ParameterScale::kLinear, 0.0, 2.0),
                                        Block(ParameterScale::kLog, 1.0, 1e4)};
  Eigen::VectorXd coordinates = Eigen::Vector2d(0.3, std::log(50.0));
  Uncertainty uncertainty;

  Example() {
    uncertainty.parameters.resize(2);
    const double stds[2] = {0.01, 0.02};
    for (int i = 0; i < 2; ++i) {
      ParameterUncertainty& parameter = uncertainty.parameters[i];
      parameter.visible = true;
      parameter.coordinate_std = stds[i];
      parameter.std = stds[i] * blocks[i].ValueDerivative(coordinates[i]);
    }
  }

  void Add(const std::vector<DiscretizationError>& step, const std::vector<DiscretizationError>& mesh) {
    AddDiscretizationErrors(blocks, coordinates, step, mesh, &uncertainty);
  }
};

TEST(DiscretizationErrorTest, WidensIntervalsByTheRootOfSquares) {
  Example example;
  example.Add({{0.03, 1.5}, {0.01, kNaN}}, {{0.02, kNaN}, {0.03, kNaN}});
  const ParameterUncertainty& mu = example.uncertainty.parameters[0];
  EXPECT_EQ(mu.std, 0.01) << "that of the noise";
  EXPECT_EQ(mu.step_error, 0.03);
  EXPECT_EQ(mu.step_order, 1.5);
  EXPECT_EQ(mu.mesh_error, 0.02);
  EXPECT_NEAR(mu.total_std(), std::sqrt(0.0014), 1e-15);
  EXPECT_NEAR(mu.lower95, 0.3 - kNormal95 * std::sqrt(0.0014), 1e-15);
  EXPECT_NEAR(mu.upper95, 0.3 + kNormal95 * std::sqrt(0.0014), 1e-15);
  EXPECT_TRUE(mu.identifiable);
  const ParameterUncertainty& k = example.uncertainty.parameters[1];
  EXPECT_NEAR(k.step_error, 0.5, 1e-14) << "in N/m";
  EXPECT_NEAR(k.mesh_error, 1.5, 1e-14);
  EXPECT_NEAR(k.upper95, 50.0 * std::exp(kNormal95 * std::sqrt(0.0014)), 1e-12);
  EXPECT_NEAR(k.factor, std::exp(2.0 * kNormal95 * std::sqrt(0.0014)), 1e-12);
}

TEST(DiscretizationErrorTest, WhatIsNotKnownLeavesTheIntervalToTheOthers) {
  Example example;
  example.uncertainty.quantile95 = 2.5;  // Student's t of correlated residuals
  example.Add({{kNaN, kNaN}, {kNaN, kNaN}}, {});
  const ParameterUncertainty& mu = example.uncertainty.parameters[0];
  EXPECT_NEAR(mu.upper95, 0.325, 1e-15);
  EXPECT_TRUE(std::isnan(mu.step_error));
  EXPECT_TRUE(std::isnan(mu.mesh_error));
  EXPECT_EQ(mu.total_std(), 0.01);
}

// What is said of an interval is said of the one that is shown.
TEST(DiscretizationErrorTest, JudgesTheWidenedInterval) {
  Example example;
  example.Add({{0.2, kNaN}, {3.0, kNaN}}, {});
  const ParameterUncertainty& mu = example.uncertainty.parameters[0];
  EXPECT_EQ(mu.lower95, 0.0);
  EXPECT_TRUE(mu.reaches_lower);
  EXPECT_FALSE(mu.identifiable);
  EXPECT_TRUE(example.uncertainty.parameters[1].is_hardly_told());
}

// An error that nobody asked for widens the interval alone, also beside one of the mesh that was asked for.
TEST(DiscretizationErrorTest, JudgesWithoutErrorsThatAreOnlyEstimated) {
  Example example;
  example.Add({}, {});
  const Uncertainty noise = example.uncertainty;
  const std::vector<DiscretizationError> step = {{0.2, 1.3}, {3.0, kNaN}};
  AddEstimatedStepErrors(example.blocks, example.coordinates, step, &example.uncertainty);
  const ParameterUncertainty& mu = example.uncertainty.parameters[0];
  EXPECT_EQ(mu.step_error, 0.2);
  EXPECT_EQ(mu.step_order, 1.3);
  EXPECT_EQ(mu.lower95, 0.0);
  EXPECT_NEAR(mu.upper95, 0.3 + kNormal95 * std::hypot(0.01, 0.2), 1e-15);
  EXPECT_NEAR(example.uncertainty.parameters[1].step_error, 150.0, 1e-12) << "in N/m";
  const auto expect_judged_as = [&](const Uncertainty& expected) {
    for (std::size_t i = 0; i < 2; ++i) {
      const ParameterUncertainty &own = example.uncertainty.parameters[i], &other = expected.parameters[i];
      EXPECT_TRUE(own.identifiable);
      EXPECT_FALSE(own.reaches_lower || own.reaches_upper);
      EXPECT_EQ(own.share_of_belief, other.share_of_belief);
    }
  };
  expect_judged_as(noise);

  const std::vector<DiscretizationError> mesh = {{0.02, kNaN}, {0.03, kNaN}};
  Example of_mesh;
  of_mesh.Add({}, mesh);
  example.Add({}, mesh);
  EXPECT_NEAR(mu.upper95, 0.3 + kNormal95 * std::hypot(0.01, 0.2, 0.02), 1e-15);
  expect_judged_as(of_mesh.uncertainty);

  example.uncertainty.parameters[0].stalled = true;
  example.Add({}, {});
  AddEstimatedStepErrors(example.blocks, example.coordinates, step, &example.uncertainty);
  EXPECT_TRUE(std::isnan(mu.upper95));
}

TEST(DiscretizationErrorTest, GivesNoIntervalToWhatHadNone) {
  Example example;
  example.uncertainty.parameters[0] = ParameterUncertainty();  // not visible
  example.uncertainty.parameters[1].stalled = true;
  example.Add({{0.03, 1.5}, {0.01, kNaN}}, {});
  for (const ParameterUncertainty& parameter : example.uncertainty.parameters) {
    EXPECT_TRUE(std::isnan(parameter.lower95));
    EXPECT_TRUE(std::isnan(parameter.total_std()));
    EXPECT_FALSE(parameter.identifiable);
  }
}

}  // namespace
}  // namespace clothid::discretization_error_test
