// Known parameters are found again; and what a fit says when it cannot find them.
#include "identify/fit/fit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "identify/checks/gradient_check.h"
#include "tests/costs/synthetic_motion.h"

namespace clothid::fit_test {
namespace {

FitOptions OptionsFor(std::vector<std::string> parameters, JacobianMethod jacobian = JacobianMethod::kAdjoint) {
  FitOptions options;
  options.parameters = std::move(parameters);
  options.jacobian = jacobian;
  return options;
}

FitSummary RunFit(const std::vector<RecordedMotion>& motions, const FitOptions& options) {
  FitProblem problem(motions, options);
  return Fit(options, &problem);
}

void ExpectRecovered(const FitSummary& summary, const std::map<std::string, double>& truth, double tolerance) {
  EXPECT_EQ(summary.status, FitStatus::kConverged) << summary.message;
  for (const FittedParameter& parameter : summary.parameters) {
    const double value = truth.at(parameter.name);
    EXPECT_NEAR(parameter.value, value, tolerance * value) << parameter.name;
    EXPECT_FALSE(parameter.at_bound) << parameter.name;
  }
  ASSERT_TRUE(summary.uncertainty.has_value());
  for (const ParameterUncertainty& parameter : summary.uncertainty->parameters) {
    EXPECT_TRUE(parameter.identifiable);
    EXPECT_LT(parameter.distance, 1.0);
  }
}

// Density, stiffnesses and drag have a common factor that changes nothing, so density is not fitted beside the rest.
const std::map<std::string, double> kSwingTruth = {{"k_stretch", 150.0}, {"k_bend", 4e-3}, {"drag", 0.25}};
const std::map<std::string, double> kSphereTruth = {{"mu", 0.35}, {"k_stretch", 150.0}};

RecordedMotion SwingMotion() { return MakeMotion(SwingScene(), {kSwingTruth, 0.0, 0.0125, 0.0}); }
RecordedMotion SphereMotion() { return MakeMotion(SphereScene(), {kSphereTruth, 0.0, 0.0, 0.0}); }

class RecoveryTest : public testing::TestWithParam<JacobianMethod> {};

INSTANTIATE_TEST_SUITE_P(Methods, RecoveryTest,
                         testing::Values(JacobianMethod::kAdjoint, JacobianMethod::kSensitivity,
                                         JacobianMethod::kNumeric));

TEST_P(RecoveryTest, FindsStiffnessesAndDragOfASwingingCloth) {
  FitOptions options = OptionsFor({"k_stretch", "k_bend", "drag"}, GetParam());
  options.max_iterations = 200;
  const FitSummary summary = RunFit({SwingMotion()}, options);
  ExpectRecovered(summary, kSwingTruth, 1e-6);
  EXPECT_GT(summary.start_error.rmse(), 1e-3);
  EXPECT_LT(summary.error.rmse(), 1e-6);
}

TEST_P(RecoveryTest, FindsFrictionAndStiffnessOnASphere) {
  FitOptions options = OptionsFor({}, GetParam());
  options.max_iterations = 200;
  ExpectRecovered(RunFit({SphereMotion()}, options), kSphereTruth, 1e-6);
}

// The scene of the recording has no internal damping: its starting value brings the term in.
// Gradients with errors of some per cent lead to the minimum, too.
TEST(FitTest, OtherLinearSolversOfTheSweepFindTheSame) {
  for (const char* adjoint : {"lu", "gmres:1e-2", "fixed_point:1e-4"}) {
    FitOptions options = OptionsFor({"mu", "k_stretch"});
    options.adjoint = ParseAdjointOptions(adjoint);
    SCOPED_TRACE(adjoint);
    ExpectRecovered(RunFit({SphereMotion()}, options), kSphereTruth, 1e-4);
  }
}

TEST(FitTest, FindsADampingThatTheSceneDoesNotHave) {
  const std::map<std::string, double> truth = {{"k_stretch", 150.0}, {"damping", 0.6}};
  Scene scene = SwingScene();
  scene.material.damping = 0.6;
  RecordedMotion motion = MakeMotion(scene, {truth, 0.0, 0.0, 0.0});
  motion.scene.material.damping = 0.0;
  FitOptions options = OptionsFor({"k_stretch", "damping"});
  options.overrides.start["damping"] = 0.05;
  ExpectRecovered(RunFit({motion}, options), truth, 1e-6);
}

TEST(FitTest, FitsRecordingsJointly) {
  std::map<std::string, double> truth = {{"mu.ball", 0.35}, {"k_stretch", 150.0}};
  MotionOptions swing;
  swing.true_values = {{"k_stretch", 150.0}};
  swing.noise = 1e-6;
  const std::vector<RecordedMotion> motions = {MakeMotion(SwingScene(), swing), SphereMotion()};
  FitOptions options = OptionsFor({"mu.ball", "k_stretch"});
  const FitSummary one = RunFit(motions, options);
  ExpectRecovered(one, truth, 1e-4);
  EXPECT_EQ(one.predicted.size(), 2u);

  options.num_threads = 2;
  const FitSummary two = RunFit(motions, options);
  ASSERT_EQ(two.iterations.size(), one.iterations.size());
  for (std::size_t i = 0; i < one.iterations.size(); ++i) {
    EXPECT_EQ(two.iterations[i].cost, one.iterations[i].cost);
    EXPECT_EQ(two.iterations[i].values, one.iterations[i].values);
    EXPECT_EQ(two.iterations[i].rollouts, one.iterations[i].rollouts);
  }
  EXPECT_EQ(two.parameters[0].value, one.parameters[0].value);
}

TEST(FitTest, NumbersOfTheSummaryFitTogether) {
  std::vector<FitIteration> seen;
  FitOptions options = OptionsFor({"k_stretch", "k_bend"});
  options.on_iteration = [&](const FitIteration& iteration) { seen.push_back(iteration); };
  MotionOptions motion_options;
  motion_options.true_values = {{"k_stretch", 150.0}};
  motion_options.noise = 1e-3;
  const RecordedMotion motion = MakeMotion(SwingScene(), motion_options);
  const FitSummary summary = RunFit({motion}, options);
  ASSERT_FALSE(summary.iterations.empty());
  EXPECT_EQ(seen.size(), summary.iterations.size());
  EXPECT_EQ(summary.iterations.front().values[0], std::exp(std::log(50.0)));
  EXPECT_EQ(summary.iterations.back().cost, summary.cost);
  EXPECT_EQ(summary.iterations.back().values[0], summary.parameters[0].value);
  for (std::size_t i = 1; i < summary.iterations.size(); ++i) {
    if (summary.iterations[i].precision == summary.iterations[i - 1].precision) {
      EXPECT_LE(summary.iterations[i].cost, summary.iterations[i - 1].cost);
    }
    EXPECT_GT(summary.iterations[i].iteration, summary.iterations[i - 1].iteration);
  }
  EXPECT_NEAR(summary.cost, 0.5 * Observation(motion).Residuals(summary.predicted[0]).squaredNorm(), 1e-9);
  // 1 mm of noise on every coordinate is sqrt(3) mm on every point.
  EXPECT_NEAR(summary.error.rmse(), std::sqrt(3.0) * 1e-3, 1e-4);
}

// Where steps start near their end, a loose one takes as many iterations as another, but fewer factors.
TEST(FitTest, LoosePrecisionSavesWorkAndChangesNoEstimate) {
  const auto work = [](const FitSummary& fit) {
    return fit.statistics.counts.newton_iterations + fit.statistics.counts.factorizations;
  };
  const MotionOptions noisy = {kSphereTruth, 1e-3, 0.0, 1e-3};
  Scene euler = SphereScene();
  euler.integrator = Integrator::kEuler;
  for (JacobianMethod jacobian : {JacobianMethod::kAdjoint, JacobianMethod::kSensitivity}) {
    for (const RecordedMotion& motion :
         {MakeMotion(euler, {kSphereTruth, 0.0, 0.0, 0.0}), MakeMotion(SphereScene(), noisy)}) {
      FitOptions options = OptionsFor({}, jacobian);
      const FitSummary adaptive = RunFit({motion}, options);
      options.precision = FitPrecision::kFull;
      const FitSummary full = RunFit({motion}, options);
      ASSERT_EQ(adaptive.status, FitStatus::kConverged) << adaptive.message;
      ASSERT_EQ(full.status, FitStatus::kConverged) << full.message;
      EXPECT_EQ(adaptive.iterations.front().precision, Precision::kLoose);
      EXPECT_EQ(adaptive.iterations.back().precision, Precision::kFull);
      EXPECT_LT(work(adaptive), work(full));
      for (std::size_t i = 0; i < full.parameters.size(); ++i) {
        const double std = full.uncertainty->parameters[i].std;
        EXPECT_NEAR(adaptive.parameters[i].value, full.parameters[i].value, 0.1 * std);
        EXPECT_NEAR(adaptive.uncertainty->parameters[i].std, std, 0.01 * std);
      }
    }
  }
}

// Differences would not survive it.
TEST(FitTest, ForwardDifferencesAreNeverLoose) {
  FitOptions options = OptionsFor({"k_stretch"}, JacobianMethod::kNumeric);
  const FitSummary adaptive = RunFit({SwingMotion()}, options);
  options.precision = FitPrecision::kFull;
  const FitSummary full = RunFit({SwingMotion()}, options);
  EXPECT_EQ(adaptive.parameters[0].value, full.parameters[0].value);
  EXPECT_EQ(adaptive.cost, full.cost);
  EXPECT_EQ(adaptive.statistics.counts.newton_iterations, full.statistics.counts.newton_iterations);
}

TEST(FitTest, RobustLossIgnoresOutliers) {
  MotionOptions truth;
  truth.true_values = {{"k_stretch", 150.0}};
  RecordedMotion motion = MakeMotion(SwingScene(), truth);
  for (int frame = 2; frame < motion.num_frames(); frame += 3) motion.positions(3 * 12 + 2, frame) += 0.2;
  FitOptions options = OptionsFor({"k_stretch"});
  const double plain = std::abs(RunFit({motion}, options).parameters[0].value - 150.0);
  options.loss = ParseRobustLoss("huber:1");
  const FitSummary robust = RunFit({motion}, options);
  EXPECT_EQ(robust.status, FitStatus::kConverged) << robust.message;
  EXPECT_LT(std::abs(robust.parameters[0].value - 150.0), 0.1 * plain);
}

TEST(FitTest, SaysWhatIsNotIdentifiable) {
  const RecordedMotion motion = MakeMotion(SwingScene(), {{{"k_stretch", 150.0}}, 0.0, 0.0, 0.0});
  const FitSummary summary = RunFit({motion}, OptionsFor({"mu", "k_stretch"}));
  ASSERT_EQ(summary.parameters.size(), 2u);
  ASSERT_TRUE(summary.uncertainty.has_value());
  EXPECT_FALSE(summary.uncertainty->parameters[0].identifiable);
  EXPECT_TRUE(summary.uncertainty->parameters[1].identifiable);
  ASSERT_EQ(summary.uncertainty->hidden_directions.size(), 1u);
  EXPECT_EQ(summary.uncertainty->hidden_directions[0].words, "mu");
  EXPECT_EQ(summary.parameters[0].value, summary.parameters[0].start);
}

// Bending and drag are held at wrong values: what is left of the error lasts, and the interval that counts with that is
// wider than the bounds.
TEST(FitTest, SaysWhatIsHardlyTold) {
  Scene scene = SwingScene();
  scene.integrator = Integrator::kEuler;
  scene.bending.law = BendingLaw::kEdges;
  const FitSummary summary = RunFit({MakeMotion(scene, {kSwingTruth, 0.0, 0.0125, 0.0})}, OptionsFor({"k_stretch"}));
  ASSERT_TRUE(summary.uncertainty.has_value());
  const ParameterUncertainty& k = summary.uncertainty->parameters[0];
  EXPECT_TRUE(k.visible);
  EXPECT_TRUE(k.reaches_lower && k.reaches_upper);
  EXPECT_FALSE(k.identifiable);
}

TEST(FitTest, KnowsThatItStoppedEarly) {
  FitOptions options = OptionsFor({"k_stretch"});
  options.max_iterations = 1;
  MotionOptions noisy;
  noisy.true_values = {{"k_stretch", 150.0}};
  noisy.noise = noisy.sigma = 1e-4;
  const FitSummary summary = RunFit({MakeMotion(SwingScene(), noisy)}, options);
  EXPECT_EQ(summary.status, FitStatus::kNotConverged);
  ASSERT_TRUE(summary.uncertainty.has_value());
  EXPECT_GT(summary.uncertainty->parameters[0].distance, 1.0);
}

TEST(FitTest, StopsAtABound) {
  FitOptions options = OptionsFor({"k_stretch"});
  options.overrides.upper_bounds["k_stretch"] = 100.0;
  const FitSummary summary = RunFit({SwingMotion()}, options);
  ASSERT_TRUE(summary.has_estimate());
  EXPECT_TRUE(summary.parameters[0].at_bound) << summary.parameters[0].value;
  EXPECT_LE(summary.parameters[0].value, 100.0 * (1.0 + 1e-12));
}

TEST(FitTest, FrozenParametersStay) {
  RecordedMotion motion = SwingMotion();
  motion.scene.parameters["k_bend"].frozen = true;
  motion.scene.parameters["k_bend"].nominal = 4e-3;
  motion.scene.material.drag = 0.25;
  const FitSummary summary = RunFit({motion}, OptionsFor({"k_bend", "k_stretch"}));
  EXPECT_EQ(summary.parameters[0].value, 4e-3);
  EXPECT_TRUE(summary.parameters[0].frozen);
  EXPECT_NEAR(summary.parameters[1].value, 150.0, 1e-3);
}

TEST(FitTest, InterruptionKeepsTheBestPoint) {
  std::atomic<bool> cancel{false};
  FitOptions options = OptionsFor({"k_stretch", "k_bend", "drag"});
  options.cancel = &cancel;
  options.on_iteration = [&](const FitIteration& iteration) { cancel = iteration.iteration >= 2; };
  const FitSummary summary = RunFit({SwingMotion()}, options);
  EXPECT_EQ(summary.status, FitStatus::kInterrupted);
  ASSERT_TRUE(summary.has_estimate());
  EXPECT_LT(summary.cost, summary.iterations.front().cost);
  EXPECT_EQ(summary.predicted.size(), 1u);
  EXPECT_LT(summary.error.rmse(), summary.start_error.rmse());
}

TEST(FitTest, AFailingStartIsToldWithItsReason) {
  RecordedMotion motion = SwingMotion();
  motion.scene.solver.step_tolerance = 1e-15;  // below rounding
  motion.scene.solver.max_newton_iterations = 1;
  motion.scene.solver.max_substep_halvings = 0;
  const FitSummary summary = RunFit({motion}, OptionsFor({"k_stretch"}));
  EXPECT_EQ(summary.status, FitStatus::kFailed);
  EXPECT_FALSE(summary.has_estimate());
  EXPECT_NE(summary.message.find("synthetic: step "), std::string::npos) << summary.message;
}

TEST(FitTest, StopsAtTheIterationLimit) {
  FitOptions options = OptionsFor({"k_stretch", "k_bend", "drag"});
  options.max_iterations = 1;
  const FitSummary summary = RunFit({SwingMotion()}, options);
  EXPECT_EQ(summary.status, FitStatus::kNotConverged);
  EXPECT_TRUE(summary.has_estimate());
}

TEST(GradientCheckTest, AgreesOnCorrectGradients) {
  FitOptions options = OptionsFor({"k_stretch", "k_bend", "density", "drag"});
  const GradientCheck swing = CheckGradients({SwingMotion()}, options);
  EXPECT_LT(swing.adjoint_vs_sensitivity, 1e-10);
  EXPECT_LT(swing.adjoint_vs_fd, 1e-5);
  EXPECT_GT(swing.adjoint_vs_fd, 0.0);
  const GradientCheck sphere = CheckGradients({SphereMotion()}, OptionsFor({"mu", "k_stretch"}));
  EXPECT_LT(sphere.adjoint_vs_sensitivity, 1e-9);
  EXPECT_LT(sphere.adjoint_vs_fd, 1e-5);
}

}  // namespace
}  // namespace clothid::fit_test
