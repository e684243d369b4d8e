// Bands hold what another model does: one motion is fitted, another predicted, and the truth of both has a mesh twice
// as fine and a quarter of the steps. `tools/benchmark/measure_predictions` looks at more.
#include <gtest/gtest.h>

#include "identify/prediction/prediction.h"
#include "identify/run.h"
#include "tests/identify/fine_recordings.h"
#include "tests/temporary_folder.h"

namespace clothid::band_coverage_test {
namespace {

constexpr int kFinerSteps = 4, kFinerMeshes = 1;
const std::map<std::string, double> kTruth = {{"k_stretch", 100.0}, {"drag", 0.1}};

Scene Sheet(const std::vector<int>& handles) {
  Scene scene = ClothScene(8, 60);
  scene.solver.step_tolerance = 1e-8;
  scene.material.stretch_stiffness = 180.0;
  scene.material.bending_stiffness = 3e-4;
  scene.handles.nodes = handles;
  return scene;
}

// The share of coordinates of free nodes, after the first 50 ms, in the bands of 90 %.
double Coverage(const Prediction& prediction, const RecordedMotion& truth) {
  double num_inside = 0.0, num = 0.0;
  const Eigen::MatrixXd &low = prediction.quantiles[0], &high = prediction.quantiles[4];
  for (Eigen::Index frame = 5; frame < low.cols(); ++frame) {
    for (Eigen::Index i = 0; i < low.rows(); ++i) {
      if (!(low(i, frame) < high(i, frame))) continue;  // of a handle
      const double position = truth.positions(i, frame);
      num_inside += low(i, frame) <= position && position <= high(i, frame) ? 1.0 : 0.0;
      num += 1.0;
    }
  }
  return num_inside / num;
}

TEST(BandCoverageTest, BandsHoldMostOfWhatAFinerModelDoesElsewhere) {
  const Scene fitted = Sheet({0, 7}), other = Sheet({0, 1, 2, 3, 4, 5, 6, 7});
  const TemporaryFolder folder;
  RunOptions run;
  run.targets = {RecordFinely(fitted, kFinerSteps, kFinerMeshes, kTruth)};
  run.fit.parameters = {"k_stretch", "drag"};
  run.output = folder.File("fit");
  run.report_page = false;
  Identify(run);
  FitPosterior posterior = ReadPosterior(folder.File("fit/result.json"));
  FitToScene(other, "other", &posterior);
  ASSERT_FALSE(posterior.forces.empty());
  const RecordedMotion truth = RecordFinely(other, kFinerSteps, kFinerMeshes, kTruth, /*noise=*/1e-9);
  PredictionOptions options;
  options.num_threads = 2;
  const double all = Coverage(Predict(other, posterior, options), truth);
  options.with_step = options.with_mesh = false;
  const double with_force = Coverage(Predict(other, posterior, options), truth);
  options.with_force = false;
  const double parameters_alone = Coverage(Predict(other, posterior, options), truth);
  RecordProperty("all", std::to_string(all));
  RecordProperty("with_force", std::to_string(with_force));
  RecordProperty("parameters_alone", std::to_string(parameters_alone));
  EXPECT_GT(all, 0.85);
  EXPECT_GT(all, with_force);
  EXPECT_GT(with_force, parameters_alone + 0.05);
}

}  // namespace
}  // namespace clothid::band_coverage_test
