// `benchmark coverage`: the 95 % intervals of a fit contain the truth as often as they say, and the reported standard
// deviations are those of the estimates.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "sim/scene/scene_json.h"
#include "tests/tools/small_drape.h"
#include "tests/tools/tool_test.h"
#include "tools/benchmark/fits/benchmark_coverage.h"

namespace clothid::coverage_test {
namespace {

namespace fs = std::filesystem;

class CoverageTest : public ToolTest {
 protected:
  // Forty noisy recordings of a small `drape`. The whole one takes ten times as long: `benchmark coverage --seeds 40`.
  void ExpectIntervalsAreRight(const std::string& setting) const {
    CoverageOptions options = SmallOptions(9);
    options.settings = {setting};
    options.num_seeds = 40;
    const CoverageBenchmark benchmark = RunCoverageBenchmark(options);
    ASSERT_EQ(benchmark.fits.size(), 40u);
    for (const CoverageFit& fit : benchmark.fits) {
      EXPECT_EQ(fit.status, FitStatus::kConverged) << "seed " << fit.seed;
    }
    const std::vector<CoverageSummary> summaries = SummarizeCoverage(benchmark);
    ASSERT_EQ(summaries.size(), 2u);
    for (const CoverageSummary& summary : summaries) {
      EXPECT_GE(summary.coverage(), 0.85) << summary.name;
      EXPECT_GE(summary.std_ratio(), 0.75) << summary.name;
      EXPECT_LE(summary.std_ratio(), 1.35) << summary.name;
      // Three standard errors of the mean of forty.
      EXPECT_LE(std::abs(summary.bias), 3.0 * summary.empirical_std / std::sqrt(40.0)) << summary.name;
    }
  }

  CoverageOptions SmallOptions(int n = 6) const {
    WriteBytes(folder() / "scene.json", SmallDrape(n));
    CoverageOptions options;
    options.scene_path = (folder() / "scene.json").string();
    options.truth = {{"mu", 0.24}, {"k_stretch", 70.0}};
    options.num_seeds = 2;
    return options;
  }

  // The scene of `tools/benchmark/README.md` with unknowns of every kind, on a mesh of 6 x 6 nodes. Its recording
  // begins in motion, when the profile of its wind does, and shows neither start nor handles exactly.
  CoverageOptions UnknownsOptions() const {
    const fs::path source = fs::path(CLOTHID_SOURCE_DIR) / "tools/benchmark/unknowns";
    auto scene = nlohmann::ordered_json::parse(ReadBytes(source / "scene.json"));
    scene["mesh"]["grid"]["nodes"] = {6, 6};
    scene["handles"]["nodes"] = {0, 5};
    WriteBytes(folder() / "unknowns.json", scene.dump());
    WriteBytes(folder() / "path.csv", ReadBytes(source / "path.csv"));
    CoverageOptions options;
    options.scene_path = (folder() / "unknowns.json").string();
    options.truth = {{"k_stretch", 60.0}, {"k_bend", 1.5e-3}};
    options.settings = {"full"};
    options.sigma = 1e-3;
    options.force_sigma = 0.01;
    options.num_seeds = 2;
    return options;
  }

  // The recording begins in motion, when the profile of the wind does, and shows neither start nor handles exactly.
  static void ForgetStart(CoverageOptions* options) {
    options->import = {StartSource::kMoving, /*cut=*/0.2, /*handle_sigma=*/2e-4};
  }

