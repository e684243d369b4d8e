// What a plan expects: against closed forms, fits of noisy recordings, and what it leaves to other candidates.
#include "identify/experiment/experiment_plan.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "identify/experiment/expectation.h"
#include "identify/fit/fit.h"
#include "tests/expect_error.h"
#include "tests/identify/sensitivity_fit.h"
#include "tests/identify/simulated_recordings.h"
#include "tests/temporary_folder.h"

namespace clothid::experiment_plan_test {
namespace {

// A cloth of 6 x 6 nodes that hangs by two corners in a gusty wind.
constexpr char kWind[] = R"({
  "clothid_scene": 2, "time_step": 0.01, "duration": 0.5,
  "wind": {"mean": [0, 1.5, 0], "gust": [0, 3, 0], "frequency": 9, "wave_vector": [6, 0, 4]},
  "mesh": {"grid": {"nodes": [6, 6], "size": [0.5, 0.5], "origin": [-0.25, 0, 0], "axes": [[1, 0, 0], [0, 0, -1]]}},
  "initial": {"positions": "rest"}, "handles": [0, 5],
  "materials": {"density": 0.15, "k_stretch": 300, "k_bend": 1.5e-3, "drag": 0.3}})";
// The same that is let fall on a ball, held by a side.
constexpr char kDrape[] = R"({
  "clothid_scene": 2, "time_step": 0.01, "duration": 0.5, "contact": "gap",
  "mesh": {"grid": {"nodes": [6, 6], "size": [0.5, 0.5], "origin": [-0.25, 0, 0],
                    "axes": [[1, 0, 0], [0, 0.906307787036650, -0.422618261740699]]}},
  "initial": {"positions": "rest"}, "handles": [0, 1, 2, 3, 4, 5],
  "obstacles": [{"name": "ball", "type": "sphere", "center": [0.03, 0.25, -0.35], "radius": 0.2, "mu": 0.57}],
  "materials": {"density": 0.15, "k_stretch": 300, "k_bend": 1.5e-3, "drag": 0.05}})";
// That falls freely in 0.4 s, without a handle.
constexpr char kFall[] = R"({
  "clothid_scene": 2, "time_step": 0.01, "duration": 0.4,
  "mesh": {"grid": {"nodes": [3, 3], "size": [0.2, 0.2]}}, "initial": {"positions": "rest"},
  "materials": {"density": 0.15, "k_stretch": 300}})";

class ExperimentPlanTest : public testing::Test {
 protected:
  // Of scenes whose start is known, without further cloths.
  PlanOptions OptionsOf(const std::vector<std::string>& scenes, std::vector<std::string> parameters) const {
    PlanOptions options;
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      options.scene_paths.push_back(folder_.Write("scene" + std::to_string(i) + ".json", scenes[i]));
    }
    options.fit.parameters = std::move(parameters);
    options.sigma = 0.001;
    options.frame_rate = 50.0;
    options.start = StartSource::kScene;
    options.num_draws = 0;
    return options;
  }

  TemporaryFolder folder_;
};

const Improvement* Find(ImprovementKind kind, const CandidatePlan& candidate) {
  for (const Improvement& improvement : candidate.improvements) {
    if (improvement.kind == kind) return &improvement;
  }
  return nullptr;
}

// A fit, from the truth, of a recording with noise.
RecordedMotion NoisyRecording(const std::string& scene, double sigma, StartSource start) {
  SyntheticOptions sensor;
  sensor.noise_sigma = sigma;
  sensor.frame_rate = 50.0;
  sensor.single_precision = false;
  ReadMotionOptions reading;
  if (start != StartSource::kScene) {
    reading.start = start;
    reading.change_scene = [](const std::string& text) {
      nlohmann::ordered_json json = nlohmann::ordered_json::parse(text);
      json.erase("initial");
      return json.dump();
    };
  }
  return InterpretMotion(SimulatedText(scene, sensor), "recording", reading);
}

FitSummary FitOf(const std::vector<RecordedMotion>& motions, const FitOptions& options) {
  FitProblem problem(motions, options);
  return Fit(options, &problem);
}

// sum of t^2 over the frames at `rate` in [0, end].
double SumOfSquares(double rate, double end) {
  double sum = 0.0;
  for (int i = 0; i <= static_cast<int>(std::round(end * rate)); ++i) sum += std::pow(i / rate, 2);
  return sum;
}

