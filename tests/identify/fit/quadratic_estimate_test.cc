// Fits of a rough cost take estimate and interval from a quadratic.
#include "identify/fit/quadratic_estimate.h"

#include <gtest/gtest.h>

#include <cmath>

#include "identify/fit/fit.h"
#include "identify/report/result_json.h"
#include "sim/scene/scene_json.h"
#include "tests/costs/synthetic_motion.h"

namespace clothid::quadratic_estimate_test {
namespace {

FitOptions Options(const std::vector<std::string>& parameters) {
  FitOptions options;
  options.parameters = parameters;
  options.jacobian = JacobianMethod::kSensitivity;
  options.weighs_model_error = false;
  return options;
}

RecordedMotion NoisySwing() {
  MotionOptions options;
  options.true_values = {{"k_stretch", 150.0}, {"drag", 0.1}};
  options.noise = options.sigma = 1e-3;
  return MakeMotion(SwingScene(), options);
}

// As if a kink had held it: a fit that calls itself converged, so many standard deviations beside its minimum.
FitSummary Stalled(const FitSummary& fit, double stds, FitOptions options, FitProblem* problem) {
  options.max_iterations = 0;
  options.precision = FitPrecision::kFull;
  const Eigen::VectorXd start = problem->StartCoordinates();
  Eigen::VectorXd beside = fit.coordinates;
  beside[0] += stds * fit.uncertainty->parameters[0].coordinate_std;
  problem->SetStart(beside);
  FitSummary stalled = Fit(options, problem);
  problem->SetStart(start);
  stalled.status = FitStatus::kConverged;
  return stalled;
}

void ExpectSeesMinimum(const std::vector<std::string>& parameters, int num_points) {
  const FitOptions options = Options(parameters);
  FitProblem problem({NoisySwing()}, options);
  const FitSummary good = Fit(options, &problem);
  ASSERT_EQ(good.status, FitStatus::kConverged) << good.message;
  EXPECT_FALSE(good.quadratic.has_value());
  FitSummary summary = Stalled(good, 4.0, options, &problem);
  ASSERT_TRUE(summary.uncertainty->parameters[0].stalled);
  const FitSummary before = summary;
  EstimateFromQuadratic(options, problem, &summary);
  ASSERT_TRUE(summary.quadratic.has_value());
  EXPECT_TRUE(summary.quadratic->is_accepted) << summary.quadratic->explained;
  EXPECT_EQ(summary.quadratic->num_points, num_points);
  EXPECT_LE(summary.quadratic->num_evaluations, kMostQuadraticEvaluations);
  EXPECT_GT(summary.quadratic->explained, 0.999);
  EXPECT_EQ(summary.uncertainty->predicted_decrease, 0.0);
  EXPECT_FALSE(summary.interval_check.has_value());
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const ParameterUncertainty& own = summary.uncertainty->parameters[i];
    const ParameterUncertainty& of_fit = good.uncertainty->parameters[i];
    const double truth = parameters[i] == "drag" ? 0.1 : 150.0;
    EXPECT_FALSE(own.stalled);
    EXPECT_NEAR(summary.coordinates[i], good.coordinates[i], 0.2 * of_fit.coordinate_std) << parameters[i];
    EXPECT_NEAR(own.coordinate_std, of_fit.coordinate_std, 0.2 * of_fit.coordinate_std) << parameters[i];
    EXPECT_LT(own.lower95, truth) << parameters[i];
    EXPECT_GT(own.upper95, truth) << parameters[i];
    EXPECT_EQ(summary.parameters[i].start, before.parameters[i].start);
  }
  // All that is said is of the new point.
  ASSERT_EQ(summary.parameters.size(), parameters.size());
  EXPECT_NEAR(summary.cost, good.cost, 0.05);
  EXPECT_LT(summary.cost, before.cost);
  EXPECT_EQ(summary.iterations.back().cost, summary.cost);
  EXPECT_NE(summary.predicted[0], before.predicted[0]);
  EXPECT_EQ(summary.start_predicted[0], before.start_predicted[0]);
  EXPECT_GT(summary.statistics.rollouts, before.statistics.rollouts);
  EXPECT_NE(ResultJson(summary, {}, {NoisySwing()}).find("\"quadratic\""), std::string::npos);
}

TEST(QuadraticEstimateTest, SeesTheMinimumOfOneParameter) { ExpectSeesMinimum({"k_stretch"}, 6); }
TEST(QuadraticEstimateTest, SeesTheMinimumOfTwo) { ExpectSeesMinimum({"k_stretch", "drag"}, 8); }

TEST(QuadraticEstimateTest, IsTheSameOnAnyNumberOfThreads) {
  std::vector<FitSummary> summaries;
  for (const int num_threads : {1, 3}) {
    FitOptions options = Options({"k_stretch"});
    options.num_threads = num_threads;
    FitProblem problem({NoisySwing(), NoisySwing()}, options);
    const FitSummary good = Fit(options, &problem);
    summaries.push_back(Stalled(good, 4.0, options, &problem));
    EstimateFromQuadratic(options, problem, &summaries.back());
    EXPECT_TRUE(summaries.back().quadratic && summaries.back().quadratic->is_accepted);
  }
  EXPECT_EQ(summaries[0].coordinates, summaries[1].coordinates);
  EXPECT_EQ(summaries[0].uncertainty->parameters[0].upper95, summaries[1].uncertainty->parameters[0].upper95);
  EXPECT_EQ(summaries[0].quadratic->explained, summaries[1].quadratic->explained);
}

// A sheet that a robot shakes by its upper edge, chaotic from half a second on: the cost is as low as the noise in a
// dent of 0.1 % at the truth, and rough everywhere else.
RecordedMotion ShakenSheet() {
  Scene scene = ParseScene(R"({"clothid_scene": 2, "time_step": 0.01, "duration": 1.0, "handles": [0, 1, 2, 3, 4, 5],
      "mesh": {"grid": {"nodes": [6, 6], "size": [0.25, 0.25], "axes": [[1, 0, 0], [0, 0, -1]]}},
      "materials": {"density": 0.15, "k_stretch": 60}})",
                           "scene", "");
  const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(101, 0.0, 1.0);
  Eigen::MatrixXd path(18, times.size());
  for (Eigen::Index k = 0; k < times.size(); ++k) {
    const Eigen::Vector3d shift(0.0, 0.02 * (1.0 - std::cos(12.0 * times[k])),
                                0.015 * (1.0 - std::cos(18.0 * times[k])));
    path.col(k) = scene.initial_positions.head(18) + shift.replicate(6, 1);
  }
  scene.handles.path = HandlePath(times, path);
  MotionOptions truth;
  truth.true_values = {{"k_stretch", 85.0}};
  truth.noise = truth.sigma = 1e-3;
  return MakeMotion(scene, truth);
}

