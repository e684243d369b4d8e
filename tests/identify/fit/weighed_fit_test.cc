// Fits of recordings that the model cannot reproduce, for its steps are too long: frames count by how far it errs.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "identify/fit/fit.h"
#include "identify/problem/model_errors.h"
#include "identify/run.h"
#include "tests/costs/start/forget_start.h"
#include "tests/identify/fine_recordings.h"
#include "tests/identify/simulated_recordings.h"

namespace clothid::weighed_fit_test {
namespace {

constexpr double kFriction = 0.24, kStiffness = 70.0, kNoise = 5e-4;

// By steps of h/`divisor`.
RecordedMotion Drape(int divisor) {
  Scene scene = ShippedScene("drape", 10, Integrator::kSdirk2);
  return RecordFinely(scene, divisor, 0, {{"mu", kFriction}, {"k_stretch", kStiffness}}, kNoise);
}

RecordedMotion FineDrape() { return Drape(32); }

FitOptions Options(bool weighs) {
  FitOptions options;
  options.parameters = {"mu", "k_stretch"};
  options.overrides.start = {{"mu", 0.36}, {"k_stretch", 110.0}};
  options.weighs_model_error = weighs;
  return options;
}

FitSummary FitOf(const RecordedMotion& motion, bool weighs = true) {
  FitProblem problem({motion}, Options(weighs));
  return Fit(Options(weighs), &problem);
}

double Bias(const FitSummary& summary, int parameter) {
  const double truth = parameter == 0 ? kFriction : kStiffness;
  return std::abs(summary.parameters[parameter].value / truth - 1.0);
}

// Frames that all count the same make the start hide what the step does.
TEST(WeighedFitTest, TheStartStaysWhereItWasSeen) {
  const RecordedMotion motion = FineDrape(), open = ForgetStart(StartSource::kRest, motion);
  const FitSummary known = FitOf(motion), weighed = FitOf(open), same = FitOf(open, false);
  ASSERT_EQ(weighed.status, FitStatus::kConverged) << weighed.message;
  ASSERT_EQ(weighed.starts.size(), 1u);
  EXPECT_LT(weighed.starts[0].moved, 2.0 * weighed.starts[0].position_std);
  EXPECT_GT(same.starts[0].moved, 2.0 * same.starts[0].position_std);
  EXPECT_LT(Bias(weighed, 0), 1.3 * Bias(known, 0));
  EXPECT_LT(Bias(weighed, 0), Bias(same, 0));
  for (int i = 0; i < 2; ++i) EXPECT_FALSE(weighed.uncertainty->parameters[i].stalled) << i;
  const ErrorCurve& curve = weighed.model_errors.at(0).CurveOf(PredictedKind::kPoints);
  ASSERT_FALSE(curve.is_zero());
  EXPECT_EQ(curve.variances[0], 0.0);
  EXPECT_GT(curve.DeviationAt(motion.times[motion.num_frames() - 1]), kNoise);
}

// The same recording by the model itself.
TEST(WeighedFitTest, NothingChangesWhereNoiseIsAllThereIs) {
  const RecordedMotion motion = Drape(1);
  for (const RecordedMotion& each : {motion, ForgetStart(StartSource::kRest, motion)}) {
    const FitSummary weighed = FitOf(each), same = FitOf(each, false);
    EXPECT_TRUE(IsZero(weighed.model_errors));
    EXPECT_EQ(weighed.coordinates, same.coordinates);
    EXPECT_EQ(weighed.statistics.rollouts, same.statistics.rollouts);
    for (int i = 0; i < 2; ++i) {
      EXPECT_EQ(weighed.uncertainty->parameters[i].upper95, same.uncertainty->parameters[i].upper95);
    }
  }
}

TEST(WeighedFitTest, ItIsToldAndKept) {
  RunOptions options;
  options.targets = {FineDrape()};
  options.fit = Options(true);
  options.check_recordings = false;
  options.profiles = {"mu"};
  options.discretization.step = true;
  const RunResult result = Identify(options);
  ASSERT_TRUE(result.summary.has_estimate()) << result.summary.message;
  EXPECT_NE(result.table.find("model misses    "), std::string::npos) << result.table;
  EXPECT_NE(result.verdict.line.find("the model misses "), std::string::npos) << result.verdict.line;
  EXPECT_NE(result.summary.plan.back().Words().find("weighed by the errors of the model"), std::string::npos);
  ASSERT_EQ(result.checks.profiles.size(), 1u);
  EXPECT_LT(result.checks.profiles[0].lower95, result.summary.parameters[0].value) << "of the cost that was fitted";
  ASSERT_TRUE(result.checks.discretization && result.checks.discretization->half_step);
  EXPECT_EQ(result.checks.discretization->half_step->status, FitStatus::kConverged);
}

TEST(WeighedFitTest, ThreadsChangeNothing) {
  const RecordedMotion motion = FineDrape();
  FitOptions options = Options(true);
  FitProblem one({motion, motion}, options);
  const FitSummary first = Fit(options, &one);
  options.num_threads = 2;
  FitProblem two({motion, motion}, options);
  EXPECT_EQ(Fit(options, &two).coordinates, first.coordinates);
}

}  // namespace
}  // namespace clothid::weighed_fit_test
