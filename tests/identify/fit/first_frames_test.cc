// Fits that are led by their first frames, past the minima that whole motions have.
#include "identify/fit/first_frames.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "datasets/motion/motion_file.h"
#include "identify/checks/multi_start.h"
#include "identify/fit/fit.h"
#include "identify/fit/plan.h"
#include "tests/costs/synthetic_forces.h"
#include "tests/costs/synthetic_motion.h"

namespace clothid::first_frames_test {
namespace {

RecordedMotion Bounce() { return ReadMotion(std::string(CLOTHID_SOURCE_DIR) + "/datasets/bounce.motion.bin", {}); }

FitOptions OptionsFor(const std::string& name, double start) {
  FitOptions options;
  options.parameters = {name};
  options.overrides.start[name] = start;
  options.jacobian = JacobianMethod::kSensitivity;
  options.estimate_uncertainty = false;
  return options;
}

FitSummary FitBounce(double start, bool is_led) {
  const std::vector<RecordedMotion> motions = {Bounce()};
  FitOptions options = OptionsFor("k_stretch", start);
  options.growing_horizon = is_led;
  FitProblem problem(motions, options);
  return Fit(options, &problem, &motions);
}

TEST(FirstFramesTest, AreThoseOfTheFirstSeconds) {
  RecordedMotion motion = Bounce();
  const int num_frames = motion.num_frames();
  const RecordedMotion half = FirstFrames(motion, 0.5);
  ASSERT_GT(half.num_frames(), kFewestFrames);
  EXPECT_LE(half.times[half.num_frames() - 1] - motion.times[0],
            0.5 * (motion.times[num_frames - 1] - motion.times[0]));
  EXPECT_GT(motion.times[half.num_frames()] - motion.times[0], 0.5 * (motion.times[num_frames - 1] - motion.times[0]));
  EXPECT_EQ(half.positions, motion.positions.leftCols(half.num_frames()));
  EXPECT_EQ(half.centroid, TurnCenter(motion)) << "a turn is about the same point in all of them";
  EXPECT_EQ(FirstFrames(motion, 1e-3).num_frames(), kFewestFrames);
  EXPECT_EQ(FirstFrames(motion, 1.0).num_frames(), num_frames);
}

TEST(FirstFramesTest, TakeTheForcesOfTheirTimeAlong) {
  RecordedMotion motion = Bounce();
  const double start = motion.times[0], end = motion.times[motion.num_frames() - 1];
  motion.forces.times = Eigen::VectorXd::LinSpaced(11, start, end);
  motion.forces.values = Eigen::MatrixXd::Random(3, 11);
  motion.forces.sigma = Eigen::VectorXd::Constant(1, 0.1);
  const RecordedMotion half = FirstFrames(motion, 0.55);
  EXPECT_EQ(half.forces.num_readings(), 6);
  EXPECT_EQ(half.forces.values, motion.forces.values.leftCols(6));
  EXPECT_EQ(FirstFrames(motion, 1e-3).forces.num_readings(), kFewestFrames);
  EXPECT_TRUE(FirstFrames(Bounce(), 0.5).forces.is_empty());
  motion.forces.values.leftCols(8).setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_TRUE(FirstFrames(motion, 0.5).forces.is_empty()) << "none of these was measured";
  EXPECT_EQ(FirstFrames(motion, 0.8).forces.num_readings(), 9);
}

// A strip that bounces once too often is in step again at the end: from 8 on, fits of all frames end in such minima.
TEST(FirstFramesFitTest, FindsTheMinimumFromAnyStart) {
  for (const double start : {0.3, 1.5, 6.0, 8.0, 10.0, 12.0, 20.0, 30.0}) {
    SCOPED_TRACE(start);
    const FitSummary led = FitBounce(start, true);
    ASSERT_EQ(led.status, FitStatus::kConverged) << led.message;
    EXPECT_NEAR(led.values()[0], 5.0, 1e-4);
    EXPECT_EQ(led.parameters[0].start, start);
  }
  EXPECT_GT(FitBounce(8.0, false).values()[0], 8.0);
}

// In steps: rollouts of an eighth of the frames count an eighth.
TEST(FirstFramesFitTest, TakesNoMoreStepsThanFitsOfAllFrames) {
  const FitSummary led = FitBounce(1.5, true), full = FitBounce(1.5, false);
  EXPECT_LT(led.statistics.counts.steps, full.statistics.counts.steps);
  EXPECT_GT(led.lead.rollouts, 0);
  EXPECT_LT(led.lead.counts.steps, led.statistics.counts.steps);
  EXPECT_EQ(full.lead.rollouts, 0);
}

// The first frames leave nothing to the loose stage here: two points with full precision, each in one pass, of which
// the intervals of the last are a part, and the start, with which the end is compared.
TEST(FirstFramesFitTest, LeadsToTheFullStage) {
  for (const JacobianMethod method : {JacobianMethod::kAdjoint, JacobianMethod::kSensitivity}) {
    FitOptions options = OptionsFor("k_stretch", 1.5);
    options.jacobian = method;
    options.estimate_uncertainty = true;
    const std::vector<RecordedMotion> motions = {Bounce()};
    FitProblem problem(motions, options);
    const FitSummary led = Fit(options, &problem, &motions);
    ASSERT_EQ(led.status, FitStatus::kConverged) << led.message;
    ASSERT_TRUE(led.uncertainty);
    ASSERT_EQ(led.iterations.size(), 3u);
    EXPECT_EQ(led.iterations[0].precision, Precision::kLoose);
    EXPECT_EQ(led.iterations[1].precision, Precision::kFull);
    EXPECT_EQ(led.statistics.rollouts - led.lead.rollouts, 3) << "the start, and two points";
    EXPECT_EQ(led.statistics.sweeps - led.lead.sweeps, method == JacobianMethod::kAdjoint ? 2 : 3);
  }
}

// A cloth shaken by its handles, whose gauge is off by 0.05 N along z.
RecordedMotion Measured() {
  const std::map<std::string, double> truth = {{"k_stretch", 150.0}};
  RecordedMotion motion = MakeMotion(Shaken(SwingScene()), {truth, 0.0, 0.0, 1e-3});
  ForceOptions forces;
  forces.true_values = truth;
  AddForces(forces, &motion);
  motion.forces.values.row(2).array() += 0.05;
  return motion;
}

void Hide(double until, RecordedMotion* motion) {
  const std::vector<int>& handles = motion->scene.handles.nodes;
  for (int i = 0; i < motion->num_frames() && motion->times[i] < until; ++i) {
    for (int p = 0; p < motion->num_points(); ++p) {
      if (std::count(handles.begin(), handles.end(), p) > 0) continue;
      motion->positions.col(i).segment<3>(3 * p).setConstant(std::numeric_limits<double>::quiet_NaN());
    }
  }
}

void HideForces(double until, RecordedMotion* motion) {
  for (int i = 0; i < motion->forces.num_readings() && motion->forces.times[i] < until; ++i) {
    motion->forces.values.col(i).setConstant(std::numeric_limits<double>::quiet_NaN());
  }
}

// The shares that were left out on the way to the truth.
std::vector<double> Skipped(const RecordedMotion& motion, const std::vector<std::string>& names) {
  std::vector<double> skipped;
  FitOptions options = OptionsFor("k_stretch", 140.0);
  options.parameters = names;
  options.on_stage = [&](const FitPlan& plan, int stage) {
    if (plan[stage].state == StageState::kSkipped && plan[stage].share < 1.0) skipped.push_back(plan[stage].share);
  };
  const std::vector<RecordedMotion> motions = {motion};
  FitProblem problem(motions, options);
  const FitSummary led = Fit(options, &problem, &motions);
  EXPECT_EQ(led.status, FitStatus::kConverged) << led.message;
  EXPECT_NEAR(led.values()[0], 150.0, 1e-2);
  return skipped;
}

TEST(FirstFramesFitTest, SkipsFramesThatHoldNothingToFit) {
  const double duration = SwingScene().duration;
  RecordedMotion seen_late = Measured(), read_late = Measured(), both_late = Measured();
  seen_late.forces = ForceReadings();
  Hide(0.6 * duration, &seen_late);
  EXPECT_EQ(Skipped(seen_late, {"k_stretch"}), (std::vector<double>{0.125, 0.25, 0.5}));
  HideForces(0.6 * duration, &read_late);
  RecordedMotion exact = read_late;
  exact.forces.values.row(2).array() -= 0.05;
  EXPECT_TRUE(Skipped(exact, {"k_stretch"}).empty()) << "positions lead";
  EXPECT_EQ(Skipped(read_late, {"k_stretch", "force_bias.z"}), (std::vector<double>{0.125, 0.25, 0.5}));
  Hide(10.0, &both_late);
  HideForces(0.3 * duration, &both_late);
  EXPECT_EQ(Skipped(both_late, {"k_stretch", "force_bias.z"}), (std::vector<double>{0.125, 0.25}));
}

// The range of a bias, its unit, is the largest force so far.
TEST(FirstFramesFitTest, LeadsParametersWhoseUnitGrows) {
  RecordedMotion motion = Measured();
  motion.forces.values.rightCols(1) *= 50.0;
  motion.forces.values(0, motion.forces.num_readings() - 1) = 30.0;
  motion.forces.sigma.setConstant(0.05);
  const std::vector<RecordedMotion> motions = {motion};
  FitOptions options = OptionsFor("k_stretch", 140.0);
  options.parameters = {"k_stretch", "force_bias.x", "force_bias.z"};
  FitProblem problem(motions, options);
  Lead lead;
  lead.coordinates = problem.StartCoordinates();
  for (FitStage& stage : MakePlan(options, problem, /*is_led=*/true)) {
    if (stage.share < 1.0) {
      ASSERT_TRUE(FitFirstFrames(motions, options, problem, &stage, &lead));
    }
  }
  const Eigen::VectorXd values = problem.Values(lead.coordinates);
  EXPECT_NEAR(values[0], 150.0, 2.0);
  EXPECT_NEAR(values[1], 0.0, 5e-3);
  EXPECT_NEAR(values[2], 0.05, 5e-3);
}

TEST(FirstFramesFitTest, LeadsEveryOneOfSeveralStarts) {
  const std::vector<RecordedMotion> motions = {Bounce()};
  FitOptions options = OptionsFor("k_stretch", 8.0);
  options.num_starts = 4;
  FitProblem problem(motions, options);
  MultiStart result;
  FitFromStarts(options, motions, &problem, &result);
  ASSERT_EQ(result.minima.size(), 1u);
  EXPECT_EQ(result.minima[0].num_starts, 4);
}

}  // namespace
}  // namespace clothid::first_frames_test