  // Of every unknown of every fit: it has an interval, and is as near to the truth as that says.
  static void ExpectTruthIsFound(const CoverageBenchmark& benchmark, std::size_t num_unknowns) {
    ASSERT_EQ(benchmark.truth.size(), num_unknowns);
    for (const CoverageFit& fit : benchmark.fits) {
      EXPECT_EQ(fit.status, FitStatus::kConverged) << "seed " << fit.seed;
      ASSERT_EQ(fit.value.size(), num_unknowns);
      for (std::size_t i = 0; i < num_unknowns; ++i) {
        const TrueParameter& truth = benchmark.truth[i];
        EXPECT_LT(fit.lower95[i], fit.upper95[i]) << truth.name;
        // Five standard deviations: a bias, not bad luck.
        EXPECT_NEAR(fit.value[i], truth.value, 5.0 * fit.std[i]) << truth.name << ", seed " << fit.seed;
      }
    }
  }
};

TEST_F(CoverageTest, EveryPointInEveryFrame) { ExpectIntervalsAreRight("full"); }
TEST_F(CoverageTest, HalfThePointsMissing) { ExpectIntervalsAreRight("half"); }
TEST_F(CoverageTest, AThirdOfTheFrameRate) { ExpectIntervalsAreRight("third"); }

TEST_F(CoverageTest, LessDataAreLessCertain) {
  const std::vector<CoverageSummary> summaries = SummarizeCoverage(RunCoverageBenchmark(SmallOptions()));
  ASSERT_EQ(summaries.size(), 6u);  // full, half, third: mu, k_stretch each
  for (int k = 0; k < 2; ++k) {
    // Standard deviations go with one over the square root of the number of measurements, roughly.
    EXPECT_NEAR(summaries[2 + k].mean_std / summaries[k].mean_std, std::sqrt(2.0), 0.3) << summaries[k].name;
    EXPECT_NEAR(summaries[4 + k].mean_std / summaries[k].mean_std, std::sqrt(3.0), 0.5) << summaries[k].name;
  }
}

TEST_F(CoverageTest, SummarizesWhatTheFitsSay) {
  CoverageBenchmark benchmark;
  benchmark.truth = {{"k_stretch", 10.0, false}};
  const double kNaN = std::nan("");
  const double rows[4][4] = {{9, 1, 7, 11}, {11, 1, 9, 13}, {13, 1, 11, 15}, {11, 3, kNaN, kNaN}};
  for (const auto& [value, std, lower, upper] : rows) {
    CoverageFit fit;
    fit.setting = "full";
    fit.value = {value};
    fit.std = {std};
    fit.lower95 = {lower};
    fit.upper95 = {upper};
    benchmark.fits.push_back(fit);
  }
  const std::vector<CoverageSummary> summaries = SummarizeCoverage(benchmark);
  ASSERT_EQ(summaries.size(), 1u);
  EXPECT_EQ(summaries[0].num_covered, 2);
  EXPECT_DOUBLE_EQ(summaries[0].coverage(), 0.5);
  EXPECT_DOUBLE_EQ(summaries[0].mean_std, 1.5);
  EXPECT_DOUBLE_EQ(summaries[0].empirical_std, std::sqrt(8.0 / 3.0));
  EXPECT_DOUBLE_EQ(summaries[0].bias, 1.0);
}

TEST_F(CoverageTest, ResultsDoNotDependOnThreads) {
  CoverageOptions options = SmallOptions();
  const std::string one = CoverageCsv(RunCoverageBenchmark(options));
  options.num_threads = 2;
  EXPECT_EQ(CoverageCsv(RunCoverageBenchmark(options)), one);
}

TEST_F(CoverageTest, PrintsATableAndWritesEveryFit) {
  WriteBytes(folder() / "scene.json", SmallDrape(6));
  const ToolResult result =
      Run("benchmark coverage --scene scene.json --set mu=0.24,k_stretch=70 --seeds 2 --settings half --output out");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(std::count(result.out.begin(), result.out.end(), '\n'), 3) << result.out;
  const std::string csv = ReadBytes(folder() / "out" / "coverage.csv");
  EXPECT_EQ(csv.rfind("setting,seed,mu,std_mu,lower95_mu,upper95_mu,k_stretch,", 0), 0u) << csv;
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 3) << csv;
}

// A truth of finer steps: intervals that count with the error of the step contain it, those of the noise alone do not.
TEST_F(CoverageTest, CountsWithTheTimeStep) {
  WriteBytes(folder() / "slope.json", R"({
    "clothid_scene": 1, "time_step": 0.01, "duration": 0.3, "gravity": [4.905, 0, -8.4957],
    "mesh": {"grid": {"nodes": [4, 4], "size": [0.3, 0.3]}},
    "obstacles": [{"name": "plane", "type": "plane", "point": [0, 0, 0], "normal": [0, 0, 1], "mu": 0.2}],
    "materials": {"density": 0.2, "k_stretch": 50, "k_bend": 2e-3, "drag": 0.1}})");
  CoverageOptions options;
  options.scene_path = (folder() / "slope.json").string();
  options.truth = {{"mu", 0.3}};
  options.num_seeds = 2;
  options.settings = {"full"};
  options.sigma = 1e-3;
  options.resolution.steps = 16;
  options.discretization.step = true;
  const CoverageBenchmark benchmark = RunCoverageBenchmark(options);
  for (const CoverageFit& fit : benchmark.fits) {
    for (std::size_t i = 0; i < benchmark.truth.size(); ++i) {
      EXPECT_LT(fit.lower95[i], fit.noise_lower95[i]);
      EXPECT_GT(fit.upper95[i], fit.noise_upper95[i]);
    }
  }
  const std::vector<CoverageSummary> summaries = SummarizeCoverage(benchmark);
  EXPECT_EQ(summaries[0].num_covered, 2) << summaries[0].name << " is off by " << summaries[0].bias;
  EXPECT_EQ(summaries[0].num_covered_by_noise, 0) << summaries[0].name;
  EXPECT_NE(CoverageTable(benchmark).find("by noise alone"), std::string::npos);
}

