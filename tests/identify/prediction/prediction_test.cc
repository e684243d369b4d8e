// Bands of predictions: quantiles, shares, threads, and rollouts that fail.
#include "identify/prediction/prediction.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim/derivative/sensitivity.h"
#include "sim/rollout/simulator.h"
#include "tests/costs/synthetic_motion.h"
#include "tests/expect_error.h"

namespace clothid::prediction_test {
namespace {

PredictionOptions OfParametersAlone(int num_draws) {
  PredictionOptions options;
  options.num_draws = num_draws;
  options.with_step = options.with_mesh = false;
  return options;
}

PosteriorParameter Told(const std::string& name, double value, ParameterScale scale) {
  const bool is_log = scale == ParameterScale::kLog;
  return {name, scale, value, is_log ? 1e-6 * value : -1e6, 1e6 * std::abs(value)};
}

// k_stretch 50 N/m to 2 %, drag .1 to 4 %.
FitPosterior Small() {
  FitPosterior posterior;
  posterior.path = "result.json";
  posterior.parameters = {Told("k_stretch", 50.0, ParameterScale::kLog), Told("drag", 0.1, ParameterScale::kLog)};
  posterior.covariance = Eigen::Vector2d(4e-4, 16e-4).asDiagonal();
  return posterior;
}

// A cloth that swings passes its start: that is no end.
TEST(PredictionTest, APredictionIsWorthSomethingWhileItMissesLessThanRest) {
  Prediction prediction;
  prediction.times = Eigen::VectorXd::LinSpaced(5, 0.0, 0.4);
  prediction.moved = (Eigen::VectorXd(5) << 0.0, 2.0, 0.0, 2.0, 0.0).finished();
  prediction.spread = (Eigen::VectorXd(5) << 0.0, 1.0, 1.0, 1.0, 1.0).finished();
  EXPECT_TRUE(std::isinf(prediction.WorthUntil()));
  prediction.spread[3] = 3.0;
  EXPECT_NEAR(prediction.WorthUntil(), 0.3, 1e-12);
}

TEST(PredictionTest, ThreadsChangeNothing) {
  FitPosterior posterior = Small();
  posterior.forces = {{0.05, 0.03, 0.1}};
  PredictionOptions options;
  options.num_draws = 20;
  const Prediction one = Predict(SphereScene(), posterior, options);
  options.num_threads = 3;
  const Prediction three = Predict(SphereScene(), posterior, options);
  EXPECT_TRUE(one.has_force);
  for (std::size_t q = 0; q < kBandQuantiles.size(); ++q) EXPECT_EQ(one.quantiles[q], three.quantiles[q]);
  EXPECT_EQ(one.spread, three.spread);
  options.seed = 2;
  EXPECT_NE(Predict(SphereScene(), posterior, options).median(), one.median());
}

TEST(PredictionTest, FramesAreThoseOfTheRateAndHandlesDoNotSpread) {
  PredictionOptions options = OfParametersAlone(20);
  options.frame_rate = 40.0;  // of steps of 10 ms: every other frame is between two
  const Prediction prediction = Predict(SwingScene(), Small(), options);
  options.frame_rate = 0.0;
  const Prediction steps = Predict(SwingScene(), Small(), options);
  ASSERT_EQ(prediction.times.size(), 9);
  EXPECT_NEAR(prediction.times[3], 0.075, 1e-12);
  EXPECT_EQ(prediction.median().col(2), steps.median().col(5));
  const Eigen::VectorXd between = 0.5 * (steps.median().col(7) + steps.median().col(8));
  EXPECT_LT((prediction.median().col(3) - between).cwiseAbs().maxCoeff(), 1e-5);
  EXPECT_EQ(prediction.quantiles[0].topRows(3), prediction.quantiles[4].topRows(3)) << "of a handle";
}

// Where parameters are known well, the sampled spread is that of one sweep: the root of J Cov J^T.
TEST(PredictionTest, SmallSpreadsAreLinear) {
  PredictionOptions options = OfParametersAlone(400);
  options.num_threads = 2;
  const FitPosterior posterior = Small();
  const Scene scene = SwingScene();
  const Prediction prediction = Predict(scene, posterior, options);
  Simulator simulator(scene);
  SensitivityDirections directions;
  directions.parameters = {ParseParameter("k_stretch", scene), ParseParameter("drag", scene)};
  Eigen::VectorXd spread(scene.num_steps() + 1);
  const Eigen::Vector2d by_coordinate(50.0 * 0.02, 0.1 * 0.04);
  const auto visit = [&](int step, const Eigen::VectorXd& positions, const Eigen::MatrixXd& derivative) {
    const double num_free = static_cast<double>(positions.size() - 6);
    spread[step] = (derivative * by_coordinate.asDiagonal()).norm() / std::sqrt(num_free);
  };
  PushForward(scene.nominal_parameters(), scene.num_steps(), directions, visit, &simulator);
  for (int step = 5; step <= scene.num_steps(); step += 5) {
    EXPECT_NEAR(prediction.spread[step], spread[step], 0.1 * spread[step]) << step;
    EXPECT_GT(prediction.shares.parameters[step], 0.98) << step;
  }
}

TEST(PredictionTest, SharesSayWhatTheSpreadIsOf) {
  PredictionOptions options = OfParametersAlone(60);
  FitPosterior posterior = Small();
  posterior.covariance(1, 1) = 1e-12;
  const Prediction sure = Predict(SwingScene(), posterior, options);
  const Eigen::Index last = sure.times.size() - 1;
  EXPECT_GT(sure.shares.each(last, 0), 0.9);
  EXPECT_LT(sure.shares.each(last, 1), 0.1);
  EXPECT_LT(sure.spread[last], sure.moved[last]);
  EXPECT_TRUE(std::isinf(sure.WorthUntil()));
  posterior.forces = {{1.0, 0.05, 0.1}};
  const Prediction unsure = Predict(SwingScene(), posterior, options);
  EXPECT_GT(unsure.shares.rest[last], 0.9);
  EXPECT_GT(unsure.spread[last], 3.0 * sure.spread[last]);
  options.with_force = false;
  EXPECT_EQ(Predict(SwingScene(), posterior, options).median(), sure.median());
}

// Of a cloth that is known but for its start nothing else spreads; what handles are off by comes with time.
TEST(PredictionTest, StartAndHandlesSpread) {
  FitPosterior posterior = Small();
  posterior.covariance.setZero();
  PredictionOptions options = OfParametersAlone(40);
  EXPECT_FALSE(Predict(SwingScene(), posterior, options).has_start) << "none was fitted";
  posterior.start = LearntStart{0.001, 0.0, 0.0, 0.0};
  const Prediction start = Predict(SwingScene(), posterior, options);
  EXPECT_TRUE(start.has_start);
  EXPECT_FALSE(start.has_handles);
  EXPECT_NEAR(start.spread[0], 0.001, 3e-4);
  const Eigen::Index last = start.times.size() - 1;
  EXPECT_GT(start.shares.start[last], 0.5);
  EXPECT_GT(start.spread[last], 3e-4);
  posterior.start = LearntStart{0.0, 0.0, 0.001, 0.05};
  const Prediction handles = Predict(SwingScene(), posterior, options);
  EXPECT_TRUE(handles.has_handles);
  EXPECT_LT(handles.spread[0], 1e-12);
  EXPECT_GT(handles.spread[last], 3e-4);
  EXPECT_GT(handles.shares.handles[last], 0.5);
  EXPECT_NEAR(handles.shares.rest[last] + handles.shares.handles[last], 1.0, 0.05);
  options.with_handles = false;
  EXPECT_LT(Predict(SwingScene(), posterior, options).spread[last], 1e-12);
}

// Of a cloth whose parameters are known for sure only its steps and its mesh are not.
TEST(PredictionTest, StepAndMeshSpreadAsFarAsFinerOnesGo) {
  FitPosterior posterior = Small();
  posterior.covariance.setZero();
  Scene scene = SwingScene(), finer = SwingScene();
  finer.time_step *= 0.5;
  PredictionOptions options = OfParametersAlone(200);
  options.with_step = true;
  const Prediction prediction = Predict(scene, posterior, options);
  EXPECT_EQ(prediction.no_step, "");
  const Eigen::Index last = prediction.times.size() - 1;
  Simulator simulator(scene), finer_simulator(finer);
  const Parameters parameters = scene.nominal_parameters();
  const Eigen::VectorXd change =
      Simulate(parameters, finer.num_steps(), &finer_simulator).positions(finer.num_steps()) -
      Simulate(parameters, scene.num_steps(), &simulator).positions(scene.num_steps());
  const double expected = change.norm() / std::sqrt(static_cast<double>(change.size() - 6));
  EXPECT_NEAR(prediction.spread[last], expected, 0.1 * expected);
  EXPECT_GT(prediction.shares.finer[last], 0.99);
  options.with_mesh = true;
  EXPECT_GT(Predict(scene, posterior, options).spread[last], prediction.spread[last]);
  scene.node_force.x() = 1e-3;
  const Prediction pushed = Predict(scene, posterior, options);
  EXPECT_NE(pushed.no_mesh.find("the mesh"), std::string::npos) << pushed.no_mesh;
  EXPECT_GT(pushed.spread[last], 0.0);
}

// k_poisson is drawn beyond sqrt(k_warp k_weft) in about half of the draws: their energies are negative.
TEST(PredictionTest, RolloutsThatFailAreCountedAndNoNumbers) {
  Scene scene = SwingScene();
  scene.membrane = MembraneLaw::kOrthotropic;
  scene.material.warp_stiffness = scene.material.weft_stiffness = 50.0;
  scene.material.shear_stiffness = 25.0;
  scene.material.poisson_stiffness = 20.0;
  FitPosterior posterior;
  posterior.path = "result.json";
  posterior.parameters = {Told("k_poisson", 45.0, ParameterScale::kLinear)};
  posterior.covariance = Eigen::MatrixXd::Constant(1, 1, 100.0);
  PredictionOptions options;
  const Prediction prediction = Predict(scene, posterior, options);
  EXPECT_GT(prediction.num_failed, 5);
  EXPECT_EQ(prediction.num_draws + prediction.num_failed, options.num_draws);
  EXPECT_NE(prediction.failure.find("k_poisson"), std::string::npos) << prediction.failure;
  for (const Eigen::MatrixXd& quantile : prediction.quantiles) EXPECT_TRUE(quantile.allFinite());
  EXPECT_GT(prediction.spread.tail(1)[0], 0.0);
  posterior.parameters[0].value = 500.0;
  ExpectError([&] { Predict(scene, posterior, options); }, ErrorKind::kBadData,
              {"result.json: 50 of 50 rollouts failed", "expected at least 19"});
}

TEST(PredictionTest, RefusesDrawsThatMakeNoBands) {
  PredictionOptions options;
  options.num_draws = 18;
  ExpectError([&] { Predict(SwingScene(), Small(), options); }, ErrorKind::kUsage, {"--draws", "19 to 10000"});
  options.num_draws = 10000;
  Scene scene = ClothScene(40, 20);
  scene.duration = 1000.0;
  ExpectError([&] { Predict(scene, Small(), options); }, ErrorKind::kUsage, {"--draws", "MB", "--frame_rate"});
}

}  // namespace
}  // namespace clothid::prediction_test
