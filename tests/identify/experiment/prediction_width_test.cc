// How wide a prediction would be by what a motion tells: against differences, and against predictions by fits.
#include "identify/experiment/prediction_width.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "datasets/motion/motion_file.h"
#include "identify/experiment/cloth_information.h"
#include "identify/experiment/experiment_plan.h"
#include "identify/prediction/prediction.h"
#include "identify/run.h"
#include "sim/base/text_file.h"
#include "sim/rollout/rollout.h"
#include "sim/rollout/simulator.h"
#include "sim/scene/scene_json.h"
#include "tests/expect_error.h"
#include "tests/identify/simulated_recordings.h"
#include "tests/temporary_folder.h"

namespace clothid::prediction_width_test {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kSigma = 2e-3;  // m

// A cloth of 5 x 5 nodes that swings down, held by `handles`.
Json Swing(const std::vector<int>& handles, double duration) {
  return {{"clothid_scene", 2},
          {"time_step", 0.01},
          {"duration", duration},
          {"mesh", {{"grid", {{"nodes", {5, 5}}, {"size", {0.3, 0.3}}}}}},
          {"initial", {{"positions", "rest"}}},
          {"handles", handles},
          {"materials", {{"density", 0.2}, {"k_stretch", 60}, {"k_bend", 1e-4}, {"drag", 0.1}}}};
}

const std::vector<int> kEdge = {0, 1, 2, 3, 4}, kCorners = {0, 4};

class PredictionWidthTest : public testing::Test {
 protected:
  PlanOptions OptionsOf(const std::vector<Json>& scenes, const Json& predicted) const {
    PlanOptions options;
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      options.scene_paths.push_back(folder_.Write("motion" + std::to_string(i) + ".json", scenes[i].dump()));
    }
    options.predicted_path = folder_.Write("other.json", predicted.dump());
    options.fit.parameters = {"k_stretch", "drag"};
    options.sigma = kSigma;
    options.start = StartSource::kScene;
    options.num_draws = 0;
    return options;
  }

  // The root mean square, over coordinates of free nodes and steps, of the spread of rollouts with parameters of a fit
  // of one noisy recording, m.
  double WidthOfFit(const Json& scene, const Scene& predicted, int number) const {
    SyntheticOptions sensor;
    sensor.noise_sigma = kSigma;
    sensor.seed = static_cast<std::uint64_t>(number) + 1;
    RunOptions run;
    run.target_paths = {folder_.File("recorded" + std::to_string(number) + ".bin")};
    WriteMotion(SimulatedText(scene.dump(), sensor), run.target_paths[0]);
    run.fit.parameters = {"k_stretch", "drag"};
    run.fit.assimilate = {};
    const RunResult result = Identify(run);
    const FitPosterior posterior = PosteriorOf(result.summary, {});
    PredictionOptions options;
    options.num_draws = 100;
    SetSources("parameters", "--sources", &options);
    const Eigen::VectorXd spread = Predict(predicted, posterior, options).spread;
    return std::sqrt(spread.tail(spread.size() - 1).squaredNorm() / static_cast<double>(spread.size() - 1));
  }

  TemporaryFolder folder_;
};