// At the scene's own resolution a sampled truth is the truth itself.
TEST_F(CoverageTest, SamplesAFinerTruthWhereTheModelIs) {
  const CoverageOptions options = SmallOptions();
  const Scene scene = ReadScene(options.scene_path);
  const std::vector<TrueParameter> truth = MakeTrueParameters(options.truth, scene);
  const Rollout plain = SimulateTruth(truth, "scene.json", scene);
  const Rollout same = SampleTruth(truth, "scene.json", scene, {1, 0});
  const Rollout fine = SampleTruth(truth, "scene.json", scene, {4, 1});
  ASSERT_EQ(same.num_steps(), plain.num_steps());
  ASSERT_EQ(fine.num_steps(), plain.num_steps());
  // Checkpoints start the solver afresh: equal up to the tolerance of the steps.
  for (int step = 0; step <= plain.num_steps(); ++step) {
    EXPECT_LE((same.positions(step) - plain.positions(step)).norm(), 1e-6) << step;
  }
  const Eigen::VectorXd error = fine.positions(plain.num_steps()) - plain.positions(plain.num_steps());
  EXPECT_EQ(error.size(), 3 * scene.mesh.num_nodes());
  EXPECT_GT(error.norm(), 1e-6);
  EXPECT_LT(error.norm(), 0.2);
}

// A sensor in place of white noise: the clock is fitted, too.
TEST_F(CoverageTest, RecordingsOfASensor) {
  CoverageOptions options = SmallOptions();
  WriteBytes(folder() / "sensor.json",
             R"({"clothid_sensor": 1, "interval": [0.03, 0.03], "noise": [1e-3, 1e-3, 1e-3]})");
  options.sensor_path = (folder() / "sensor.json").string();
  options.settings = {"faults"};
  const CoverageBenchmark benchmark = RunCoverageBenchmark(options);
  ASSERT_EQ(benchmark.truth.size(), 3u);
  EXPECT_EQ(benchmark.truth[2].name, "time_offset");
  for (const CoverageFit& fit : benchmark.fits) {
    EXPECT_EQ(fit.status, FitStatus::kConverged);
    EXPECT_LT(fit.lower95[2], fit.upper95[2]);
  }
  options.num_threads = 2;
  EXPECT_EQ(CoverageCsv(RunCoverageBenchmark(options)), CoverageCsv(benchmark));
}