// A cloth that falls freely moves by v0 t everywhere:  std(v0) = sigma/sqrt(N sum t^2).
TEST_F(ExperimentPlanTest, IsThatOfAFallInClosedForm) {
  const PlanOptions options = OptionsOf({kFall}, {"v0.z"});
  const Plan plan = PlanExperiment(options);
  ASSERT_EQ(plan.candidates[0].failure, "");
  ASSERT_EQ(plan.parameters, std::vector<std::string>{"v0.z"});
  const ExpectedParameter& v0 = plan.candidates[0].parameters[0];
  const double sum = SumOfSquares(50.0, 0.4), std = options.sigma / std::sqrt(9.0 * sum);
  EXPECT_TRUE(v0.is_told) << v0.not_told;
  EXPECT_NEAR(v0.std, std, 1e-5 * std);
  EXPECT_NEAR(v0.upper95, 1.959964 * std::hypot(v0.std, v0.step_error), 1e-6 * std);
  const CandidatePlan& fall = plan.candidates[0];
  // Bounds of +-2 m/s tell next to nothing beside that.
  EXPECT_NEAR(Find(ImprovementKind::kHalfNoise, fall)->factors[0], 0.5, 1e-5);
  EXPECT_NEAR(Find(ImprovementKind::kMoreMarkers, fall)->factors[0], std::sqrt(0.5), 1e-5);
  EXPECT_NEAR(Find(ImprovementKind::kTwiceFrames, fall)->factors[0], std::sqrt(sum / SumOfSquares(100.0, 0.4)), 1e-5);
  EXPECT_NEAR(Find(ImprovementKind::kLonger, fall)->factors[0], std::sqrt(sum / SumOfSquares(50.0, 0.6)), 1e-5);
  EXPECT_EQ(Find(ImprovementKind::kGauge, fall), nullptr) << "there is no handle";
  EXPECT_EQ(Find(ImprovementKind::kKnownStart, fall), nullptr) << "it is known";
  ASSERT_EQ(fall.map.per_frame.rows(), 21);
  for (int i = 0; i < 21; ++i) {
    EXPECT_NEAR(fall.map.per_frame(i, 0), 9.0 * std::pow(i / 50.0 / options.sigma, 2), 1e-3 + 1e-5 / (std * std));
  }
  EXPECT_NEAR(fall.map.per_node.sum(), std::pow(std, -2), 1e-5 * std::pow(std, -2));
  EXPECT_NEAR(fall.map.per_node.maxCoeff(), fall.map.per_node.minCoeff(), 1e-5 * std::pow(std, -2));
}

TEST_F(ExperimentPlanTest, ScalesWithSigmaAndAddsPriors) {
  PlanOptions options = OptionsOf({kWind}, {"k_stretch"});
  const double std = PlanExperiment(options).candidates[0].parameters[0].std;
  options.sigma *= 2.0;
  EXPECT_NEAR(PlanExperiment(options).candidates[0].parameters[0].std, 2.0 * std, 1e-5 * std);
  options.sigma /= 2.0;
  options.fit.overrides.priors["k_stretch"] = {300.0, std::exp(std)};  // as sure as the recording
  EXPECT_NEAR(PlanExperiment(options).candidates[0].parameters[0].std, std / std::sqrt(2.0), 1e-4 * std);
}

TEST_F(ExperimentPlanTest, ForetellsWhatAFitSays) {
  for (const StartSource start : {StartSource::kScene, StartSource::kRest}) {
    PlanOptions options = OptionsOf({kWind, kDrape}, {"k_stretch", "k_bend"});
    options.start = start;
    const Plan plan = PlanExperiment(options);
    const std::string scenes[] = {kWind, kDrape};
    for (int i = 0; i < 2; ++i) {
      FitOptions fit = OptionsFor(options.fit.parameters);
      fit.weighs_model_error = false;
      const FitSummary summary = FitOf({NoisyRecording(scenes[i], options.sigma, start)}, fit);
      ASSERT_TRUE(summary.uncertainty) << summary.message;
      for (int k = 0; k < 2; ++k) {
        const double told = summary.uncertainty->parameters[k].independent_std / summary.uncertainty->residual_scale;
        EXPECT_NEAR(plan.candidates[i].parameters[k].std / told, 1.0, 0.05)
            << plan.candidates[i].name << " " << plan.parameters[k] << ", start " << static_cast<int>(start);
      }
    }
  }
}

