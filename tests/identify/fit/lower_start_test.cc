// The end of a fit has no higher cost than its start, at full precision, though loose stages, whose costs are biased,
// have led in between.
#include <gtest/gtest.h>

#include "identify/fit/fit.h"
#include "identify/problem/evaluator.h"
#include "tests/identify/simulated_recordings.h"

namespace clothid::lower_start_test {
namespace {

// A sheet that swings from two corners, after it was let go near their height: its cost is rough.
RecordedMotion RoughSwing(double noise) {
  SyntheticOptions options;
  options.noise_sigma = noise;
  return AsFitted(SimulatedText(
      R"({"clothid_scene": 2, "time_step": 0.01, "duration": 0.8,
          "mesh": {"grid": {"nodes": [5, 6], "size": [0.2, 0.3], "origin": [0, 0, 0.5],
                            "axes": [[1, 0, 0], [0, 0.6, 0.8]]}},
          "handles": [0, 4], "materials": {"density": 0.15, "k_stretch": 30, "k_bend": 1e-5}})",
      options));
}

double CostAt(const FitProblem& problem, const Eigen::VectorXd& coordinates) {
  FitEvaluator evaluator(&problem, 1);
  double cost = 0.0;
  EXPECT_TRUE(evaluator.Evaluate(coordinates, FitEvaluator::Derivative::kNone, &cost, nullptr));
  return cost;
}

TEST(LowerStartTest, AFitEndsNoHigherThanItsStart) {
  for (const double noise : {0.0, 1e-3}) {
    const RecordedMotion motion = RoughSwing(noise);
    const std::vector<RecordedMotion> motions = {motion};
    for (const double start : {30.0, 30.02, 29.9, 33.0}) {
      SCOPED_TRACE(std::to_string(noise) + " m, from " + std::to_string(start));
      FitOptions options;
      options.parameters = {"k_stretch"};
      options.overrides.start["k_stretch"] = start;
      options.estimate_uncertainty = false;
      FitProblem problem(motions, options);
      const FitSummary summary = Fit(options, &problem, &motions);
      ASSERT_TRUE(summary.has_estimate()) << summary.message;
      EXPECT_DOUBLE_EQ(summary.cost, CostAt(problem, summary.coordinates));
      EXPECT_LE(summary.cost, CostAt(problem, problem.StartCoordinates()));
      EXPECT_LE(summary.error.rmse(), summary.start_error.rmse() * (1.0 + 1e-6));
    }
  }
}

// Rounds that ended elsewhere are told in the plan, and start and end are of one precision where they are near.
TEST(LowerStartTest, TheStartIsToldAsTheEndIs) {
  const std::vector<RecordedMotion> motions = {RoughSwing(1e-3)};
  FitOptions options;
  options.parameters = {"k_stretch"};
  options.estimate_uncertainty = false;
  FitProblem problem(motions, options);
  const FitSummary adaptive = Fit(options, &problem, &motions);
  options.precision = FitPrecision::kFull;
  FitProblem full_problem(motions, options);
  const FitSummary full = Fit(options, &full_problem, nullptr);
  EXPECT_EQ(adaptive.start_error.rmse(), full.start_error.rmse());
}

}  // namespace
}  // namespace clothid::lower_start_test
