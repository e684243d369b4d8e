// Points that slide over the cloth from frame to frame: taken for points of the surface they tell its constants, taken
// for material points they mislead.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "identify/checks/holdout.h"
#include "identify/fit/fit.h"
#include "identify/report/report.h"
#include "tests/costs/synthetic_clouds.h"
#include "tests/costs/synthetic_motion.h"

namespace clothid::surface_fit_test {
namespace {

constexpr double kTrueStretch = 90.0, kTrueBend = 1e-3;

// The swinging cloth of 5 x 5 nodes, re-gridded in every frame: no point is seen where it was before.
RecordedMotion SlidingMotion(bool borders) {
  MotionOptions options;
  options.true_values = {{"k_stretch", kTrueStretch}, {"k_bend", kTrueBend}};
  options.sigma = 1e-3;
  RecordedMotion motion = MakeMotion(SwingScene(), options);
  SlidePoints(borders, 21, &motion);
  return motion;
}

RecordedMotion TakenForMaterial(RecordedMotion motion) {
  for (ObservedPoint& point : motion.points) point.kind = PointKind::kMaterial;
  return motion;
}

FitSummary RunFit(const RecordedMotion& motion, FitOptions options = {}) {
  options.parameters = {"k_stretch", "k_bend"};
  FitProblem problem({motion}, options);
  return Fit(options, &problem);
}

double RelativeError(const FitSummary& summary) {
  return std::max(std::abs(summary.parameters[0].value / kTrueStretch - 1.0),
                  std::abs(summary.parameters[1].value / kTrueBend - 1.0));
}

TEST(SurfaceFitTest, ConstantsAreFoundFromPointsThatSlide) {
  for (const bool borders : {false, true}) {
    const FitSummary surface = RunFit(SlidingMotion(borders));
    EXPECT_EQ(surface.status, FitStatus::kConverged) << surface.message;
    EXPECT_LT(RelativeError(surface), 1e-4) << "borders: " << borders;
    EXPECT_LT(surface.error.rmse(), 1e-7);
    EXPECT_EQ(surface.error.cloud.num_border > 0.0, borders);
    EXPECT_GT(surface.error.cloud.node_rmse(), 0.01);  // they slide by a part of the 75 mm between nodes
    const FitSummary nodes = RunFit(TakenForMaterial(SlidingMotion(borders)));
    EXPECT_GT(RelativeError(nodes), 0.02) << "borders: " << borders;
    RecordProperty(borders ? "borders" : "surface", std::to_string(RelativeError(surface)));
    RecordProperty(borders ? "nodes_with_borders" : "nodes", std::to_string(RelativeError(nodes)));
  }
}

TEST(SurfaceFitTest, EveryMethodFindsTheSame) {
  RecordedMotion motion = SlidingMotion(/*borders=*/true);
  std::mt19937_64 generator(4);
  std::normal_distribution<double> normal(0.0, 1e-3);
  for (double& position : motion.positions.reshaped()) position += normal(generator);
  FitOptions options;
  const FitSummary adjoint = RunFit(motion, options);
  EXPECT_EQ(adjoint.status, FitStatus::kConverged) << adjoint.message;
  EXPECT_LT(RelativeError(adjoint), 0.1);
  for (const JacobianMethod method : {JacobianMethod::kSensitivity, JacobianMethod::kNumeric}) {
    options.jacobian = method;
    const FitSummary other = RunFit(motion, options);
    EXPECT_LT((other.values() - adjoint.values()).cwiseQuotient(adjoint.values()).norm(), 1e-4);
  }
}

TEST(SurfaceFitTest, ReportTellsBothErrors) {
  RecordedMotion motion = SlidingMotion(/*borders=*/true);
  motion.scene_text = R"({"clothid_scene": 1, "handles": [0, 4]})";
  const FitSummary summary = RunFit(motion);
  const MotionTensors predicted = PredictedMotion(motion, summary.predicted[0], summary.parameters);
  EXPECT_EQ(predicted.positions.rows(), 3 * motion.scene.mesh.num_nodes());
  EXPECT_TRUE(predicted.point_kind.empty());
  std::vector<RecordedMotion> motions = {motion};
  const std::vector<RecordedMotion> held = HoldOutFrames({5, 8}, &motions);
  EXPECT_EQ(Observation(held[0]).num_residuals(), 3 * (25 - 2 + 14));  // both handles are corners of the border
  const std::vector<ParameterBlock> blocks = MakeBlocks(motion.scene, {"k_stretch", "k_bend"});
  const Holdout holdout = EvaluateHoldout(held, blocks, summary.values(), HeldOut::kFrames);
  EXPECT_LT(holdout.rmse, 1e-6);
  EXPECT_GT(holdout.nodes_rmse, 0.01);
}

}  // namespace
}  // namespace clothid::surface_fit_test
