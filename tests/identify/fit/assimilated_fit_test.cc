// Fits whose rollouts the recordings correct: which memories they try, where they end, and what they say.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "identify/fit/fit.h"
#include "identify/fit/plan.h"
#include "identify/problem/memory_trial.h"
#include "identify/problem/problem.h"
#include "identify/problem/step_prediction.h"
#include "identify/report/report.h"
#include "identify/run.h"
#include "tests/costs/start/forget_start.h"
#include "tests/costs/synthetic_clouds.h"
#include "tests/costs/synthetic_motion.h"
#include "tests/expect_error.h"
#include "tests/identify/fine_recordings.h"
#include "tests/temporary_folder.h"

namespace clothid::assimilated_fit_test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

AssimilationOption Auto() { return {AssimilationOption::Kind::kAuto, {}}; }

FitOptions OptionsOf(const std::vector<std::string>& parameters, const AssimilationOption& assimilate) {
  FitOptions options;
  options.parameters = parameters;
  options.assimilate = assimilate;
  return options;
}

RecordedMotion Swing(double noise) {
  MotionOptions options;
  options.true_values = {{"k_stretch", 90.0}};
  options.noise = options.sigma = noise;
  return MakeMotion(SwingScene(), options);
}

// With a swing of its own, that of a cloth whose steps are 32 times finer.
RecordedMotion FinelyRecorded(double noise) {
  Scene scene = ClothScene(5, 60);
  scene.handles.nodes = {0, 4};
  scene.integrator = Integrator::kEuler;
  return RecordFinely(scene, 32, 0, {{"k_stretch", 90.0}}, noise);
}

MemoryTrial TrialOf(double memory, double coordinate, double std, double cost) {
  MemoryTrial trial;
  trial.memory = memory;
  trial.coordinates = trial.values = Eigen::VectorXd::Constant(1, coordinate);
  trial.std = Eigen::VectorXd::Constant(1, std);
  trial.cost = cost;
  trial.residual_scale = 1.0;
  return trial;
}

TEST(MemoryTrialTest, MemoriesGrowFromTwoFramesToAThirdOfTheTime) {
  const RecordedMotion motion = FinelyRecorded(1e-3);  // 60 intervals of 0.01 s
  FitProblem problem({motion}, OptionsOf({"k_stretch"}, Auto()));
  const std::vector<double> memories = MemoriesOf(problem);
  ASSERT_EQ(memories.size(), 3u);
  EXPECT_NEAR(memories[0], 0.02, 1e-12);
  EXPECT_NEAR(memories[2], 0.18, 1e-12);
  const FitPlan plan = PlanMemoryTrials(problem);
  ASSERT_EQ(plan.size(), 3u);
  EXPECT_EQ(plan[1].Words(), "all frames, corrected with a memory of 0.06 s: parameters");
}

TEST(MemoryTrialTest, EstimatesThatJumpDoNotFollow) {
  const std::vector<ParameterBlock> blocks = MakeBlocks(SwingScene(), {"k_stretch"});
  EXPECT_TRUE(Follows(blocks, TrialOf(0.02, 4.0, 0.01, 1.0), TrialOf(0.06, 4.5, 0.01, 1.0)));
  EXPECT_FALSE(Follows(blocks, TrialOf(0.02, 4.0, 0.01, 1.0), TrialOf(0.06, 5.0, 0.01, 1.0)));
  EXPECT_TRUE(Follows(blocks, TrialOf(0.02, 4.0, 0.5, 1.0), TrialOf(0.06, 5.0, 0.01, 1.0))) << "by chance";
  EXPECT_TRUE(Follows(blocks, TrialOf(0.02, 4.0, kNaN, 1.0), TrialOf(0.06, 9.0, 0.01, 1.0))) << "nothing was told";
}

TEST(MemoryTrialTest, NoiseFallsWithTheMemoryAndErrorsOfTheModelRise) {
  const std::vector<MemoryTrial> rises = {TrialOf(0.02, 4.0, 0.1, 1.0), TrialOf(0.06, 4.0, 0.1, 1.1)};
  const std::vector<MemoryTrial> falls = {TrialOf(0.02, 4.0, 0.1, 1.1), TrialOf(0.06, 4.0, 0.1, 1.0)};
  EXPECT_TRUE(MayBeNoise({}));
  EXPECT_TRUE(MayBeNoise(falls));
  EXPECT_FALSE(MayBeNoise(rises));
  EXPECT_TRUE(LeavesAsLittle(1.3, rises));
  EXPECT_FALSE(LeavesAsLittle(1.4, rises));
  EXPECT_TRUE(IsNoWorse(1.1, rises));
  EXPECT_FALSE(IsNoWorse(1.2, rises));
  MemoryTrial exact = TrialOf(0.06, 4.0, 0.1, 1e-8);
  exact.residual_scale = 1e-4;
  EXPECT_TRUE(IsNoWorse(9e-7, {exact})) << "rounding, too";
  EXPECT_FALSE(IsNoWorse(1.0, {exact})) << "another minimum";
}

