// Which stages a fit has, by what is unknown and how it is asked.
#include "identify/fit/plan.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "identify/problem/problem_blocks.h"
#include "tests/costs/start/forget_start.h"
#include "tests/costs/synthetic_motion.h"

namespace clothid::plan_test {
namespace {

std::vector<std::string> Words(const FitPlan& plan) {
  std::vector<std::string> words;
  for (const FitStage& stage : plan) words.push_back(stage.Words());
  return words;
}

std::vector<std::string> PlanOf(std::vector<RecordedMotion> motions, FitOptions options, bool is_led = false) {
  options.parameters = {"k_stretch"};
  SetFlatFields(options, &motions);
  return Words(MakePlan(options, FitProblem(motions, options), is_led));
}

RecordedMotion Swing() {
  MotionOptions made;
  made.sigma = 1e-3;
  return MakeMotion(SwingScene(), made);
}

TEST(PlanTest, ParametersAloneGoLooselyThenFully) {
  EXPECT_EQ(PlanOf({Swing()}, {}),
            (std::vector<std::string>{"all frames, loosely: parameters", "all frames: parameters"}));
  EXPECT_EQ(
      PlanOf({Swing()}, {}, /*is_led=*/true),
      (std::vector<std::string>{
          "first 12.5 % of the time, loosely: parameters", "first 25 % of the time, loosely: parameters",
          "first 50 % of the time, loosely: parameters", "all frames, loosely: parameters", "all frames: parameters"}));
  FitOptions full, loose, numeric;
  full.precision = FitPrecision::kFull;
  loose.precision = FitPrecision::kLoose;
  numeric.jacobian = JacobianMethod::kNumeric;
  EXPECT_EQ(PlanOf({Swing()}, full), (std::vector<std::string>{"all frames: parameters"}));
  EXPECT_EQ(PlanOf({Swing()}, loose), (std::vector<std::string>{"all frames, loosely: parameters"}));
  EXPECT_EQ(PlanOf({Swing()}, numeric), (std::vector<std::string>{"all frames: parameters"}));
}

TEST(PlanTest, StartsComeAfterTheParameters) {
  const RecordedMotion motion = ForgetStart(StartSource::kRest, Swing());
  EXPECT_EQ(PlanOf({motion}, {}),
            (std::vector<std::string>{"all frames, loosely: parameters", "all frames, loosely: parameters, starts",
                                      "all frames: parameters, starts"}));
  FitOptions loose;  // of first frames, whose starts are their bases
  loose.precision = FitPrecision::kLoose;
  EXPECT_EQ(PlanOf({motion}, loose), (std::vector<std::string>{"all frames, loosely: parameters"}));
}

TEST(PlanTest, FieldsComeFromTheSmoothestModesOn) {
  FitOptions options;
  options.fields = {{"density", ParameterKind::kDensity, 2, 3}};
  EXPECT_EQ(PlanOf({Swing()}, options), (std::vector<std::string>{"all frames, loosely: parameters",
                                                                  "all frames, loosely: parameters, fields, smoothness",
                                                                  "all frames: parameters, fields, smoothness"}));
  options.fields.front().columns = 16;
  options.field_weight = 1.0;
  EXPECT_EQ(PlanOf({ForgetStart(StartSource::kRest, Swing())}, options),
            (std::vector<std::string>{
                "all frames, loosely: parameters", "all frames, loosely: parameters, starts, fields in 4 x 4 modes",
                "all frames, loosely: parameters, starts, fields in 8 x 8 modes",
                "all frames, loosely: parameters, starts, fields", "all frames: parameters, starts, fields"}));
}

// A problem whose weights are held, as in a profile, chooses none.
TEST(PlanTest, WeightsAreChosenUnlessTheyAreHeld) {
  FitOptions options;
  options.parameters = {"k_stretch"};
  options.fields = {{"density", ParameterKind::kDensity, 2, 2}};
  std::vector<RecordedMotion> motions = {Swing()};
  SetFlatFields(options, &motions);
  FitProblem problem(motions, options);
  EXPECT_TRUE(MakePlan(options, problem, false).back().with_weights);
  problem.HoldWeights(true);
  EXPECT_FALSE(MakePlan(options, problem, false).back().with_weights);
  EXPECT_EQ(MakePlan(options, problem, false).back().field_modes, kAllModes);
}

TEST(PlanTest, NothingButFrozenParametersHasNoStage) {
  FitProblem known({Swing()}, {}), unknown({ForgetStart(StartSource::kRest, Swing())}, {});
  for (FitProblem* problem : {&known, &unknown}) {
    for (int i = 0; i < problem->num_blocks(); ++i) problem->SetFrozen(i, true);
  }
  EXPECT_TRUE(MakePlan({}, known, true).empty());
  EXPECT_EQ(Words(MakePlan({}, unknown, true)), (std::vector<std::string>{"all frames: parameters, starts"}));
}

}  // namespace
}  // namespace clothid::plan_test