TEST_F(ExperimentPlanTest, PairsAreJointFits) {
  PlanOptions options = OptionsOf({kWind, kDrape}, {"k_stretch", "k_bend", "mu"});
  options.fit.overrides.priors["k_stretch"] = {300.0, 1.01};
  const Plan plan = PlanExperiment(options);
  ASSERT_EQ(plan.pairs.size(), 1u);
  FitOptions fit = OptionsFor(options.fit.parameters);
  fit.overrides = options.fit.overrides;
  fit.weighs_model_error = false;
  const FitSummary joint = FitOf({NoisyRecording(kWind, options.sigma, StartSource::kScene),
                                  NoisyRecording(kDrape, options.sigma, StartSource::kScene)},
                                 fit);
  ASSERT_TRUE(joint.uncertainty) << joint.message;
  ASSERT_EQ(plan.pairs[0].parameters.size(), 3u);
  for (int k = 0; k < 3; ++k) {
    const ExpectedParameter& expected = plan.pairs[0].parameters[k];
    ASSERT_EQ(expected.name, joint.parameters[k].name);
    EXPECT_NEAR(expected.std / joint.uncertainty->parameters[k].independent_std, 1.0, 0.08) << expected.name;
  }
  const CandidatePlan& wind = plan.candidates[0];
  EXPECT_EQ(wind.parameters[2].not_told, "its scene does not have it");
  const Improvement* both = Find(ImprovementKind::kBothScenes, wind);
  ASSERT_NE(both, nullptr);
  EXPECT_EQ(both->tells, std::vector<std::string>{"mu"});
  for (int k = 0; k < 2; ++k) EXPECT_LE(both->factors[k], 1.0 + 1e-9) << plan.parameters[k];
}

TEST_F(ExperimentPlanTest, NamesWhatIsNotToldAndWhatTellsIt) {
  const std::vector<std::string> all = {"k_stretch", "k_bend", "density", "drag"};
  const PlanOptions options = OptionsOf({kWind}, all);
  const Plan plan = PlanExperiment(options);
  const FitSummary fit = FitOf({NoisyRecording(kWind, options.sigma, StartSource::kScene)}, OptionsFor(all));
  ASSERT_TRUE(fit.uncertainty) << fit.message;
  for (int k = 0; k < 4; ++k) {
    const ExpectedParameter& expected = plan.candidates[0].parameters[k];
    EXPECT_FALSE(expected.is_told) << expected.name;
    EXPECT_FALSE(fit.uncertainty->parameters[k].identifiable) << expected.name;
    EXPECT_TRUE(std::isnan(expected.std) && std::isnan(expected.lower95));
    EXPECT_EQ(expected.made_up_by, "k_stretch, k_bend, density and drag multiplied by one factor");
  }
  EXPECT_EQ(plan.candidates[0].improvements.front().kind, ImprovementKind::kGauge);
  EXPECT_EQ(plan.candidates[0].improvements.front().tells, all);
  EXPECT_NEAR(Find(ImprovementKind::kHalfNoise, plan.candidates[0])->worst, 1.0, 0.01) << "of no use";
}

TEST_F(ExperimentPlanTest, FrictionWithoutContactIsNotTold) {
  std::string far = kDrape;
  far.replace(far.find("-0.35]"), 6, "-9.35]");
  const Plan plan = PlanExperiment(OptionsOf({far}, {"mu", "k_stretch"}));
  EXPECT_FALSE(plan.candidates[0].parameters[0].is_told);
  EXPECT_EQ(plan.candidates[0].parameters[0].not_told, "between its bounds it moves unseen");
  EXPECT_EQ(plan.candidates[0].parameters[0].made_up_by, "");
  EXPECT_EQ(plan.candidates[0].worst_told, 0);
  for (const Improvement& improvement : plan.candidates[0].improvements) EXPECT_NEAR(improvement.worst, 1.0, 1e-9);
  EXPECT_TRUE(plan.candidates[0].parameters[1].is_told);
}

// Markers, forces, a start that is estimated, cloths that are drawn, and a candidate that fails.
TEST_F(ExperimentPlanTest, IsTheSameOnAnyNumberOfThreads) {
  std::string torn = kDrape;
  torn.insert(torn.size() - 1, R"(, "solver": {"max_newton_iterations": 1, "max_substep_halvings": 0})");
  PlanOptions options = OptionsOf({kDrape, torn, kWind}, {"mu", "k_bend"});
  options.start = StartSource::kEstimated;
  options.num_draws = 2;
  options.num_markers = 10;
  options.has_forces = true;
  options.output = folder_.File("out");
  const Plan plan = PlanExperiment(options);
  options.fit.num_threads = 2;
  EXPECT_EQ(PlanJson(options, PlanExperiment(options)), PlanJson(options, plan));
  EXPECT_EQ(ReadFile(options.output + "/plan.json", kMaxJsonBytes), PlanJson(options, plan));
  EXPECT_NE(plan.candidates[1].failure, "");
  EXPECT_EQ(plan.candidates[0].num_cloths, 3);
  EXPECT_EQ(plan.candidates[0].num_points, 10);
  ASSERT_EQ(plan.pairs.size(), 1u);
  EXPECT_EQ(plan.pairs[0].second, 2);
  EXPECT_GT(plan.candidates[0].map.of_forces.minCoeff(), 0.0);
  EXPECT_LT(Find(ImprovementKind::kKnownStart, plan.candidates[0])->worst, 1.0);
  const std::string table = PlanTable(plan);
  EXPECT_NE(table.find("scene1: failed: "), std::string::npos) << table;
  EXPECT_NE(table.find("scene0 and scene2:\n"), std::string::npos) << table;
}