TEST(MemoryTrialTest, TheDriftIsThatOfMemoriesThatAreAtMostFiveTimesShorter) {
  const std::vector<MemoryTrial> trials = {TrialOf(0.02, 1.0, 0.1, 1.0), TrialOf(0.06, 4.0, 0.1, 1.0),
                                           TrialOf(0.18, 4.2, 0.1, 1.0)};
  EXPECT_NEAR(DriftOf(trials, trials.back().coordinates)[0], 0.2, 1e-12);
}

TEST(AssimilatedFitTest, IsAsWithoutCorrectionsWhereNothingButNoiseIsLeft) {
  for (const double noise : {1e-3, 0.0}) {
    const std::vector<RecordedMotion> motions = {Swing(noise)};
    const FitOptions off = OptionsOf({"k_stretch"}, {}), automatic = OptionsOf({"k_stretch"}, Auto());
    FitProblem problem(motions, off), assimilated(motions, automatic);
    const FitSummary plain = Fit(off, &problem), summary = Fit(automatic, &assimilated);
    ASSERT_EQ(summary.status, FitStatus::kConverged) << summary.message;
    EXPECT_FALSE(summary.assimilation.is_on());
    EXPECT_TRUE(summary.memory_trials.empty());
    EXPECT_EQ(summary.coordinates, plain.coordinates);
    EXPECT_EQ(summary.statistics.rollouts, plain.statistics.rollouts);
    EXPECT_EQ(summary.uncertainty->parameters[0].half_width95, plain.uncertainty->parameters[0].half_width95);
  }
}

TEST(AssimilatedFitTest, ExactRecordingsShowTheTruthWithAnyMemory) {
  const std::vector<RecordedMotion> motions = {Swing(0.0)};
  for (const double memory : {0.01, 0.05, 0.5}) {
    const FitOptions options = OptionsOf({"k_stretch"}, {AssimilationOption::Kind::kMemory, {memory, std::nullopt}});
    FitProblem problem(motions, options);
    const FitSummary summary = Fit(options, &problem);
    ASSERT_EQ(summary.status, FitStatus::kConverged) << summary.message;
    EXPECT_NEAR(summary.values()[0], 90.0, 1e-4) << memory;
    EXPECT_EQ(summary.assimilation.memory, memory);
  }
}

// The same estimate from everywhere, and an interval that knows of the model's error.
TEST(AssimilatedFitTest, FindsWhatFinerStepsShowFromAnyStart) {
  const std::vector<RecordedMotion> motions = {FinelyRecorded(1e-6)};
  double first = 0.0;
  for (const double start : {22.0, 180.0, 360.0}) {
    FitOptions options = OptionsOf({"k_stretch"}, Auto());
    options.overrides.start = {{"k_stretch", start}};
    FitProblem problem(motions, options);
    const FitSummary summary = Fit(options, &problem);
    ASSERT_EQ(summary.status, FitStatus::kConverged) << summary.message;
    EXPECT_TRUE(summary.assimilation.is_on()) << "backward Euler damps by far more than rounding";
    if (first == 0.0) first = summary.values()[0];
    EXPECT_NEAR(summary.values()[0] / first, 1.0, 2e-3) << start;
    EXPECT_GT(summary.uncertainty->parameters[0].memory_error, 0.0);
    EXPECT_GE(summary.uncertainty->parameters[0].half_width95,
              kNormal95 * summary.uncertainty->parameters[0].memory_error / summary.values()[0]);
    for (const MemoryTrial& trial : summary.memory_trials) {  // of a stiffness: symmetric in its logarithm
      EXPECT_NEAR(trial.upper95[0], trial.values[0] * std::exp(kNormal95 * trial.std[0]), 1e-9 * trial.values[0]);
      EXPECT_NEAR(trial.lower95[0] * trial.upper95[0] / std::pow(trial.values[0], 2), 1.0, 1e-9);
    }
  }
}

