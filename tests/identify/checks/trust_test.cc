// What surrounds a fit: other starts, held-out measurements, profiles, half the time step.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <set>

#include "identify/checks/discretization_check.h"
#include "identify/checks/holdout.h"
#include "identify/checks/multi_start.h"
#include "identify/checks/profile.h"
#include "identify/problem/evaluator.h"
#include "tests/costs/synthetic_motion.h"
#include "tests/expect_error.h"
#include "tests/identify/sensitivity_fit.h"

namespace clothid::trust_test {
namespace {

RecordedMotion NoisySwing() {
  MotionOptions options;
  options.true_values = {{"k_stretch", 150.0}, {"k_bend", 4e-3}};
  options.noise = options.sigma = 1e-3;
  return MakeMotion(SwingScene(), options);
}

TEST(StartPointsTest, FillTheBoundsInStrata) {
  std::vector<ParameterBlock> blocks = MakeBlocks(SphereScene(), {"mu", "k_stretch", "density"});
  blocks[1].upper_bound = 60.0;
  blocks[2].frozen = true;
  const std::vector<Eigen::VectorXd> points = StartPoints(blocks, 9, 5);
  ASSERT_EQ(points.size(), 9u);
  EXPECT_EQ(points[0], StartOf(blocks)) << "the own start comes first";
  std::set<int> strata;
  for (std::size_t i = 1; i < points.size(); ++i) {
    strata.insert(static_cast<int>(points[i][0] * 8.0));
    EXPECT_GE(blocks[1].ToValue(points[i][1]), 5.0 * (1.0 - 1e-12));
    EXPECT_LE(blocks[1].ToValue(points[i][1]), 60.0 * (1.0 + 1e-12));
    EXPECT_EQ(points[i][2], points[0][2]);
  }
  EXPECT_EQ(strata, (std::set<int>{0, 1, 2, 3, 4, 5, 6, 7}));
  EXPECT_EQ(StartPoints(blocks, 9, 5), points);
  EXPECT_NE(StartPoints(blocks, 9, 6), points);
}

TEST(MultiStartTest, StartsThatAgreeSayTheSameAsOneFit) {
  FitOptions options = OptionsFor({"k_stretch", "k_bend"});
  options.num_starts = 4;
  options.seed = 1;
  options.growing_horizon = false;
  const std::vector<RecordedMotion> motions = {NoisySwing()};
  FitProblem problem(motions, options);
  const FitSummary single = Fit(options, &problem);
  MultiStart starts;
  const FitSummary summary = FitFromStarts(options, motions, &problem, &starts);
  EXPECT_EQ(summary.status, FitStatus::kConverged);
  ASSERT_EQ(starts.starts.size(), 4u);
  ASSERT_EQ(starts.minima.size(), 1u);
  EXPECT_EQ(starts.minima[0].num_starts, 4);
  EXPECT_EQ(starts.ambiguous, (std::vector<bool>{false, false}));
  EXPECT_NEAR(summary.parameters[0].value, single.parameters[0].value, 1e-4 * single.parameters[0].value);
  EXPECT_GT(summary.statistics.rollouts, 3 * single.statistics.rollouts) << "the work of all starts";
  ASSERT_TRUE(summary.uncertainty.has_value());
  EXPECT_NEAR(summary.uncertainty->parameters[0].std, single.uncertainty->parameters[0].std,
              1e-3 * single.uncertainty->parameters[0].std);
  EXPECT_EQ(problem.StartCoordinates(), StartPoints(problem.blocks(), 1, 0)[0]) << "the problem is as it was";
}

// Side by side on problems of their own or one after the other on one: the same bits.
TEST(MultiStartTest, SameBytesOnEveryNumberOfThreads) {
  FitOptions options = OptionsFor({"k_stretch", "k_bend"});
  options.num_starts = 4;
  const std::vector<RecordedMotion> motions = {NoisySwing()};
  const auto fit = [&](int num_threads, MultiStart* starts) {
    options.num_threads = num_threads;
    int num_told = 0;
    options.on_start = [&](int start) { EXPECT_EQ(start, num_told++); };
    FitProblem problem(motions, options);
    FitSummary summary = FitFromStarts(options, motions, &problem, starts);
    EXPECT_EQ(num_told, 4);
    return summary;
  };
  MultiStart alone;
  const FitSummary expected = fit(1, &alone);
  for (const int num_threads : {2, 3}) {
    SCOPED_TRACE(num_threads);
    MultiStart starts;
    const FitSummary summary = fit(num_threads, &starts);
    EXPECT_EQ(summary.values(), expected.values());
    EXPECT_EQ(summary.cost, expected.cost);
    EXPECT_EQ(summary.statistics.rollouts, expected.statistics.rollouts);
    EXPECT_EQ(summary.lead.rollouts, expected.lead.rollouts);
    EXPECT_EQ(summary.uncertainty->parameters[1].std, expected.uncertainty->parameters[1].std);
    ASSERT_EQ(starts.starts.size(), alone.starts.size());
    for (std::size_t s = 0; s < starts.starts.size(); ++s) {
      EXPECT_EQ(starts.starts[s].values, alone.starts[s].values);
      EXPECT_EQ(starts.starts[s].cost, alone.starts[s].cost);
      EXPECT_EQ(starts.starts[s].minimum, alone.starts[s].minimum);
    }
  }
}

TEST(MultiStartTest, EndsWhereItIsInterrupted) {
  FitOptions options = OptionsFor({"k_stretch"});
  options.num_starts = 3;
  options.growing_horizon = false;
  const std::vector<RecordedMotion> motions = {NoisySwing()};
  for (const int num_threads : {1, 2}) {
    std::atomic<bool> cancel{false};
    options.num_threads = num_threads;
    options.cancel = &cancel;
    options.on_start = [&](int start) { cancel = start == 1; };
    FitProblem problem(motions, options);
    MultiStart starts;
    EXPECT_EQ(FitFromStarts(options, motions, &problem, &starts).status, FitStatus::kInterrupted);
  }
}

TEST(ProfileTest, IsThatOfTheCovarianceWhereTheCostIsQuadratic) {
  const FitOptions options = OptionsFor({"k_stretch", "k_bend"});
  FitProblem problem({NoisySwing()}, options);
  const FitSummary summary = Fit(options, &problem);
  CostStatistics statistics;
  const Profile profile = ProfileParameter(options, summary, "k_bend", &problem, &statistics);
  const ParameterUncertainty& uncertainty = summary.uncertainty->parameters[1];
  const double width = uncertainty.upper95 - uncertainty.lower95;
  EXPECT_NEAR(profile.lower95, uncertainty.lower95, 0.1 * width);
  EXPECT_NEAR(profile.upper95, uncertainty.upper95, 0.1 * width);
  EXPECT_EQ(profile.num_failed, 0);
  EXPECT_GT(statistics.rollouts, 0);
  EXPECT_FALSE(problem.blocks()[1].frozen);
  for (std::size_t i = 0; i < profile.points.size(); ++i) {
    EXPECT_GE(profile.points[i].cost_rise, -1e-6) << "the fit was the minimum";
    if (i > 0) {
      EXPECT_GT(profile.points[i].value, profile.points[i - 1].value);
    }
  }
}

TEST(IntervalCheckTest, FindsTheRiseOfAQuadraticCost) {
  FitOptions options = OptionsFor({"k_stretch", "k_bend"});
  FitProblem problem({NoisySwing()}, options);
  const FitSummary summary = Fit(options, &problem);
  ASSERT_TRUE(summary.interval_check.has_value());
  EXPECT_NEAR(summary.interval_check->rise_below, kChiSquare95, 0.5);
  EXPECT_NEAR(summary.interval_check->rise_above, kChiSquare95, 0.5);
  EXPECT_TRUE(summary.interval_check->is_quadratic());
}

// The covariance of independent residuals would say less than half of it.
TEST(LastingNoiseTest, WidensTheIntervalsAndWhatIsJudgedByThem) {
  MotionOptions truth;
  truth.true_values = {{"k_stretch", 150.0}};
  Scene scene = SwingScene();
  scene.duration *= 4.0;
  RecordedMotion motion = MakeMotion(scene, truth);
  AddLastingNoise(1e-3, 0.8, 3, &motion);
  const FitOptions options = OptionsFor({"k_stretch"});
  FitProblem problem({motion}, options);
  const FitSummary summary = Fit(options, &problem);
  ASSERT_TRUE(summary.uncertainty.has_value());
  EXPECT_TRUE(summary.uncertainty->is_widened);
  const ParameterUncertainty& k = summary.uncertainty->parameters[0];
  EXPECT_GT(k.widening, 1.5);
  EXPECT_LT(k.lower95, 150.0);
  EXPECT_GT(k.upper95, 150.0);
  EXPECT_NEAR(std::log(k.upper95 / k.lower95), 2.0 * kNormal95 * k.widening * k.independent_std, 1e-9);
  // The ends of the wider interval are where the cost is looked at, and where a profile ends.
  ASSERT_TRUE(summary.interval_check.has_value());
  EXPECT_TRUE(summary.interval_check->is_quadratic()) << summary.interval_check->rise_above;
  CostStatistics statistics;
  const Profile profile = ProfileParameter(options, summary, "k_stretch", &problem, &statistics);
  EXPECT_NEAR(profile.lower95, k.lower95, 0.1 * (k.upper95 - k.lower95));
}

TEST(IntervalCheckTest, FindsACostThatIsNot) {
  FitOptions options = OptionsFor({"k_stretch"});
  FitProblem problem({NoisySwing()}, options);
  const FitSummary summary = Fit(options, &problem);
  // As a dent in the cost would make it: an interval ten times too narrow.
  Uncertainty dent = *summary.uncertainty;
  dent.parameters[0].coordinate_std *= 0.1;
  Eigen::VectorXd coordinates = summary.coordinates;
  FitEvaluator evaluator(&problem, 1);
  const Eigen::MatrixXd none = Eigen::MatrixXd::Zero(0, 1);  // nothing follows
  const auto check = CheckInterval(problem.blocks(), coordinates, summary.cost, dent, none, &evaluator);
  ASSERT_TRUE(check.has_value());
  EXPECT_LT(check->rise_above, 0.1 * kChiSquare95);
  EXPECT_FALSE(check->is_quadratic());
  // Without noise there is nothing to compare with.
  dent.parameters[0].coordinate_std = 1e-6;
  EXPECT_FALSE(CheckInterval(problem.blocks(), coordinates, summary.cost, dent, none, &evaluator).has_value());
}

TEST(ProfileTest, HasNothingToJudgeByWithoutNoise) {
  MotionOptions truth;
  truth.true_values = {{"k_stretch", 150.0}};
  const FitOptions options = OptionsFor({"k_stretch"});
  FitProblem problem({MakeMotion(SwingScene(), truth)}, options);
  const FitSummary summary = Fit(options, &problem);
  CostStatistics statistics;
  const Profile profile = ProfileParameter(options, summary, "k_stretch", &problem, &statistics);
  EXPECT_TRUE(profile.has_no_noise);
  EXPECT_EQ(statistics.rollouts, 0);
  EXPECT_LT(profile.lower95, 150.0);
  EXPECT_GT(profile.upper95, 150.0);
}

TEST(ProfileTest, IsOpenWhereNothingIsKnown) {
  const FitOptions options = OptionsFor({"mu", "k_stretch"});
  FitProblem problem({NoisySwing()}, options);
  const FitSummary summary = Fit(options, &problem);
  CostStatistics statistics;
  const Profile profile = ProfileParameter(options, summary, "mu", &problem, &statistics);
  EXPECT_TRUE(std::isnan(profile.lower95));
  EXPECT_TRUE(std::isnan(profile.upper95));
  EXPECT_EQ(profile.points.front().value, 0.0);
  EXPECT_EQ(profile.points.back().value, kMaxFriction);
  ExpectError([&] { ProfileParameter(options, summary, "density", &problem, &statistics); }, ErrorKind::kUsage,
              {"'density' is not among the fitted parameters"});
}

// The truth was simulated at half the step, so there it is found again: what moves is what the larger step hides.
TEST(StepCheckTest, FindsTheTruthOfHalfTheStep) {
  Scene scene = SwingScene();
  scene.integrator = Integrator::kEuler;
  scene.time_step *= 0.5;
  MotionOptions truth;
  truth.true_values = {{"k_stretch", 150.0}, {"drag", 0.25}};
  truth.frame_interval = 0.01;
  RecordedMotion motion = MakeMotion(scene, truth);
  motion.scene.time_step *= 2.0;
  const FitOptions options = OptionsFor({"k_stretch", "drag"});
  FitProblem problem({motion}, options);
  FitSummary summary = Fit(options, &problem);
  const RepeatedFit check = *CheckDiscretization({motion}, options, {true, false}, problem, &summary).half_step;
  EXPECT_EQ(check.status, FitStatus::kConverged);
  EXPECT_NEAR(check.values[0], 150.0, 1e-3);
  EXPECT_NEAR(check.values[1], 0.25, 1e-5);
  EXPECT_LT(check.rmse, 1e-6);
  EXPECT_GT(std::abs(check.changes[1]), 0.01) << "the damping of the larger step looks like less drag";
  EXPECT_NEAR(check.changes[1], 0.25 / summary.parameters[1].value - 1.0, 1e-4);
}

TEST(HoldoutTest, ComparesWithTheNominalParameters) {
  MotionOptions other;
  other.true_values = {{"k_stretch", 150.0}};
  const RecordedMotion motion = MakeMotion(SwingScene(), other);
  FitOptions options = OptionsFor({"k_stretch"});
  options.overrides.start["k_stretch"] = 140.0;
  FitProblem problem({motion}, options);
  const Holdout holdout = EvaluateHoldout({motion}, problem.blocks(), Eigen::VectorXd::Constant(1, 150.0));
  EXPECT_TRUE(holdout.failure.empty()) << holdout.failure;
  EXPECT_LT(holdout.rmse, 1e-9);
  EXPECT_GT(holdout.nominal_rmse, 1e-3) << "that of k_stretch = 50, not of the start";
  EXPECT_FALSE(holdout.has_failed());
}

TEST(HoldoutTest, CutsFramesOutOfTheFit) {
  const RecordedMotion whole = NoisySwing();
  std::vector<RecordedMotion> fitted = {whole};
  const std::vector<RecordedMotion> held = HoldOutFrames({5, 8}, &fitted);
  ASSERT_EQ(held.size(), 1u);
  const int rows = Observation(whole).num_residuals();
  const Observation observation(held[0]);
  const int held_rows = observation.num_residuals();
  EXPECT_EQ(held_rows, 3 * 3 * 23) << "3 frames of 23 free nodes";
  EXPECT_EQ(Observation(fitted[0]).num_residuals() + held_rows, rows);
  for (const SeenCoordinate& seen : observation.coordinates()) {
    EXPECT_GE(seen.frame, 5);
    EXPECT_LT(seen.frame, 8);
  }
  ExpectError([&] { HoldOutFrames({5, 22}, &fitted); }, ErrorKind::kUsage, {"synthetic has the frames 0 to 20"});
}

TEST(HoldoutTest, FrameRangesAreChecked) {
  const FrameRange range = ParseFrameRange("3:10", "--holdout_frames");
  EXPECT_EQ(range.begin, 3);
  EXPECT_EQ(range.end, 10);
  for (const char* text : {"", "3", "3:", ":3", "3:3", "4:3", "-1:3", "a:b", "3:10x"}) {
    ExpectError([&] { ParseFrameRange(text, "--holdout_frames"); }, ErrorKind::kUsage,
                {"--holdout_frames: expected A:B"});
  }
}

}  // namespace
}  // namespace clothid::trust_test