// A fit without an interval is refused, neither covered nor missed.
TEST_F(CoverageTest, SummarizesFitsOfAnUnknownStart) {
  CoverageBenchmark benchmark;
  benchmark.start = StartSource::kRest;
  benchmark.truth = {{"k_stretch", 10.0, false}};
  const double kNaN = std::nan("");
  const double rows[4][5] = {
      {9, 2, 5, 13, 1}, {16, 2, 12, 20, 0.5}, {13, 1, 11, 15, 0.25}, {11, kNaN, kNaN, kNaN, kNaN}};
  for (const auto& [value, std, lower, upper, known_start_std] : rows) {
    CoverageFit fit;
    fit.setting = "full";
    fit.value = {value};
    fit.std = {std};
    fit.lower95 = {lower};
    fit.upper95 = {upper};
    fit.known_start_std = {known_start_std};
    fit.rollouts = 10;
    benchmark.fits.push_back(fit);
  }
  benchmark.fits[3].rollouts = 20;
  const std::vector<CoverageSummary> summaries = SummarizeCoverage(benchmark);
  ASSERT_EQ(summaries.size(), 1u);
  EXPECT_EQ(summaries[0].num_fits, 4);
  EXPECT_EQ(summaries[0].num_covered, 1);
  EXPECT_EQ(summaries[0].num_refused, 1);
  EXPECT_DOUBLE_EQ(summaries[0].mean_error_ratio, (-0.5 + 3.0 + 3.0) / 3.0);
  EXPECT_DOUBLE_EQ(summaries[0].mean_start_ratio, (2.0 + 4.0 + 4.0) / 3.0);
  EXPECT_DOUBLE_EQ(summaries[0].mean_rollouts, 12.5);
  const std::string table = CoverageTable(benchmark);
  EXPECT_NE(table.find("refused  bias, reported std  width over known start  rollouts\n"), std::string::npos) << table;
  EXPECT_NE(table.find("        1                1.83                    3.33      12.5\n"), std::string::npos)
      << table;
}

TEST_F(CoverageTest, WhatNoFitSaysIsNoNumber) {
  CoverageBenchmark benchmark;
  benchmark.start = StartSource::kMoving;
  benchmark.truth = {{"mu", 0.3, true}};
  const std::vector<double> none = {std::nan("")};
  for (const double value : {0.3, 0.4}) {
    CoverageFit fit;
    fit.setting = "full";
    fit.value = {value};
    fit.std = fit.lower95 = fit.upper95 = fit.known_start_std = none;
    benchmark.fits.push_back(fit);
  }
  const std::vector<CoverageSummary> summaries = SummarizeCoverage(benchmark);
  EXPECT_EQ(summaries[0].num_refused, 2);
  EXPECT_TRUE(std::isnan(summaries[0].mean_std));
  EXPECT_TRUE(std::isnan(summaries[0].mean_width));
  EXPECT_EQ(CoverageTable(benchmark).find("nan"), std::string::npos) << CoverageTable(benchmark);
}

// Released at rest, seen in noise, imported without its start.
TEST_F(CoverageTest, AStartThatNobodyKnows) {
  CoverageOptions options = SmallOptions();
  options.settings = {"full"};
  options.import.start = StartSource::kRest;
  options.sigma = 0.002;
  options.frame_rate = 50.0;
  options.start_factor = 1.2;
  const CoverageBenchmark benchmark = RunCoverageBenchmark(options);
  ASSERT_EQ(benchmark.fits.size(), 2u);
  for (const CoverageFit& fit : benchmark.fits) {
    EXPECT_EQ(fit.status, FitStatus::kConverged) << "seed " << fit.seed;
    EXPECT_NEAR(fit.rmse, std::sqrt(3.0) * 0.002, 0.0003) << "seed " << fit.seed;
    for (std::size_t i = 0; i < benchmark.truth.size(); ++i) {
      EXPECT_GT(fit.std[i], fit.known_start_std[i]) << benchmark.truth[i].name;
      // Five standard deviations: a bias, not bad luck.
      EXPECT_NEAR(fit.value[i], benchmark.truth[i].value, 5.0 * fit.std[i]) << benchmark.truth[i].name;
    }
  }
  for (const CoverageSummary& summary : SummarizeCoverage(benchmark)) EXPECT_GT(summary.mean_start_ratio, 1.0);
}