TEST(QuadraticEstimateTest, HoldsTheTruthOfAChaoticSheet) {
  const FitOptions options = Options({"k_stretch"});
  const std::vector<RecordedMotion> motions = {ShakenSheet()};
  FitProblem problem(motions, options);
  const FitSummary summary = Fit(options, &problem, &motions);  // led by its first frames, which are smooth
  ASSERT_TRUE(summary.quadratic && summary.quadratic->is_accepted) << summary.parameters[0].value;
  EXPECT_NEAR(summary.quadratic->distance[0], 0.3, 1e-6) << "nearer there are dents alone";
  const ParameterUncertainty& own = summary.uncertainty->parameters[0];
  EXPECT_TRUE(own.identifiable);
  EXPECT_LT(own.lower95, 85.0);
  EXPECT_GT(own.upper95, 85.0);
  EXPECT_GT(own.upper95 - own.lower95, 0.02 * 85.0);
  EXPECT_LT(own.upper95 - own.lower95, 0.2 * 85.0);
}

// A cloth that goes on swinging for a second and folds as it does: its cost is rough at every distance.
TEST(QuadraticEstimateTest, LeavesACostThatIsNoQuadraticAlone) {
  Scene scene = ClothScene(5, 200);
  scene.time_step = 0.005;
  scene.handles.nodes = {0, 4};
  scene.material.drag = 0.0;
  MotionOptions truth;
  truth.true_values = {{"k_stretch", 50.0}};
  truth.noise = truth.sigma = 1e-3;
  RecordedMotion motion = MakeMotion(scene, truth);
  motion.scene.material.bending_stiffness = 1e-3;
  FitOptions options = Options({"k_stretch"});
  options.overrides.start["k_stretch"] = 60.0;
  FitProblem problem({motion}, options);
  const FitSummary summary = Fit(options, &problem);
  ASSERT_EQ(summary.dents.size(), 1u);
  ASSERT_TRUE(summary.dents[0].is_dent());
  ASSERT_TRUE(summary.quadratic.has_value());
  EXPECT_FALSE(summary.quadratic->is_accepted);
  EXPECT_LT(summary.quadratic->explained, 0.9);
  EXPECT_GT(summary.quadratic->distance[0], 0.0);
  EXPECT_EQ(summary.iterations.back().cost, summary.cost) << "the estimate is that of the fit";
}

}  // namespace
}  // namespace clothid::quadratic_estimate_test
