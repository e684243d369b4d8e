// Estimates from coarse steps and meshes: their intervals contain the truth once they count with the discretisation.
#include "identify/checks/discretization_check.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <map>
#include <string>

#include "identify/checks/step_error.h"
#include "identify/problem/step_prediction.h"
#include "sim/scene/scene_json.h"
#include "tests/identify/fine_recordings.h"
#include "tests/identify/sensitivity_fit.h"

namespace clothid::discretization_check_test {
namespace {

bool Contains(const ParameterUncertainty& interval, double value) {
  return interval.lower95 <= value && value <= interval.upper95;
}

TEST(DiscretizationCheckTest, CoversATruthOfFineStepsWhereNoiseAloneDoesNot) {
  const double truth = 0.3;
  const RecordedMotion motion = RecordFinely(SlopeScene(), 16, 0, {{"mu", truth}});
  const FitOptions options = OptionsFor({"mu"});
  FitProblem problem({motion}, options);
  FitSummary summary = Fit(options, &problem);
  const ParameterUncertainty noise = summary.uncertainty->parameters[0];
  EXPECT_FALSE(Contains(noise, truth)) << summary.parameters[0].value << " +- " << noise.std;

  const CostStatistics before = summary.statistics;
  const DiscretizationCheck check = CheckDiscretization({motion}, options, {true, false}, problem, &summary);
  ASSERT_TRUE(check.half_step && check.double_step);
  EXPECT_FALSE(check.fine_mesh);
  EXPECT_EQ(check.half_step->status, FitStatus::kConverged);
  EXPECT_GT(summary.statistics.rollouts, before.rollouts);
  const ParameterUncertainty& widened = summary.uncertainty->parameters[0];
  EXPECT_TRUE(Contains(widened, truth));
  EXPECT_EQ(widened.std, noise.std) << "std stays that of the noise";
  EXPECT_TRUE(std::isnan(widened.mesh_error));
  const double off = std::abs(summary.parameters[0].value - truth);
  EXPECT_GT(widened.step_error, 0.7 * off);
  EXPECT_LT(widened.step_error, 1.4 * off);
}

// Of the shipped scene.
TEST(DiscretizationCheckTest, OneRolloutTellsTheErrorOfTheStep) {
  const std::map<std::string, double> truth = {{"mu", 0.24}, {"k_stretch", 70.0}};
  const RecordedMotion motion =
      RecordFinely(ReadScene(CLOTHID_SOURCE_DIR "/datasets/drape.scene.json"), 32, 0, truth, /*noise=*/1e-4);
  FitOptions options;
  options.parameters = {"mu", "k_stretch"};
  options.overrides.start = truth;
  options.check_interval = false;
  FitProblem problem({motion}, options);
  FitSummary summary = Fit(options, &problem);
  ASSERT_EQ(summary.status, FitStatus::kConverged) << summary.message;
  const std::vector<ParameterUncertainty> noise = summary.uncertainty->parameters;
  const StepErrorEstimate estimate = AddStepError({motion}, options, problem, &summary);
  ASSERT_TRUE(estimate.is_known()) << estimate.failure;
  for (std::size_t i = 0; i < 2; ++i) {
    const double value = truth.at(summary.parameters[i].name), off = std::abs(summary.parameters[i].value - value);
    EXPECT_LT(off, kNormal95 * estimate.errors[i]) << summary.parameters[i].name;
    EXPECT_TRUE(Contains(summary.uncertainty->parameters[i], value)) << summary.parameters[i].name;
  }
  EXPECT_FALSE(Contains(noise[0], truth.at("mu")));
}

// A sheet that swings down and lies on a floor with its lower half.
constexpr char kSheetOnFloor[] = R"({
  "clothid_scene": 2, "duration": 1.0, "time_step": 0.01,
  "mesh": {"grid": {"nodes": [11, 11], "size": [0.3, 0.3], "axes": [[1, 0, 0], [0, 0.8660254037844387, -0.5]]}},
  "initial": {"positions": "rest"}, "handles": [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10],
  "obstacles": [{"type": "plane", "point": [0, 0, -0.18], "normal": [0, 0, 1], "mu": 0.6}],
  "materials": {"density": 0.15, "k_stretch": 180, "bending": "edges", "k_bend": 1e-4, "damping": 0.02}})";