TEST_F(CoverageTest, TheFirstFrameMisleads) {
  CoverageOptions options = SmallOptions();
  options.settings = {"full"};
  options.import.start = StartSource::kFirstFrame;
  options.sigma = 0.002;
  const std::vector<CoverageSummary> summaries = SummarizeCoverage(RunCoverageBenchmark(options));
  ASSERT_EQ(summaries.size(), 2u);
  EXPECT_GT(std::abs(summaries[1].mean_error_ratio), kNormal95) << "although frames count by what it errs";
  EXPECT_TRUE(std::isnan(summaries[1].mean_start_ratio));  // it was taken for true
}

// The truth of `SmallOptions` as it was, and what a user has of it.
struct SmallTruth {
  std::string text = SmallDrape(6);
  Scene scene = ParseScene(text, "scene.json", "");
  Rollout rollout = SimulateTruth({{"mu", 0.24, true}, {"k_stretch", 70.0, false}}, "scene.json", scene);

  RecordedMotion Import(const ImportOfRollout& import, int num_markers, std::uint64_t seed) const {
    SyntheticOptions synthetic;
    synthetic.noise_sigma = 1e-3;
    synthetic.frame_rate = 50.0;
    synthetic.num_markers = num_markers;
    synthetic.seed = seed;
    return ImportRollout(import, rollout, scene, text, synthetic);
  }
};

TEST_F(CoverageTest, ImportsWhatIsLeftAfterTheCut) {
  const SmallTruth truth;
  const RecordedMotion motion = truth.Import({StartSource::kMoving, 0.1}, 0, 1);
  EXPECT_EQ(motion.start_source, StartSource::kMoving);
  ASSERT_EQ(motion.num_frames(), 16);
  EXPECT_DOUBLE_EQ(motion.times[0], 0.1);
  EXPECT_DOUBLE_EQ(motion.scene.start_time, 0.1);
  EXPECT_DOUBLE_EQ(motion.scene.duration, 0.3);
  const Rollout& rollout = truth.rollout;
  EXPECT_LT((motion.positions.col(15) - rollout.positions(40)).cwiseAbs().maxCoeff(), 6e-3);
  EXPECT_LT((motion.scene.initial_positions - rollout.positions(10)).cwiseAbs().maxCoeff(), 6e-3);
  const Eigen::VectorXd velocities = (rollout.positions(11) - rollout.positions(9)) / (2.0 * truth.scene.time_step);
  EXPECT_LT((motion.scene.initial_velocities - velocities).norm(), 0.5 * velocities.norm());  // of a few noisy frames
}

TEST_F(CoverageTest, EverySeedSeesOtherMarkers) {
  const SmallTruth truth;
  const auto nodes = [&](std::uint64_t seed) {
    std::vector<int> seen;
    for (const ObservedPoint& point : truth.Import({StartSource::kRest, 0.0}, 7, seed).points) {
      seen.push_back(point.nodes[0]);
    }
    return seen;
  };
  EXPECT_EQ(nodes(1).size(), 7u);
  EXPECT_EQ(nodes(1), nodes(1));
  EXPECT_NE(nodes(1), nodes(2));
}

// Markers of the scene's own start: fewer points tell less.
TEST_F(CoverageTest, MarkersOfAKnownStart) {
  CoverageOptions options = SmallOptions();
  options.settings = {"full"};
  const double all = SummarizeCoverage(RunCoverageBenchmark(options))[0].mean_std;
  options.num_markers = 9;
  EXPECT_GT(SummarizeCoverage(RunCoverageBenchmark(options))[0].mean_std, 1.4 * all);
}

