// Recordings side by side give what they give one after another.
#include "identify/problem/evaluator.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/costs/synthetic_motion.h"

namespace clothid::evaluator_test {
namespace {

// Large enough for CHOLMOD to factor by BLAS.
Scene LargeScene() {
  Scene scene = ClothScene(14, 8);
  scene.handles.nodes = {0, 13};
  return scene;
}

struct Values {
  std::vector<double> costs;
  std::vector<Eigen::VectorXd> gradients;
  int rollouts = 0;
};

Values EvaluateAt(const std::vector<RecordedMotion>& motions, int num_threads) {
  FitOptions options;
  options.parameters = {"k_stretch", "k_bend"};
  const FitProblem problem(motions, options);
  const Eigen::VectorXd start = problem.StartCoordinates();
  FitEvaluator evaluator(&problem, num_threads);
  Values values;
  for (int i = 0; i < 6; ++i) {
    double cost = 0.0;
    const Eigen::VectorXd coordinates = start.array() + 0.1 * i;
    EXPECT_TRUE(evaluator.Evaluate(coordinates, FitEvaluator::Derivative::kRows, &cost, nullptr))
        << evaluator.last_failure();
    values.costs.push_back(cost);
    values.gradients.push_back(evaluator.model().gradient);
  }
  values.rollouts = evaluator.statistics().rollouts;
  return values;
}

TEST(FitEvaluatorTest, FailuresTellWhere) {
  RecordedMotion motion = MakeMotion(SwingScene(), {});
  motion.scene.solver.max_newton_iterations = 1;
  motion.scene.solver.max_substep_halvings = 0;
  FitOptions options;
  options.parameters = {"k_stretch", "drag"};
  const FitProblem problem({motion}, options);
  FitEvaluator evaluator(&problem, 1);
  Eigen::VectorXd coordinates = problem.StartCoordinates();
  double cost = 0.0;
  ASSERT_FALSE(evaluator.Evaluate(coordinates, FitEvaluator::Derivative::kNone, &cost, nullptr));
  EXPECT_NE(evaluator.last_failure().find(", at k_stretch 50, drag 0.1"), std::string::npos)
      << evaluator.last_failure();
  coordinates[0] = std::log(2e5);
  ASSERT_FALSE(evaluator.Evaluate(coordinates, FitEvaluator::Derivative::kNone, &cost, nullptr));
  EXPECT_NE(
      evaluator.last_failure().find(", at k_stretch 2e+05 N/m (6.54 to 4070 N/m were measured of cloth), drag 0.1"),
      std::string::npos)
      << evaluator.last_failure();
}

TEST(FitEvaluatorTest, ThreadsDoNotChangeTheNumbers) {
  MotionOptions options;
  options.true_values = {{"k_stretch", 150.0}};
  const std::vector<RecordedMotion> motions = {MakeMotion(LargeScene(), options), MakeMotion(LargeScene(), {})};
  const Values one = EvaluateAt(motions, 1);
  for (int repeat = 0; repeat < 3; ++repeat) {
    const Values two = EvaluateAt(motions, 2);
    EXPECT_EQ(two.rollouts, one.rollouts);
    for (std::size_t i = 0; i < one.costs.size(); ++i) {
      EXPECT_EQ(two.costs[i], one.costs[i]);
      EXPECT_EQ(two.gradients[i], one.gradients[i]);
    }
  }
}

TEST(FitEvaluatorTest, KeepsTheBestPoint) {
  const FitProblem problem({MakeMotion(LargeScene(), {})}, {});
  const Eigen::VectorXd start = problem.StartCoordinates();
  FitEvaluator evaluator(&problem, 1);
  EXPECT_FALSE(evaluator.best().is_valid());
  double cost = 0.0;
  for (double shift : {0.3, 0.1, 0.2}) {
    ASSERT_TRUE(evaluator.Evaluate(start.array() + shift, FitEvaluator::Derivative::kNone, &cost, nullptr));
  }
  EXPECT_EQ(evaluator.first().coordinates[0], start[0] + 0.3);
  EXPECT_EQ(evaluator.best().coordinates[0], start[0] + 0.1);
  EXPECT_LT(evaluator.best().cost, evaluator.first().cost);
  EXPECT_FALSE(evaluator.Evaluate(start.array() + 1e4, FitEvaluator::Derivative::kNone, &cost, nullptr));
  EXPECT_FALSE(evaluator.last_failure().empty());
  EXPECT_EQ(evaluator.best().coordinates[0], start[0] + 0.1);
}

}  // namespace
}  // namespace clothid::evaluator_test
