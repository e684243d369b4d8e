// `--time_step auto`: the coarsest step whose error hides in the noise.
#include "identify/checks/step_choice.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>

#include "tests/identify/fine_recordings.h"
#include "tests/identify/sensitivity_fit.h"

namespace clothid::step_choice_test {
namespace {

constexpr double kTruth = 0.3;

struct Chosen {
  FitSummary summary;
  StepChoice choice;
};

// Of the friction of a cloth on a slope, seen with `noise`, in m.
Chosen Choose(double noise) {
  const RecordedMotion motion = RecordFinely(SlopeScene(), 64, 0, {{"mu", kTruth}}, noise);
  FitOptions options = OptionsFor({"mu"});
  options.weighs_model_error = false;  // that of the step is what is to be compared with the noise
  FitProblem problem({motion}, options);
  Chosen chosen;
  chosen.summary = Fit(options, &problem);
  chosen.choice = ChooseTimeStep({motion}, options, problem, &chosen.summary);
  return chosen;
}

TEST(StepChoiceTest, GoesFinerWhereTheStepErrsByMoreThanTheNoise) {
  const auto [summary, choice] = Choose(1e-3);
  ASSERT_TRUE(choice.found) << StepChoiceText(choice);
  EXPECT_LT(choice.level, 0);
  EXPECT_GT(choice.trials.front().error_over_noise, 1.0);
  EXPECT_LE(choice.trials.back().error_over_noise, 1.0);
  EXPECT_TRUE(std::isnan(choice.needed)) << "it was found";
  ASSERT_TRUE(choice.check.half_step && choice.check.double_step);
  const double std = summary.uncertainty->parameters[0].std;
  EXPECT_GT(std::abs(summary.parameters[0].value - kTruth), 2.0 * std);
  EXPECT_LT(std::abs(choice.start[0] - kTruth), 4.0 * std) << "noise and the error of the step, both at most std";
}

TEST(StepChoiceTest, GoesCoarserWhereTheNoiseHidesMore) {
  const StepChoice choice = Choose(0.1).choice;
  ASSERT_TRUE(choice.found) << StepChoiceText(choice);
  EXPECT_GT(choice.level, 0);
  for (const StepTrial& trial : choice.trials) EXPECT_EQ(trial.is_fine_enough(), trial.level <= choice.level);
}

TEST(StepChoiceTest, SaysWhatItWouldTake) {
  const auto [summary, choice] = Choose(1e-6);
  EXPECT_FALSE(choice.found);
  EXPECT_EQ(choice.level, 0);
  EXPECT_LT(choice.needed, SlopeScene().time_step / 16.0);
  EXPECT_NE(StepChoiceText(choice).find("it would take about"), std::string::npos);
}

TEST(StepChoiceTest, EndsWhereItIsCancelled) {
  const RecordedMotion motion = RecordFinely(SlopeScene(), 4, 0, {{"mu", kTruth}});
  FitOptions options = OptionsFor({"mu"});
  FitProblem problem({motion}, options);
  FitSummary summary = Fit(options, &problem);
  const std::atomic<bool> cancel = true;
  options.cancel = &cancel;
  EXPECT_FALSE(ChooseTimeStep({motion}, options, problem, &summary).found);
}

}  // namespace
}  // namespace clothid::step_choice_test
