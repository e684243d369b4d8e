// Parameters are found again from unordered points of the surface, with noise and with outliers; and all that a fit
// writes and keeps works with them.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "datasets/synthetic/synthetic.h"
#include "identify/checks/holdout.h"
#include "identify/fit/fit.h"
#include "identify/report/report.h"
#include "sim/base/json_document.h"
#include "sim/base/text_file.h"
#include "sim/scene/scene_json.h"
#include "tests/costs/synthetic_clouds.h"
#include "tests/costs/synthetic_motion.h"
#include "tests/temporary_folder.h"

namespace clothid::cloud_fit_test {
namespace {

constexpr double kTrueMu = 0.24, kTrueStretch = 70.0;

FitOptions WithLoss(const std::string& loss) {
  FitOptions options;
  options.loss = ParseRobustLoss(loss);
  return options;
}

FitSummary RunFit(const RecordedMotion& motion, const FitOptions& options) {
  FitProblem problem({motion}, options);
  return Fit(options, &problem);
}

// The shipped scene `drape`, as a camera sees it that follows nothing: 150 points per frame with 2 mm of noise.
class DrapeCloudTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    const std::string path = CLOTHID_SOURCE_DIR "/datasets/drape.scene.json";
    const std::string text = ReadFile(path, kMaxJsonBytes);
    Scene scene = ParseScene(text, path, "");
    Parameters truth = scene.nominal_parameters();
    SetParameter(ParseParameter("mu", scene.obstacle_names()), kTrueMu, &truth);
    SetParameter(ParseParameter("k_stretch", scene.obstacle_names()), kTrueStretch, &truth);
    Simulator simulator(scene);
    const Rollout rollout = Simulate(truth, scene.num_steps(), &simulator);
    ASSERT_TRUE(rollout.ok()) << rollout.failure->ToString();
    SyntheticOptions options;
    options.num_cloud_points = 150;
    options.noise_sigma = 2e-3;
    const TemporaryFolder folder;
    WriteMotion(RecordRollout(rollout, scene, text, options), folder.File("drape.bin"));
    motion_ = ReadMotion(folder.File("drape.bin"));
  }

  static void ExpectTruthWithin(double share, const FitSummary& summary) {
    RecordProperty("relative_error", std::to_string(RelativeError(summary)));
    EXPECT_EQ(summary.status, FitStatus::kConverged) << summary.message;
    ASSERT_EQ(summary.parameters.size(), 2U);
    EXPECT_NEAR(summary.parameters[0].value, kTrueMu, share * kTrueMu);
    EXPECT_NEAR(summary.parameters[1].value, kTrueStretch, share * kTrueStretch);
  }

  // Of the parameter that is farther off.
  static double RelativeError(const FitSummary& summary) {
    return std::max(std::abs(summary.parameters[0].value / kTrueMu - 1.0),
                    std::abs(summary.parameters[1].value / kTrueStretch - 1.0));
  }

  // Every tenth point is moved by up to 0.2 m along every axis.
  static RecordedMotion WithOutliers() {
    RecordedMotion motion = motion_;
    std::mt19937_64 generator(5);
    std::uniform_real_distribution<double> uniform(-0.2, 0.2);
    for (Eigen::Matrix3Xd& cloud : motion.clouds) {
      for (Eigen::Index i = 0; i < cloud.cols(); i += 10) {
        for (int axis = 0; axis < 3; ++axis) cloud(axis, i) += uniform(generator);
      }
    }
    return motion;
  }

  static RecordedMotion motion_;
};

RecordedMotion DrapeCloudTest::motion_;

TEST_F(DrapeCloudTest, FrictionAndStiffnessAreFoundFromTheNominalStart) {
  const FitSummary summary = RunFit(motion_, WithLoss("none"));
  ExpectTruthWithin(0.03, summary);
  // Of the noise that is left the surface sees the part along its normal.
  EXPECT_NEAR(summary.error.rmse(), 2e-3, 2e-4);
  EXPECT_LT(summary.error.rmse(), 0.7 * summary.start_error.rmse());
  EXPECT_LT(summary.error.cloud.num_far, 0.001 * summary.error.cloud.num_points);
  EXPECT_TRUE(std::isnan(summary.error.fit_percent()));
  ASSERT_TRUE(summary.uncertainty.has_value());
  for (const ParameterUncertainty& parameter : summary.uncertainty->parameters) {
    EXPECT_TRUE(parameter.identifiable);
    EXPECT_GT(parameter.std, 0.0);
  }
}