TEST_F(CoverageTest, AField) {
  CoverageOptions options = UnknownsOptions();
  options.unknowns.fields = ParseFieldRequests("k_stretch:3x2");
  const CoverageBenchmark benchmark = RunCoverageBenchmark(options);
  ExpectTruthIsFound(benchmark, 2 + 6);
  EXPECT_EQ(benchmark.truth[2].name, "k_stretch.1.1");
  EXPECT_EQ(benchmark.truth[7].name, "k_stretch.3.2");
  EXPECT_NE(CoverageTable(benchmark).find("\nfull     k_stretch.*  "), std::string::npos) << CoverageTable(benchmark);
}

TEST_F(CoverageTest, AWindThatChangesBesideAnUnknownStart) {
  CoverageOptions options = UnknownsOptions();
  options.unknowns.wind = ParseWindRequest("6:y");
  ForgetStart(&options);
  const CoverageBenchmark benchmark = RunCoverageBenchmark(options);
  ExpectTruthIsFound(benchmark, 2 + 6);
  EXPECT_EQ(benchmark.truth[2].name, "wind.y.1");
  EXPECT_NEAR(benchmark.truth[4].value, 1.8, 1e-9);
  EXPECT_NE(CoverageCsv(benchmark).find(",wind.y.6,std_wind.y.6,"), std::string::npos);
}

// The case with everything; the whole one is `benchmark coverage --scene tools/benchmark/unknowns/scene.json`.
TEST_F(CoverageTest, UnknownsOfEveryKindAtOnce) {
  CoverageOptions options = UnknownsOptions();
  options.unknowns = {ParseFieldRequests("k_stretch:3x2"), ParseWindRequest("6:y")};
  ForgetStart(&options);
  const CoverageBenchmark benchmark = RunCoverageBenchmark(options);
  ExpectTruthIsFound(benchmark, 2 + 6 + 6);
  options.num_threads = 2;
  EXPECT_EQ(CoverageCsv(RunCoverageBenchmark(options)), CoverageCsv(benchmark));
}

// The field of the scene, at its own control nodes and between them, with the level of the truth.
TEST_F(CoverageTest, TruthOfAFieldHasTheLevelOfTheTruth) {
  const CoverageOptions options = UnknownsOptions();
  const Scene scene = ReadScene(options.scene_path);
  const Eigen::MatrixXd& values = scene.fields.front().values;
  const HiddenUnknowns same = {ParseFieldRequests("k_stretch:4x4"), {}};
  const Eigen::Vector2d times(0.2, 0.8);
  std::vector<TrueParameter> nodes = TrueUnknowns(same, {}, scene, times);
  ASSERT_EQ(nodes.size(), 16u);
  EXPECT_NEAR(nodes[6].value, values(1, 2), 1e-9);
  const double level = scene.nominal_parameters().material.stretch_stiffness;
  nodes = TrueUnknowns(same, {{"k_stretch", 2.0 * level, false}}, scene, times);
  EXPECT_NEAR(nodes[6].value, 2.0 * values(1, 2), 1e-9);
  const HiddenUnknowns coarse = {ParseFieldRequests("k_stretch:1x3"), {}};
  nodes = TrueUnknowns(coarse, {}, scene, times);
  ASSERT_EQ(nodes.size(), 3u);
  EXPECT_NEAR(nodes[0].value, std::sqrt(values(1, 0) * values(2, 0)), 1e-9);
}