// With one parameter all is the difference of two rollouts, times what is not known of it.
TEST_F(PredictionWidthTest, OneParameterSpreadsByItsDifference) {
  PlanOptions options = OptionsOf({Swing(kEdge, 0.3)}, Swing(kCorners, 0.3));
  options.fit.parameters = {"drag"};
  const Candidate candidate = ReadPredicted(options);
  const MotionToPredict predicted(candidate);
  const auto roll = [&](double drag) {
    Scene scene = candidate.scene;
    scene.material.drag = drag;
    Simulator simulator(scene);
    return Simulate(scene.nominal_parameters(), scene.num_steps(), &simulator, nullptr);
  };
  constexpr double kChange = 1e-4;  // of the logarithm
  const Rollout more = roll(0.1 * std::exp(kChange)), less = roll(0.1 * std::exp(-kChange));
  double squares = 0.0;
  for (int step = 1; step <= 30; ++step) {
    squares += (more.records[static_cast<std::size_t>(more.last_record[step - 1])].positions -
                less.records[static_cast<std::size_t>(less.last_record[step - 1])].positions)
                   .squaredNorm();
  }
  const double by_logarithm = std::sqrt(squares / (30.0 * 3.0 * 23.0)) / (2.0 * kChange);
  EXPECT_NEAR(predicted.BelievedWidth(), by_logarithm * StdBefore(candidate.blocks[0]),
              1e-4 * predicted.BelievedWidth());
  const Plan plan = PlanExperiment(options);
  const ExpectedParameter& drag = plan.candidates[0].parameters[0];
  EXPECT_NEAR(plan.candidates[0].prediction_width, by_logarithm * std::hypot(drag.std, drag.step_error),
              0.01 * plan.candidates[0].prediction_width);
}

double RankCorrelation(const std::vector<double>& a, const std::vector<double>& b) {
  const auto rank = [](const std::vector<double>& values) {
    Eigen::VectorXd ranks(static_cast<Eigen::Index>(values.size()));
    for (Eigen::Index i = 0; i < ranks.size(); ++i) {
      ranks[i] = static_cast<double>(std::count_if(
          values.begin(), values.end(), [&](double other) { return other < values[static_cast<std::size_t>(i)]; }));
    }
    return Eigen::VectorXd(ranks.array() - ranks.mean());
  };
  const Eigen::VectorXd x = rank(a), y = rank(b);
  return x.dot(y) / (x.norm() * y.norm());
}

TEST_F(PredictionWidthTest, MotionsAreRankedAsTheirFitsPredict) {
  const Json predicted = Swing({0}, 0.4);
  const std::vector<Json> scenes = {Swing(kEdge, 0.08),   Swing(kEdge, 0.15),   Swing(kEdge, 0.3),
                                    Swing(kCorners, 0.2), Swing(kCorners, 0.5), Swing({0}, 0.3)};
  PlanOptions options = OptionsOf(scenes, predicted);
  options.output = folder_.File("plan");
  const Plan plan = PlanExperiment(options);
  const Scene scene = ParseScene(predicted.dump(), "other.json", "");
  std::vector<double> planned, fitted;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    planned.push_back(plan.candidates[i].prediction_width);
    EXPECT_LT(planned[i], plan.believed_width);
    fitted.push_back(WidthOfFit(scenes[i], scene, static_cast<int>(i)));
    RecordProperty("planned" + std::to_string(i), std::to_string(planned[i]));
    RecordProperty("fitted" + std::to_string(i), std::to_string(fitted[i]));
  }
  EXPECT_GE(RankCorrelation(planned, fitted), 0.9);
  for (const PairPlan& pair :
       plan.pairs) {  // of a joint fit the error of the step may be larger than that of the better
    EXPECT_LT(pair.prediction_width,
              std::max(planned[static_cast<std::size_t>(pair.first)], planned[static_cast<std::size_t>(pair.second)]));
  }
  const Json told = Json::parse(ReadFile(folder_.File("plan/plan.json"), kMaxJsonBytes));
  EXPECT_EQ(told["prediction"]["name"], "other");
  EXPECT_EQ(told["prediction"]["believed_width_m"].get<double>(), plan.believed_width);
  EXPECT_EQ(told["candidates"][1]["prediction_width_m"].get<double>(), planned[1]);
  EXPECT_NE(PlanTable(plan).find("best              prediction of other"), std::string::npos) << PlanTable(plan);
}

TEST_F(PredictionWidthTest, AMotionThatHasNoneOfTheParametersIsRefused) {
  PlanOptions options = OptionsOf({Swing(kEdge, 0.1)}, Swing(kCorners, 0.1));
  options.fit.parameters = {"k_warp"};
  ExpectError([&] { MotionToPredict(ReadPredicted(options)); }, ErrorKind::kBadData, {"other.json", "some of"});
}

}  // namespace
}  // namespace clothid::prediction_width_test