TEST(StepPredictionTest, TheEndThatHalfTheStepMovesLessAgrees) {
  const FitProblem problem({Swing(1e-3)}, OptionsOf({"k_stretch"}, {}));
  const auto of = [](double value) { return Eigen::VectorXd::Constant(1, value); };
  const Eigen::VectorXd near = of(4.6), far = of(5.0), distant = of(5.3), small = of(0.05), large = of(0.1);
  EXPECT_TRUE(IsMovedLess(problem, {near, small}, {far, large}));
  EXPECT_FALSE(IsMovedLess(problem, {near, large}, {far, small}));
  EXPECT_FALSE(IsMovedLess(problem, {near, small}, {distant, large})) << "beyond what the step explains";
}

// With motions at hand it is known what half the step moves: the fit that it moves less stands.
TEST(AssimilatedFitTest, LeavesToTheFirstFitWhatTheStepDecides) {
  Scene scene = ClothScene(5, 50);
  scene.handles.nodes = {0, 1, 2, 3, 4};
  scene.time_step = 0.02;
  scene.duration = 1.0;
  const std::vector<RecordedMotion> motions = {RecordFinely(scene, 32, 0, {{"k_stretch", 90.0}}, 1e-3)};
  FitOptions options = OptionsOf({"k_stretch"}, Auto());
  options.growing_horizon = false;
  FitProblem problem(motions, options), unknown(motions, options);
  const FitSummary summary = Fit(options, &problem, &motions), corrected = Fit(options, &unknown);
  ASSERT_EQ(summary.status, FitStatus::kConverged) << summary.message;
  ASSERT_TRUE(corrected.assimilation.is_on()) << "without them nobody knows";
  EXPECT_FALSE(summary.assimilation.is_on());
  EXPECT_EQ(summary.memory_trials.size(), corrected.memory_trials.size());
  const FitOptions off = OptionsOf({"k_stretch"}, {});
  FitProblem plain(motions, off);
  EXPECT_NEAR(summary.coordinates[0], Fit(off, &plain).coordinates[0], 1e-6);
  EXPECT_TRUE(std::any_of(summary.plan.begin(), summary.plan.end(), [](const FitStage& stage) {
    return stage.note == "the time step decides what is estimated with corrections";
  }));
}

TEST(AssimilatedFitTest, TheFirstFramesCorrectAnUnknownStart) {
  const RecordedMotion known = FinelyRecorded(1e-3);
  const FitOptions options = OptionsOf({"k_stretch"}, {AssimilationOption::Kind::kMemory, {0.05, std::nullopt}});
  FitProblem problem({ForgetStart(StartSource::kRest, known)}, options), problem_of_known({known}, options);
  ASSERT_GT(problem.num_start_unknowns(), 0);
  const FitSummary summary = Fit(options, &problem), summary_of_known = Fit(options, &problem_of_known);
  ASSERT_EQ(summary.status, FitStatus::kConverged) << summary.message;
  EXPECT_EQ(summary.coordinates.tail(problem.num_unknowns()).norm(), 0.0);
  EXPECT_TRUE(summary.starts.empty());
  EXPECT_TRUE(summary.uncertainty.has_value());
  EXPECT_NEAR(summary.values()[0] / summary_of_known.values()[0], 1.0, 0.03);
}

TEST(AssimilatedFitTest, GoesOnInItsJournal) {
  const TemporaryFolder folder;
  const std::vector<RecordedMotion> motions = {FinelyRecorded(1e-4)};
  FitOptions options = OptionsOf({"k_stretch"}, Auto());
  const auto run = [&] {
    FitProblem problem(motions, options);
    return Fit(options, &problem);
  };
  const FitSummary uninterrupted = run();
  options.journal_folder = folder.path();
  const FitSummary first = run(), replayed = run();
  for (const FitSummary* summary : {&first, &replayed}) {
    EXPECT_EQ(summary->values(), uninterrupted.values());
    EXPECT_EQ(summary->cost, uninterrupted.cost);
    EXPECT_EQ(summary->statistics.rollouts, uninterrupted.statistics.rollouts);
    EXPECT_EQ(summary->predicted.front(), uninterrupted.predicted.front());
  }
}