TEST_F(DrapeCloudTest, OutliersNeedALoss) {
  const RecordedMotion motion = WithOutliers();
  FitOptions huber = WithLoss("huber:2"), none = WithLoss("none");
  huber.growing_horizon = none.growing_horizon = false;
  huber.assimilate = none.assimilate = ParseAssimilation("off");
  none.max_iterations = 8;  // it does not come nearer to the truth with more
  const FitSummary robust = RunFit(motion, huber), squares = RunFit(motion, none);
  ExpectTruthWithin(0.03, robust);
  EXPECT_GT(RelativeError(squares), 2.0 * RelativeError(robust));
  EXPECT_GT(robust.error.cloud.num_far, 0.05 * robust.error.cloud.num_points);
}

// A small cloth on a ball with clouds, and beside them its nodes where `keep_points`.
RecordedMotion SphereClouds(bool keep_points) {
  MotionOptions options;
  options.true_values = {{"mu", 0.35}, {"k_stretch", 90.0}};
  options.sigma = 1e-3;
  RecordedMotion motion = MakeMotion(SphereScene(), options);
  AddClouds(60, 1e-3, keep_points, &motion);
  motion.cloud_sigma = 1e-3;
  return motion;
}

TEST(CloudFitTest, EveryMethodFindsTheSameWithBothKindsOfPoints) {
  FitOptions options;
  const FitSummary adjoint = RunFit(SphereClouds(true), options);
  ASSERT_EQ(adjoint.status, FitStatus::kConverged) << adjoint.message;
  EXPECT_NEAR(adjoint.parameters[0].value, 0.35, 0.03 * 0.35);
  EXPECT_NEAR(adjoint.parameters[1].value, 90.0, 0.03 * 90.0);
  EXPECT_FALSE(std::isnan(adjoint.error.fit_percent()));
  for (const JacobianMethod method : {JacobianMethod::kSensitivity, JacobianMethod::kNumeric}) {
    options.jacobian = method;
    const FitSummary other = RunFit(SphereClouds(true), options);
    EXPECT_LT((other.values() - adjoint.values()).cwiseQuotient(adjoint.values()).norm(), 1e-4);
  }
}

TEST(CloudFitTest, AJournalReplaysToTheSameBits) {
  const TemporaryFolder folder;
  FitOptions options;
  options.journal_folder = folder.path();
  const FitSummary first = RunFit(SphereClouds(false), options), second = RunFit(SphereClouds(false), options);
  ASSERT_EQ(first.status, FitStatus::kConverged) << first.message;
  EXPECT_EQ(first.coordinates, second.coordinates);
  EXPECT_EQ(first.predicted[0], second.predicted[0]);
  EXPECT_EQ(first.statistics.rollouts, second.statistics.rollouts);
  EXPECT_EQ(first.error.cloud.squared_distance, second.error.cloud.squared_distance);
}

TEST(CloudFitTest, ThePredictionIsWrittenAsTheNodes) {
  for (const bool keep_points : {false, true}) {
    RecordedMotion motion = SphereClouds(keep_points);
    motion.scene_text = R"({"clothid_scene": 1, "handles": [0, 1, 2, 3, 4]})";
    const FitSummary summary = RunFit(motion, FitOptions());
    const TemporaryFolder folder;
    WriteMotion(PredictedMotion(motion, summary.predicted[0], summary.parameters), folder.File("predicted.bin"));
    const MotionTensors predicted = ReadMotionTensors(folder.File("predicted.bin"));
    EXPECT_EQ(predicted.positions.rows(), 3 * motion.scene.mesh.num_nodes());
    EXPECT_EQ(predicted.positions.col(0), motion.scene.initial_positions);
    EXPECT_TRUE(predicted.clouds.empty());
  }
}

TEST(CloudFitTest, FramesOfCloudsAreHeldOut) {
  std::vector<RecordedMotion> motions = {SphereClouds(false)};
  const std::vector<RecordedMotion> held = HoldOutFrames({5, 8}, &motions);
  for (int i = 0; i < motions[0].num_frames(); ++i) {
    const bool is_held = i >= 5 && i < 8;
    EXPECT_EQ(held[0].clouds[i].cols(), is_held ? 60 : 0);
    EXPECT_EQ(motions[0].clouds[i].cols(), is_held ? 0 : 60);
  }
  EXPECT_EQ(Observation(held[0]).num_residuals(), 180);
}

}  // namespace
}  // namespace clothid::cloud_fit_test