// Its cost is rough: what half the step moves, the derivatives at the step do not tell.
TEST(DiscretizationCheckTest, DerivativesAtHalfTheStepTellWhatARoughCostHides) {
  const std::map<std::string, double> truth = {{"mu", 0.3}, {"k_stretch", 100.0}};
  RecordedMotion motion = RecordFinely(ParseScene(kSheetOnFloor, "scene", ""), 32, 0, truth);
  motion.scene.time_step = 2.5e-3;
  FitOptions options;
  options.parameters = {"mu", "k_stretch"};
  options.overrides.start = truth;
  options.check_interval = false;
  FitProblem problem({motion}, options);
  FitSummary summary = Fit(options, &problem), by_step = summary;
  ASSERT_EQ(summary.status, FitStatus::kConverged) << summary.message;
  AddStepError({motion}, options, problem, &by_step,
               PredictAllAtStep(0.5, {motion}, options, problem, summary.coordinates));
  ASSERT_TRUE(AddStepError({motion}, options, problem, &summary).is_known());
  EXPECT_FALSE(Contains(by_step.uncertainty->parameters[1], 100.0)) << by_step.uncertainty->parameters[1].upper95;
  for (std::size_t i = 0; i < 2; ++i) {
    const ParameterUncertainty& found = summary.uncertainty->parameters[i];
    EXPECT_TRUE(Contains(found, truth.at(summary.parameters[i].name))) << found.lower95 << " .. " << found.upper95;
    EXPECT_GE(found.step_error, by_step.uncertainty->parameters[i].step_error);
  }
}

TEST(DiscretizationCheckTest, CoversATruthOfAFineMeshWhereNoiseAloneDoesNot) {
  const double truth = 4e-3;
  Scene scene = SwingScene();
  scene.bending.law = BendingLaw::kEdges;  // of which k_bend belongs to the mesh
  const RecordedMotion motion = RecordFinely(scene, 1, 2, {{"k_bend", truth}});
  const FitOptions options = OptionsFor({"k_bend"});
  FitProblem problem({motion}, options);
  FitSummary summary = Fit(options, &problem);
  EXPECT_FALSE(Contains(summary.uncertainty->parameters[0], truth))
      << summary.parameters[0].value << " +- " << summary.uncertainty->parameters[0].std;
  const DiscretizationCheck check = CheckDiscretization({motion}, options, {false, true}, problem, &summary);
  ASSERT_TRUE(check.fine_mesh);
  EXPECT_FALSE(check.half_step || check.double_step);
  EXPECT_EQ(check.fine_mesh->status, FitStatus::kConverged);
  const ParameterUncertainty& widened = summary.uncertainty->parameters[0];
  EXPECT_TRUE(Contains(widened, truth));
  EXPECT_TRUE(std::isnan(widened.step_error));
  const double off = std::abs(summary.parameters[0].value - truth);
  EXPECT_GT(widened.mesh_error, off) << "order 1 is the most";
  EXPECT_LT(widened.mesh_error, 2.0 * off);
}

// All unknowns of a start are taken along to other steps. On another mesh they mean something else, also where there
// are as many.
TEST(DiscretizationCheckTest, TakesAnUnknownStartAlong) {
  RecordedMotion motion = RecordFinely(SwingScene(), 1, 0, {{"k_stretch", 150.0}});
  motion.start_source = StartSource::kRest;
  const FitOptions options = OptionsFor({"k_stretch"});
  FitProblem problem({motion}, options);
  ASSERT_GT(problem.num_start_unknowns(), 0);
  FitSummary summary = Fit(options, &problem);
  ASSERT_EQ(summary.status, FitStatus::kConverged) << summary.message;
  const RepeatedFit from_estimate = RepeatFit({motion}, options, "", problem, summary.coordinates);
  const RepeatedFit from_base = RepeatFit({motion}, options, "", problem, summary.coordinates.head(1));
  EXPECT_LT(from_estimate.statistics.rollouts, from_base.statistics.rollouts);
  EXPECT_NEAR(from_estimate.changes[0], 0.0, 1e-3);
  EXPECT_NEAR(from_base.changes[0], 0.0, 1e-3);
  const DiscretizationCheck check = CheckDiscretization({motion}, options, {true, true}, problem, &summary);
  for (const auto& fit : {check.half_step, check.double_step, check.fine_mesh}) {
    ASSERT_TRUE(fit);
    EXPECT_EQ(fit->status, FitStatus::kConverged);
  }
  EXPECT_FALSE(std::isnan(summary.uncertainty->parameters[0].step_error));
  EXPECT_FALSE(std::isnan(summary.uncertainty->parameters[0].mesh_error));
}

TEST(DiscretizationCheckTest, EndsWhereItIsCancelled) {
  const RecordedMotion motion = RecordFinely(SwingScene(), 1, 0, {{"k_bend", 4e-3}});
  FitOptions options = OptionsFor({"k_bend"});
  FitProblem problem({motion}, options);
  FitSummary summary = Fit(options, &problem);
  const double upper = summary.uncertainty->parameters[0].upper95;
  const std::atomic<bool> cancel{true};
  options.cancel = &cancel;
  const DiscretizationCheck check = CheckDiscretization({motion}, options, {true, true}, problem, &summary);
  EXPECT_FALSE(check.half_step || check.double_step || check.fine_mesh);
  EXPECT_EQ(summary.uncertainty->parameters[0].upper95, upper);
}

}  // namespace
}  // namespace clothid::discretization_check_test