TEST_F(CoverageTest, SumsUpWhatBelongsTogether) {
  EXPECT_EQ(UnknownsOf("wind.y.12"), "wind.y.*");
  EXPECT_EQ(UnknownsOf("k_stretch.2.1"), "k_stretch.*");
  for (const char* name : {"mu", "mu.ball", "gust.wave.x", "k_stretch"}) EXPECT_EQ(UnknownsOf(name), name);
  std::vector<CoverageSummary> summaries(4);
  const char* const names[] = {"mu", "wind.y.1", "wind.y.2", "wind.y.3"};
  for (int i = 0; i < 4; ++i) {
    summaries[i].name = names[i];
    summaries[i].num_fits = 10;
    summaries[i].num_covered = 7 + i;
    summaries[i].mean_std = i;
    summaries[i].empirical_std = i;
  }
  const std::vector<CoverageSummary> groups = GroupCoverage(summaries);
  ASSERT_EQ(groups.size(), 2u);
  EXPECT_EQ(groups[0].name, "mu");
  EXPECT_EQ(groups[1].name, "wind.y.*");
  EXPECT_EQ(groups[1].num_fits, 30);
  EXPECT_EQ(groups[1].num_covered, 27);
  EXPECT_DOUBLE_EQ(groups[1].mean_std, 2.0);
  EXPECT_DOUBLE_EQ(groups[1].empirical_std, std::sqrt(14.0 / 3.0));
}

TEST_F(CoverageTest, RefusesWhatItCannotRun) {
  WriteBytes(folder() / "scene.json", SmallDrape(6));
  const std::string valid = "benchmark coverage --scene scene.json --set mu=0.24,k_stretch=70 ";
  ExpectRefused("benchmark coverage --set mu=0.24", 1, "--scene");
  ExpectRefused("benchmark coverage --scene scene.json", 1, "--set");
  ExpectRefused(valid + "--seeds 1", 1, "--seeds");
  ExpectRefused(valid + "--noise 0", 1, "--noise");
  ExpectRefused(valid + "--settings none", 1, "'none'");
  ExpectRefused(valid + "--threads 0", 1, "--threads");
  ExpectRefused(valid + "--sensor absent.json", 1, "absent.json");
  ExpectRefused(valid + "--sensor absent.json --settings full", 1, "'full'");
  ExpectRefused(valid + "--initial known", 1,
                "--initial: expected scene, first, smoothed, rest or moving, got 'known'");
  ExpectRefused(valid + "--sigma 0", 1, "--sigma");
  ExpectRefused(valid + "--sigma 0.001 --noise 0.01", 1, "--noise");
  ExpectRefused(valid + "--frame_rate 0", 1, "--frame_rate");
  ExpectRefused(valid + "--force_sigma 0", 1, "--force_sigma");
  ExpectRefused(valid + "--force_sigma 0.01 --truth_steps 2", 1, "--truth_steps");
  ExpectRefused(valid + "--field k_stretch:2x2", 1, "--field: expected a scene that has 'k_stretch' as a field");
  ExpectRefused(valid + "--wind_profile 3", 1, "--wind_profile: expected a scene whose wind has a profile");
  ExpectRefused(valid + "--wind_profile 3 --settings third", 1, "'third'");
  ExpectRefused(valid + "--frame_rate 1", 1, "frame_rate 1");
  ExpectRefused(valid + "--start_factor 0", 1, "--start_factor");
  ExpectRefused(valid + "--cut 0.2", 1, "--initial");
  ExpectRefused(valid + "--initial rest --cut -1", 1, "--cut");
  ExpectRefused(valid + "--initial moving --cut 0.4", 1, "--cut: 0.4 s");
  ExpectRefused(valid + "--markers -1", 1, "--markers");
  ExpectRefused(valid + "--markers 31", 1, "markers 31");
  ExpectRefused(valid + "--initial rest --handle_sigma -1", 1, "--handle_sigma");
  ExpectRefused(valid + "--initial rest --handle_sigma 0.001", 1, "--handle_sigma: expected a scene whose handles");
  ExpectRefused(valid + "--initial first --markers 9", 1, "--markers");
  for (const char* flag : {"--sigma 0.001", "--frame_rate 30", "--markers 9", "--initial rest", "--force_sigma 0.01",
                           "--field k_stretch:2x2", "--wind_profile 3"}) {
    ExpectRefused(valid + "--sensor absent.json " + flag, 1, "--sensor");
  }
}

}  // namespace
}  // namespace clothid::coverage_test