TEST(AssimilatedFitTest, TellsWhoCorrectsNothing) {
  const std::vector<RecordedMotion> motions = {FinelyRecorded(1e-6)};
  FitOptions options = OptionsOf({"k_stretch", "time_offset"}, Auto());
  FitProblem problem(motions, options);
  const FitSummary summary = Fit(options, &problem);
  EXPECT_EQ(summary.status, FitStatus::kConverged);
  EXPECT_EQ(summary.why_not_assimilated, "synthetic has a clock that is fitted");
  EXPECT_TRUE(summary.memory_trials.empty());
  EXPECT_NE(
      ResultTable(summary, {}).find("memory          none: synthetic has a clock that is fitted, and corrects no"),
      std::string::npos);
  options.assimilate = {AssimilationOption::Kind::kMemory, {0.1, std::nullopt}};
  ExpectError([&] { FitProblem(motions, options); }, ErrorKind::kUsage,
              {"--assimilate: synthetic has a clock that is fitted; expected off or auto"});
}

// Clouds on the surface, without noise: any memory shows the truth, and predictions ahead are judged by distances.
TEST(AssimilatedFitTest, CloudsCorrectRollouts) {
  RecordedMotion motion = Swing(0.0);
  AddClouds(200, 0.0, /*keep_points=*/false, &motion);
  for (const double memory : {0.02, 0.2}) {
    RunOptions options;
    options.targets = {motion};
    options.fit = OptionsOf({"k_stretch"}, {AssimilationOption::Kind::kMemory, {memory, std::nullopt}});
    options.fit.overrides.start["k_stretch"] = 30.0;
    const RunResult result = Identify(options);
    ASSERT_EQ(result.summary.status, FitStatus::kConverged) << result.summary.message;
    EXPECT_NEAR(result.summary.values()[0], 90.0, 1e-3) << memory;
    EXPECT_EQ(result.summary.assimilation.memory, memory);
    EXPECT_FALSE(result.checks.lead_times.empty());
    for (const LeadTimeError& ahead : result.checks.lead_times) {
      EXPECT_LT(ahead.rmse, 1e-6);
      EXPECT_GT(ahead.still_rmse, 1e-3);
    }
  }
}

// What is written is a simulation with these parameters, and its error stands beside that of the fit.
TEST(AssimilatedRunTest, WritesPredictionsWithoutCorrections) {
  const TemporaryFolder folder;
  RunOptions options;
  options.targets = {FinelyRecorded(1e-6)};
  options.fit = OptionsOf({"k_stretch"}, {AssimilationOption::Kind::kMemory, {0.05, std::nullopt}});
  options.output = folder.path();
  options.report_page = false;
  const RunResult result = Identify(options);
  ASSERT_TRUE(result.checks.uncorrected_error.has_value());
  EXPECT_GT(result.checks.uncorrected_error->rmse(), 2.0 * result.summary.error.rmse());
  const Observation observation(options.targets.front());
  EXPECT_EQ(observation.Compare(result.summary.predicted.front()).rmse(), result.checks.uncorrected_error->rmse());
  EXPECT_NE(result.table.find("memory          0.05 s of rollouts that the recordings correct"), std::string::npos);
  EXPECT_NE(result.table.find("of rollouts without corrections"), std::string::npos);
}

// Starts are compared without corrections; the memories follow the best of them.
TEST(AssimilatedRunTest, GoesWithStarts) {
  RunOptions options;
  options.targets = {FinelyRecorded(1e-4)};
  options.fit = OptionsOf({"k_stretch"}, Auto());
  const double alone = Identify(options).summary.values()[0];
  options.fit.num_starts = 2;
  const RunResult result = Identify(options);
  ASSERT_TRUE(result.checks.starts.has_value());
  EXPECT_EQ(result.checks.starts->starts.size(), 2u);
  EXPECT_TRUE(result.summary.assimilation.is_on());
  EXPECT_NEAR(result.summary.values()[0] / alone, 1.0, 2e-3);
}

TEST(AssimilationOptionTest, IsReadFromWords) {
  EXPECT_FALSE(ParseAssimilation("off").is_on());
  EXPECT_EQ(ParseAssimilation("auto").kind, AssimilationOption::Kind::kAuto);
  EXPECT_EQ(ParseAssimilation("0.2").given.memory, 0.2);
  EXPECT_FALSE(ParseAssimilation("0.2").given.smoothing.has_value());
  EXPECT_EQ(ParseAssimilation("0.2:0").given.smoothing, 0.0);
  for (const char* text : {"", "on", "0", "-1", "inf", "nan", "1:", "1:-1", "1:inf", "1:2:3", "1s"}) {
    ExpectError([&] { ParseAssimilation(text); }, ErrorKind::kUsage,
                {"--assimilate: expected off, auto or MEMORY[:LENGTH] in s and m", text});
  }
}

}  // namespace
}  // namespace clothid::assimilated_fit_test
