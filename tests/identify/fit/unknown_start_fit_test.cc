// A recording that does not know its start: what a first noisy frame spoils, and an estimated start puts right.
#include <gtest/gtest.h>

#include <cmath>

#include "identify/fit/fit.h"
#include "identify/run.h"
#include "tests/costs/start/forget_start.h"
#include "tests/costs/synthetic_motion.h"
#include "tests/sim/shipped_scenes.h"

namespace clothid::unknown_start_fit_test {
namespace {

constexpr double kNoise = 2e-3;
constexpr double kStiffness = 70.0, kFriction = 0.24;

// The shipped drape on a coarser mesh, seen at 33 Hz.
RecordedMotion NoisyDrape(unsigned seed) {
  MotionOptions truth;
  truth.true_values = {{"k_stretch", kStiffness}, {"mu", kFriction}};
  truth.sigma = kNoise;
  truth.frame_interval = 0.03;
  RecordedMotion motion = MakeMotion(ShippedScene("drape", 12), truth);
  AddLastingNoise(kNoise, 0.0, seed, &motion);
  return motion;
}

FitSummary FitOf(const std::vector<RecordedMotion>& motions) {
  FitOptions options;
  options.parameters = {"mu", "k_stretch"};
  options.overrides.start = {{"mu", 0.36}, {"k_stretch", 110.0}};
  FitProblem problem(motions, options);
  FitSummary summary = Fit(options, &problem);
  EXPECT_TRUE(summary.uncertainty.has_value()) << summary.message;
  return summary;
}

// From the truth, in standard deviations.
double Deviation(const FitSummary& summary, int parameter) {
  const double truth = parameter == 0 ? kFriction : kStiffness;
  return (summary.parameters[parameter].value - truth) / summary.uncertainty->parameters[parameter].std;
}

TEST(UnknownStartFitTest, FindsTheTruthWhereTheFirstFrameDoesNot) {
  double worst_of_first = 0.0;
  for (const unsigned seed : {1u, 3u}) {
    const RecordedMotion motion = NoisyDrape(seed);
    const FitSummary known = FitOf({motion}), rest = FitOf({ForgetStart(StartSource::kRest, motion)});
    EXPECT_EQ(rest.status, FitStatus::kConverged) << rest.message;
    ASSERT_EQ(rest.starts.size(), 1u);
    EXPECT_GT(rest.starts[0].position_std, 0.0);
    EXPECT_LT(rest.starts[0].position_std, kNoise);
    EXPECT_LT(rest.starts[0].handle_std, kNoise);
    for (int i = 0; i < 2; ++i) {
      const ParameterUncertainty& uncertainty = rest.uncertainty->parameters[i];
      EXPECT_LT(std::abs(Deviation(rest, i)), 3.3) << seed << " " << rest.parameters[i].name;
      EXPECT_GT(uncertainty.std, known.uncertainty->parameters[i].std) << "less is known";
      EXPECT_NEAR(uncertainty.known_start_std, known.uncertainty->parameters[i].std, 0.3 * uncertainty.known_start_std);
    }
    RecordedMotion first = motion;
    first.start_source = StartSource::kFirstFrame;
    first.scene.initial_positions = motion.positions.col(0);
    const FitSummary spoiled = FitOf({first});
    for (int i = 0; i < 2; ++i) worst_of_first = std::max(worst_of_first, std::abs(Deviation(spoiled, i)));
  }
  EXPECT_GT(worst_of_first, 5.0) << "the first frame is no start";
}

// What is held out of a recording starts where the rest of it was found to start, other recordings at their base.
TEST(UnknownStartFitTest, ChecksKnowOfTheStart) {
  RunOptions options;
  options.targets = {ForgetStart(StartSource::kRest, NoisyDrape(1))};
  options.fit.parameters = {"mu", "k_stretch"};
  options.fit.overrides.start = {{"mu", 0.36}, {"k_stretch", 110.0}};
  options.check_recordings = false;
  options.check_gradients = true;
  options.holdout_frames = FrameRange{20, 25};
  const RunResult frames = Identify(options);
  ASSERT_TRUE(frames.checks.holdout.has_value());
  EXPECT_LT(frames.checks.holdout->rmse, 2.1 * kNoise) << "sqrt(3) of it is noise";
  const GradientCheck& gradients = *frames.checks.gradient_check;
  EXPECT_GT(gradients.adjoint_vs_sensitivity, 0.0) << "two ways, not one";
  EXPECT_LT(gradients.adjoint_vs_sensitivity, 1e-8);
  EXPECT_LT(gradients.adjoint_vs_fd, 1e-4);
  options.check_gradients = false;
  options.holdout_frames.reset();
  options.holdouts = {ForgetStart(StartSource::kRest, NoisyDrape(2))};
  const RunResult other = Identify(options);
  EXPECT_LT(other.checks.holdout->rmse, other.checks.holdout->nominal_rmse);
}

TEST(UnknownStartFitTest, EveryRecordingHasAStartOfItsOwn) {
  const RecordedMotion one = ForgetStart(StartSource::kRest, NoisyDrape(1));
  const RecordedMotion other = ForgetStart(StartSource::kRest, NoisyDrape(2));
  const FitSummary alone = FitOf({one}), both = FitOf({one, other});
  ASSERT_EQ(both.starts.size(), 2u);
  EXPECT_EQ(both.starts[1].recording, 1);
  for (int i = 0; i < 2; ++i) {
    EXPECT_LT(both.uncertainty->parameters[i].std, 0.85 * alone.uncertainty->parameters[i].std);
    EXPECT_LT(std::abs(Deviation(both, i)), 3.3);
  }
}

}  // namespace
}  // namespace clothid::unknown_start_fit_test