TEST_F(ExperimentPlanTest, NothingIsBestWhereAllFail) {
  std::string torn = kDrape;
  torn.insert(torn.size() - 1, R"(, "solver": {"max_newton_iterations": 1, "max_substep_halvings": 0})");
  const Plan plan = PlanExperiment(OptionsOf({torn}, {"mu"}));
  EXPECT_FALSE(plan.has_any());
  EXPECT_EQ(PlanTable(plan).rfind("scene0: failed: ", 0), 0u) << PlanTable(plan);
  EXPECT_EQ(PlanTable(plan).find("best"), std::string::npos) << PlanTable(plan);
}

// By noise alone either cloth tells the stiffness within 1 %.
TEST_F(ExperimentPlanTest, ToldIsNeitherWhatTheStepTakesNorADent) {
  ParameterBlock block;
  block.name = "k_stretch";
  block.scale = ParameterScale::kLog;
  block.start = 100.0;
  block.lower_bound = 1.0;
  block.upper_bound = 1e4;
  ClothRows cloth;
  cloth.blocks = {block};
  cloth.coordinates = Eigen::VectorXd::Constant(1, block.ToCoordinate(block.start));
  cloth.rows = Eigen::MatrixXd::Constant(1, 1, 100.0);
  cloth.num_measurements = 1000;
  const double most = BelievedStd(block) / 3.0;
  const auto expected = [&](double step) {
    return Expectation({cloth}, Eigen::VectorXd::Constant(1, step)).Parameter(0);
  };
  EXPECT_TRUE(expected(0.99 * most).is_told);
  EXPECT_NEAR(std::log(expected(0.1).upper95 / 100.0), 1.96 * std::hypot(0.01, 0.1), 1e-3);
  EXPECT_FALSE(expected(1.01 * most).is_told);
  EXPECT_EQ(expected(1.01 * most).not_told, "the error of the time step leaves nothing of it");
  cloth.rough = {0};
  EXPECT_FALSE(expected(0.0).is_told);
  EXPECT_EQ(expected(0.0).not_told.rfind("its cost is rough", 0), 0u);
  EXPECT_EQ(expected(0.0).share_of_belief, 1.0);
}

TEST_F(ExperimentPlanTest, RefusesWhatItCannotPlan) {
  const PlanOptions good = OptionsOf({kWind, kDrape}, {"k_stretch"});
  const auto refused = [&](auto change, ErrorKind kind, std::initializer_list<const char*> words) {
    PlanOptions options = good;
    options.output = folder_.File("none");
    change(&options);
    ExpectError([&] { PlanExperiment(options); }, kind, words);
    EXPECT_FALSE(std::filesystem::exists(folder_.File("none")));
  };
  refused([](PlanOptions* o) { o->fit.parameters = {"k_strech"}; }, ErrorKind::kUsage, {"k_strech"});
  refused([](PlanOptions* o) { o->scene_paths[1] = "missing.json"; }, ErrorKind::kIo, {"missing.json"});
  refused([](PlanOptions* o) { o->sigma = -0.001; }, ErrorKind::kUsage, {"--sigma", "> 0"});
  refused([](PlanOptions* o) { o->num_markers = 35; }, ErrorKind::kUsage, {"--markers 35", "34 free nodes"});
  refused([](PlanOptions* o) { o->frame_rate = 1.0; }, ErrorKind::kUsage, {"scene0.json", "two frames"});
  refused([](PlanOptions* o) { o->start = StartSource::kFirstFrame; }, ErrorKind::kUsage, {"--initial"});
  refused(
      [](PlanOptions* o) {
        o->fit.overrides.priors["mu"] = {0.3, 0.1};
      },
      ErrorKind::kUsage, {"--prior", "'mu'", "not among the fitted"});
  refused([](PlanOptions* o) { o->output = o->scene_paths[0]; }, ErrorKind::kIo, {"scene0.json"});
}

}  // namespace
}  // namespace clothid::experiment_plan_test
