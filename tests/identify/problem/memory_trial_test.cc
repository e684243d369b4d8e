// What trials with a memory say of themselves.
#include "identify/problem/memory_trial.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "identify/problem/evaluator.h"
#include "sim/mesh/mesh.h"
#include "tests/costs/synthetic_motion.h"

namespace clothid::memory_trial_test {
namespace {

// A parameter that moves every coordinate by `moved` times the size of the cloth, in standard deviations.
QuadraticModel MovedBy(double moved, const FitProblem& problem) {
  const Observation& observation = problem.cost(0).model().observation();
  double square = 0.0;
  for (int row = 0; row < observation.first_force_row(); ++row) {
    square += std::pow(moved * ClothSize(problem.cost(0).model().scene().mesh) / observation.SigmaOf(row), 2);
  }
  QuadraticModel model;
  model.hessian = Eigen::Vector2d(square, 0.0).asDiagonal();
  return model;
}

TEST(MemoryTrialTest, ADerivativeBeyondTheClothIsLost) {
  const FitProblem problem({MakeMotion(SphereScene(), {})}, {});
  EXPECT_FALSE(AmplifiesBeyondTheCloth(problem, QuadraticModel())) << "nobody knows";
  EXPECT_FALSE(AmplifiesBeyondTheCloth(problem, MovedBy(0.99 * kMostMoved, problem)));
  EXPECT_TRUE(AmplifiesBeyondTheCloth(problem, MovedBy(1.01 * kMostMoved, problem)));
  EXPECT_TRUE(AmplifiesBeyondTheCloth(problem, MovedBy(std::numeric_limits<double>::quiet_NaN(), problem)));
  FitEvaluator evaluator(&problem, 1);
  double cost = 0.0;
  ASSERT_TRUE(evaluator.Evaluate(problem.StartCoordinates(), FitEvaluator::Derivative::kRows, &cost, nullptr));
  EXPECT_FALSE(AmplifiesBeyondTheCloth(problem, evaluator.model())) << "that of a cloth that falls on a ball";
}

}  // namespace
}  // namespace clothid::memory_trial_test
