// What one rollout at another step says of an estimate: in closed form, on any number of threads, and where it fails.
#include "identify/checks/step_error.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <vector>

#include "identify/fit/fit.h"
#include "identify/problem/evaluator.h"
#include "tests/identify/fine_recordings.h"
#include "tests/identify/sensitivity_fit.h"

namespace clothid::step_error_test {
namespace {

constexpr double kGravity = 9.81;  // m/s^2

// A cloth that falls freely. By backward Euler its fall is too long by g h t/2, which a start velocity makes up for.
RecordedMotion FallingMotion() {
  Scene scene = ClothScene(4, 20);
  scene.integrator = Integrator::kEuler;
  scene.material.drag = 0.0;
  MotionOptions options;
  options.sigma = 1e-3;
  options.frame_interval = 2.0 * scene.time_step;  // frames are at steps, also of twice the length
  RecordedMotion motion = MakeMotion(scene, options);
  for (int frame = 0; frame < motion.num_frames(); ++frame) {
    const double fall = 0.5 * kGravity * motion.times[frame] * motion.times[frame];
    for (int node = 0; node < scene.mesh.num_nodes(); ++node) {
      motion.positions(3 * node + 2, frame) = scene.initial_positions[3 * node + 2] - fall;
    }
  }
  return motion;
}

// With its estimate.
struct FittedMotions {
  FittedMotions(std::vector<RecordedMotion> of, const FitOptions& with)
      : motions(std::move(of)), options(with), problem(motions, options), summary(Fit(options, &problem)) {}

  std::vector<RecordedMotion> motions;
  FitOptions options;
  FitProblem problem;
  FitSummary summary;
};

TEST(StepErrorTest, IsThatOfAFallInClosedForm) {
  FittedMotions fall({FallingMotion()}, OptionsFor({"v0.z"}));
  const double h = fall.motions[0].scene.time_step, bias = 0.5 * kGravity * h;
  ASSERT_NEAR(fall.summary.parameters[0].value, bias, 1e-6) << fall.summary.message;
  const ParameterUncertainty noise = fall.summary.uncertainty->parameters[0];
  const CostStatistics before = fall.summary.statistics;
  const StepErrorEstimate estimate = AddStepError(fall.motions, fall.options, fall.problem, &fall.summary);
  ASSERT_TRUE(estimate.is_known()) << estimate.failure;
  EXPECT_NEAR(estimate.errors[0], bias, 1e-6 * bias);
  const ParameterUncertainty& widened = fall.summary.uncertainty->parameters[0];
  EXPECT_EQ(widened.step_error, estimate.errors[0]);
  EXPECT_EQ(widened.std, noise.std);
  EXPECT_NEAR(widened.upper95 - widened.lower95, 2.0 * kNormal95 * std::hypot(noise.std, bias), 1e-6);
  // At half the step and, since that is far above the noise, at twice the step, each with the Jacobian there; that of
  // the step is the interval's.
  EXPECT_EQ(fall.summary.statistics.rollouts, before.rollouts + 2);
  EXPECT_EQ(fall.summary.statistics.sweeps, before.sweeps + 2);
}

// At half the step the fall is shorter, and the velocity that makes up for it smaller by g h/4.
TEST(StepErrorTest, MovesTheEstimateTheRightWay) {
  FittedMotions fall({FallingMotion()}, OptionsFor({"v0.z"}));
  const double h = fall.motions[0].scene.time_step;
  RecordedMotion halved = fall.motions[0];
  halved.scene.time_step *= 0.5;
  RecordingModel model(halved, fall.problem.blocks());
  std::vector<Eigen::MatrixXd> predicted(1), forces(1);
  ASSERT_TRUE(model.Simulate(fall.summary.coordinates, {}, {}, predicted.data()).ok());
  FitEvaluator evaluator(&fall.problem, 1);
  Eigen::VectorXd change;
  ASSERT_TRUE(evaluator.PullBackChange(fall.summary.coordinates, predicted, forces, &change));
  const double moved = -change[0] / fall.summary.marginal->hessian(0, 0);
  EXPECT_NEAR(fall.problem.blocks()[0].unit * moved, -0.25 * kGravity * h, 1e-6);
}

TEST(StepErrorTest, DoesNotDependOnThreads) {
  std::vector<RecordedMotion> motions;
  for (const double stiffness : {60.0, 90.0}) {
    motions.push_back(RecordFinely(SwingScene(), 4, 0, {{"k_stretch", stiffness}}));
  }
  motions[1].start_source = StartSource::kRest;  // which has unknowns
  FitOptions options = OptionsFor({"k_stretch", "drag"});
  FittedMotions one(motions, options);
  options.num_threads = 3;
  FittedMotions three(motions, options);
  const StepErrorEstimate a = AddStepError(one.motions, one.options, one.problem, &one.summary);
  const StepErrorEstimate b = AddStepError(three.motions, three.options, three.problem, &three.summary);
  ASSERT_TRUE(a.is_known()) << a.failure;
  EXPECT_EQ(a.errors, b.errors);
  EXPECT_EQ(one.summary.statistics.rollouts, three.summary.statistics.rollouts);
  EXPECT_EQ(one.summary.statistics.sweeps, three.summary.statistics.sweeps);
  EXPECT_EQ(one.summary.statistics.counts.steps, three.summary.statistics.counts.steps);
}

TEST(StepErrorTest, SaysWhereARolloutFails) {
  FittedMotions swing({RecordFinely(SwingScene(), 1, 0, {{"k_stretch", 60.0}})}, OptionsFor({"k_stretch"}));
  const ParameterUncertainty noise = swing.summary.uncertainty->parameters[0];
  std::vector<RecordedMotion> failing = swing.motions;
  failing[0].scene.solver.max_newton_iterations = 1;
  failing[0].scene.solver.max_substep_halvings = 0;
  const StepErrorEstimate estimate = AddStepError(failing, swing.options, swing.problem, &swing.summary);
  EXPECT_FALSE(estimate.is_known());
  EXPECT_NE(estimate.failure.find("synthetic: "), std::string::npos) << estimate.failure;
  EXPECT_TRUE(std::isnan(swing.summary.uncertainty->parameters[0].step_error));
  EXPECT_EQ(swing.summary.uncertainty->parameters[0].upper95, noise.upper95);
}

TEST(StepErrorTest, EndsWhereItIsCancelled) {
  FittedMotions swing({RecordFinely(SwingScene(), 1, 0, {{"k_stretch", 60.0}})}, OptionsFor({"k_stretch"}));
  const std::atomic<bool> cancel{true};
  swing.options.cancel = &cancel;
  const StepErrorEstimate estimate = AddStepError(swing.motions, swing.options, swing.problem, &swing.summary);
  EXPECT_FALSE(estimate.is_known());
  EXPECT_EQ(estimate.failure, "");
}

}  // namespace
}  // namespace clothid::step_error_test
