// An interval that is that of a dent of a rough cost is told from one of a smooth cost.
#include <gtest/gtest.h>

#include "identify/estimate/interval_check.h"
#include "identify/fit/fit.h"
#include "tests/costs/synthetic_motion.h"

namespace clothid::dent_check_test {
namespace {

// Of a recording of `truth`, whose k_stretch is 50, by a cloth of another bending stiffness.
FitSummary FitStretch(const Scene& truth, double bending_stiffness, double noise, double sigma) {
  MotionOptions motion_options;
  motion_options.true_values = {{"k_stretch", 50.0}};
  motion_options.noise = noise;
  motion_options.sigma = sigma;
  FitOptions options;
  options.parameters = {"k_stretch"};
  options.overrides.start["k_stretch"] = 60.0;
  options.jacobian = JacobianMethod::kSensitivity;
  options.weighs_model_error = false;  // with which such an interval is wider
  RecordedMotion motion = MakeMotion(truth, motion_options);
  motion.scene.material.bending_stiffness = bending_stiffness;
  FitProblem problem({motion}, options);
  return Fit(options, &problem);
}

// A cloth that goes on swinging for two seconds and folds as it does, since nothing damps it.
Scene LongSwing() {
  Scene scene = ClothScene(5, 400);
  scene.time_step = 0.005;
  scene.handles.nodes = {0, 4};
  scene.material.drag = 0.0;
  return scene;
}

TEST(DentCheckTest, NamesAnIntervalThatIsThatOfADent) {
  const FitSummary summary = FitStretch(LongSwing(), 1e-3, 1e-4, 1e-4);
  ASSERT_EQ(summary.status, FitStatus::kConverged) << summary.message;
  ASSERT_GT(summary.uncertainty->residual_scale, kExplainedScale);
  ASSERT_EQ(summary.dents.size(), 1u);
  EXPECT_TRUE(summary.dents[0].is_dent())
      << summary.dents[0].rise_below << " " << summary.dents[0].rise_above << " of " << summary.dents[0].expected_rise;
  EXPECT_DOUBLE_EQ(summary.dents[0].step, 0.01);
}

// Ten times more noise than the recording says: badly explained, but by a smooth cost.
TEST(DentCheckTest, FindsNoneInASmoothCost) {
  const FitSummary summary = FitStretch(SwingScene(), 2e-3, 1e-4, 1e-5);
  ASSERT_GT(summary.uncertainty->residual_scale, kExplainedScale);
  ASSERT_EQ(summary.dents.size(), 1u);
  EXPECT_FALSE(summary.dents[0].is_dent());
  EXPECT_NEAR(summary.dents[0].rise_above, summary.dents[0].expected_rise, 0.1 * summary.dents[0].expected_rise);
}

TEST(DentCheckTest, CostsNothingWhereNoiseExplainsTheError) {
  EXPECT_TRUE(FitStretch(SwingScene(), 2e-3, 1e-4, 1e-4).dents.empty());
}

}  // namespace
}  // namespace clothid::dent_check_test
