// Repetitions from recordings to files: each fitted for itself, all jointly, and the same from folders of finished
// fits.
#include "identify/repeated_run.h"

#include <gtest/gtest.h>

#include <atomic>
#include <nlohmann/json.hpp>

#include "datasets/motion/motion_file.h"
#include "identify/export/export.h"
#include "identify/run.h"
#include "sim/base/text_file.h"
#include "tests/expect_error.h"
#include "tests/identify/simulated_recordings.h"
#include "tests/temporary_folder.h"

namespace clothid::repeated_run_test {
namespace {

using Json = nlohmann::ordered_json;

const std::vector<double> kStiffnesses = {52.0, 60.0, 71.0, 64.0};  // N/m

// A small cloth that swings from an edge.
Json SceneOf(double stiffness) {
  return {{"clothid_scene", 2},
          {"time_step", 0.01},
          {"duration", 0.2},
          {"mesh", {{"grid", {{"nodes", {4, 4}}, {"size", {0.3, 0.3}}}}}},
          {"initial", {{"positions", "rest"}}},
          {"handles", {0, 1, 2, 3}},
          {"materials", {{"density", 0.2}, {"k_stretch", stiffness}, {"k_bend", 1e-4}, {"drag", 0.1}}}};
}

class RepeatedRunTest : public testing::Test {
 protected:
  // The recordings, each of another specimen, with noise of its own.
  RunOptions Options() const {
    RunOptions options;
    for (std::size_t r = 0; r < kStiffnesses.size(); ++r) {
      SyntheticOptions synthetic;
      synthetic.noise_sigma = 5e-4;
      synthetic.seed = r + 1;
      const std::string path = folder_.File("r" + std::to_string(r) + ".bin");
      WriteMotion(SimulatedText(SceneOf(kStiffnesses[r]).dump(), synthetic), path);
      options.target_paths.push_back(path);
    }
    options.fit.parameters = {"k_stretch"};
    options.fit.each = {"drag"};
    options.report_page = false;
    options.repeat = true;
    return options;
  }

  // One of them, for itself.
  RunOptions Alone(const RunOptions& options, std::size_t r) const {
    RunOptions alone = options;
    alone.repeat = false;
    alone.target_paths = {options.target_paths[r]};
    alone.output = folder_.File("fits/" + std::to_string(r));
    return alone;
  }

  std::string Text(const std::string& file) const { return ReadFile(folder_.File(file), kMaxJsonBytes); }

  // result.json without what differs from run to run.
  std::string WithoutRun(const std::string& folder) const {
    Json json = Json::parse(Text(folder + "/result.json"));
    json.erase("seconds");
    json.erase("provenance");
    return json.dump(1);
  }

  void ExpectInvalid(const RunOptions& options, std::initializer_list<const char*> fragments) const {
    ExpectError([&] { Identify(options); }, ErrorKind::kUsage, fragments);
  }

  TemporaryFolder folder_;
};

TEST_F(RepeatedRunTest, FitsEachRecordingAndAllOfThem) {
  RunOptions options = Options();
  options.output = folder_.File("out");
  options.simulators = {"mujoco"};
  const RunResult result = Identify(options);
  ASSERT_TRUE(result.checks.repetitions);
  const Repetitions& repetitions = *result.checks.repetitions;
  ASSERT_EQ(repetitions.fits.size(), 4u);
  // Drag is of each recording alone.
  ASSERT_EQ(repetitions.parameters.size(), 1u);
  const PooledParameter& stretch = repetitions.parameters[0];
  EXPECT_EQ(stretch.name, "k_stretch");
  EXPECT_EQ(stretch.fits, (std::vector<int>{0, 1, 2, 3}));
  for (std::size_t r = 0; r < 4; ++r) {
    const SingleEstimate& estimate = *repetitions.fits[r].Find("k_stretch");
    EXPECT_EQ(repetitions.fits[r].name, options.target_paths[r]);
    EXPECT_NEAR(estimate.value, kStiffnesses[r], 4.0 * estimate.std) << r;
    EXPECT_LT(estimate.std, 0.03 * estimate.value) << r;
  }
  EXPECT_NEAR(stretch.effects.scatter(), 0.13, 0.03);  // the standard deviation of the logarithms of the truth
  EXPECT_TRUE(stretch.varies());
  EXPECT_EQ(result.verdict.line.rfind("usable with care: recordings differ by 1", 0), 0u) << result.verdict.line;
  // The joint fit is what it is without them.
  RunOptions joint = options;
  joint.repeat = false;
  joint.output.clear();
  joint.simulators.clear();
  EXPECT_EQ(result.summary.values(), Identify(joint).summary.values());
  EXPECT_EQ(result.summary.parameters.size(), 5u);  // k_stretch, drag@1, ..
}

TEST_F(RepeatedRunTest, WritesWhatItTells) {
  RunOptions options = Options();
  options.output = folder_.File("out");
  options.simulators = {"mujoco", "ppf"};
  const RunResult result = Identify(options);
  const PooledParameter& stretch = result.checks.repetitions->parameters[0];
  const Json json = Json::parse(Text("out/result.json"))["repetitions"];
  EXPECT_EQ(json["recordings"].size(), 4u);
  EXPECT_EQ(json["recordings"][1]["name"], options.target_paths[1]);
  EXPECT_TRUE(json["recordings"][1]["why_not_used"].is_null());
  const Json& parameter = json["parameters"]["k_stretch"];
  EXPECT_EQ(parameter["mean"].get<double>(), stretch.mean);
  EXPECT_EQ(parameter["next_upper95"].get<double>(), stretch.next_upper95);
  EXPECT_EQ(parameter["scatter"].get<double>(), stretch.effects.tau);
  EXPECT_EQ(parameter["estimates"][2]["value"].get<double>(),
            result.checks.repetitions->fits[2].Find("k_stretch")->value);
  EXPECT_EQ(parameter["estimates"][2]["deviation"].get<double>(), stretch.effects.left_out[2].deviation);
  EXPECT_EQ(parameter["varies"], true);
  for (const char* words : {"\nrepetitions ", "\n  mean  ", "\n  next  ", "\n  scatter ", "r3.bin\n"}) {
    EXPECT_NE(result.table.find(words), std::string::npos) << words << "\n" << result.table;
  }
  EXPECT_EQ(result.table.find(" \n"), std::string::npos) << result.table;
  // The mean is exported, and both numbers stand beside it.
  for (const char* file : {"out/export_mujoco.xml", "out/export_ppf.py"}) {
    const std::string text = Text(file);
    EXPECT_NE(text.find("  k " + ShortestText(stretch.mean) + " N/m"), std::string::npos) << text;
    EXPECT_NE(text.find("    k_stretch: " + MeanText(stretch) + "\n"), std::string::npos) << text;
  }
}

TEST_F(RepeatedRunTest, GivesTheSameBytesOnAnyNumberOfThreads) {
  RunOptions options = Options();
  options.output = folder_.File("one");
  Identify(options);
  options.output = folder_.File("three");
  options.fit.num_threads = 3;
  int num_told = 0;
  options.on_repetition = [&](const SingleFit& fit, int num_done, int num) {
    EXPECT_EQ(num_done, ++num_told);
    EXPECT_EQ(num, 4);
    EXPECT_TRUE(fit.Find("drag"));
  };
  Identify(options);
  EXPECT_EQ(num_told, 4);
  EXPECT_EQ(WithoutRun("one"), WithoutRun("three"));
}

TEST_F(RepeatedRunTest, FoldersOfFinishedFitsGiveTheSameNumbers) {
  const RunOptions options = Options();
  const PooledParameter from_recordings = Identify(options).checks.repetitions->parameters[0];
  for (std::size_t r = 0; r < 4; ++r) Identify(Alone(options, r));
  RunOptions of_folders;
  of_folders.target_paths = {folder_.File("fits")};
  of_folders.fit.each = {"drag"};
  of_folders.repeat = true;
  of_folders.output = folder_.File("pooled");
  of_folders.simulators = {"mujoco"};
  const RunResult result = Identify(of_folders);
  ASSERT_EQ(result.checks.repetitions->parameters.size(), 1u);
  const PooledParameter& pooled = result.checks.repetitions->parameters[0];
  EXPECT_EQ(pooled.mean, from_recordings.mean);
  EXPECT_EQ(pooled.lower95, from_recordings.lower95);
  EXPECT_EQ(pooled.next_upper95, from_recordings.next_upper95);
  EXPECT_EQ(pooled.effects.tau, from_recordings.effects.tau);
  EXPECT_EQ(pooled.effects.common_error, from_recordings.effects.common_error);
  EXPECT_GT(pooled.effects.common_error, 0.0);
  EXPECT_EQ(pooled.effects.left_out[3].deviation, from_recordings.effects.left_out[3].deviation);
  EXPECT_EQ(result.exit_code, kExitSuccess);
  EXPECT_EQ(result.summary.values()[0], pooled.mean);
  const Json json = Json::parse(Text("pooled/result.json"));
  EXPECT_EQ(json["status"], "pooled");
  EXPECT_EQ(json["verdict"][0], result.verdict.line);
  EXPECT_EQ(json["parameters"]["k_stretch"]["value"].get<double>(), pooled.mean);
  const std::string exported = Text("pooled/export_mujoco.xml");
  EXPECT_NE(exported.find(MeanText(pooled)), std::string::npos) << exported;
  // An export of its result.json is the same.
  ExportResult(folder_.File("pooled/result.json"), options.target_paths[0], "mujoco", folder_.File("later"));
  EXPECT_EQ(Text("later/export_mujoco.xml"), exported);
}

TEST_F(RepeatedRunTest, ANumberForOneRecordingCountsInItsFit) {
  RunOptions options = Options();
  options.fit.overrides.lower_bounds = {{"drag@2", 0.19}};
  options.fit.overrides.start = {{"drag@2", 0.2}, {"drag", 0.12}};
  const Repetitions repetitions = *Identify(options).checks.repetitions;
  EXPECT_NEAR(repetitions.fits[1].Find("drag")->value, 0.19, 1e-3);
  for (const int r : {0, 2, 3}) EXPECT_LT(repetitions.fits[static_cast<std::size_t>(r)].Find("drag")->value, 0.15) << r;
}

TEST_F(RepeatedRunTest, AnInterruptedRunJudgesNothing) {
  RunOptions options = Options();
  std::atomic<bool> cancel{false};
  options.fit.cancel = &cancel;
  options.on_repetition = [&](const SingleFit&, int num_done, int) { cancel = num_done == 2; };
  const RunResult result = Identify(options);
  EXPECT_FALSE(result.checks.repetitions);
  EXPECT_EQ(result.exit_code, kExitInterrupted);
}

TEST_F(RepeatedRunTest, RefusesWhatContradictsIt) {
  const RunOptions options = Options();
  RunOptions one = options;
  one.target_paths.resize(1);
  ExpectInvalid(one, {"--repeat: expected at least two recordings"});
  RunOptions twice = options;
  WriteMotion(ReadMotionTensors(options.target_paths[0]), folder_.File("copy.bin"));
  twice.target_paths.push_back(folder_.File("copy.bin"));
  ExpectInvalid(twice, {"copy.bin is the recording of ", "r0.bin"});
  Identify(Alone(options, 0));
  RunOptions mixed = options;
  mixed.target_paths.push_back(folder_.File("fits"));
  ExpectInvalid(mixed, {"recordings or folders of finished fits, not both"});
  RunOptions folders;
  folders.repeat = true;
  folders.target_paths = {folder_.File("fits")};
  ExpectInvalid(folders, {"at least two finished fits"});
  Identify(Alone(options, 1));
  folders.output = folder_.File("fits/1");
  ExpectInvalid(folders, {"--target", "fits/1/result.json"});
  folders.output.clear();
  folders.fit.each = {"drag", "k_stretch"};
  ExpectInvalid(folders, {"expected a parameter that all fits share"});
  folders.holdout_paths = {options.target_paths[3]};
  ExpectInvalid(folders, {"--holdout: expected recordings as --target"});
  folders.holdouts.clear();
  folders.holdout_paths.clear();
  folders.reading.sigma_source = SigmaSource::kEstimated;
  ExpectInvalid(folders, {"--sigma: expected recordings as --target"});
  folders.reading.sigma_source = SigmaSource::kRecorded;
  folders.fit.loss = ParseRobustLoss("huber:2");
  ExpectInvalid(folders, {"--loss: expected recordings as --target"});
}

// One cloth, held by an edge and by two corners.
TEST_F(RepeatedRunTest, EachRecordingPredictsTheOthers) {
  RunOptions options;
  for (int r = 0; r < 2; ++r) {
    Json scene = SceneOf(60.0);
    if (r == 1) scene["handles"] = {0, 3};
    SyntheticOptions synthetic;
    synthetic.noise_sigma = 5e-4;
    synthetic.seed = static_cast<std::uint64_t>(r) + 1;
    options.target_paths.push_back(folder_.File("t" + std::to_string(r) + ".bin"));
    WriteMotion(SimulatedText(scene.dump(), synthetic), options.target_paths.back());
  }
  options.fit.parameters = {"k_stretch"};
  options.output = folder_.File("out");
  options.fit.num_threads = 2;
  const std::vector<double> joint = [&] {
    RunOptions alone = options;
    alone.output.clear();
    const Eigen::VectorXd values = Identify(alone).summary.values();
    return std::vector<double>(values.begin(), values.end());
  }();
  options.transfer = true;
  const RunResult result = Identify(options);
  const Eigen::VectorXd values = result.summary.values();
  EXPECT_EQ(std::vector<double>(values.begin(), values.end()), joint);
  EXPECT_FALSE(result.checks.repetitions) << "nobody asked";
  ASSERT_TRUE(result.checks.transfer);
  const std::vector<TransferRow>& rows = result.checks.transfer->rows;
  ASSERT_EQ(rows.size(), 2u);
  for (std::size_t r = 0; r < 2; ++r) {
    EXPECT_EQ(rows[r].name, options.target_paths[r]);
    EXPECT_EQ(rows[r].why_not, "");
    ASSERT_EQ(rows[r].predicted.size(), 1u);
    const HeldRecordingBands& other = rows[r].predicted[0];
    EXPECT_EQ(other.name, options.target_paths[1 - r]);
    EXPECT_GT(other.all.inside, 0.75) << r;
    EXPECT_LT(other.all.rmse, 2e-3) << r;
    EXPECT_TRUE(std::isinf(other.worth_until));
  }
  const Json told = Json::parse(Text("out/result.json"))["transfer"];
  ASSERT_EQ(told.size(), 2u);
  EXPECT_EQ(told[0]["predicted"][0]["name"], options.target_paths[1]);
  EXPECT_EQ(told[0]["predicted"][0]["inside"].get<double>(), rows[0].predicted[0].all.inside);
  EXPECT_TRUE(told[0]["predicted"][0]["worth_until_s"].is_null());
  EXPECT_NE(result.table.find(options.target_paths[0] + " predicts " + options.target_paths[1] + ": "),
            std::string::npos)
      << result.table;
  EXPECT_NE(ReadFile(folder_.File("out/report.html"), kMaxJsonBytes).find("Who predicts whom"), std::string::npos);
}

// All of them predict what was held out, and one factor is found for the forces that they lack together; the single
// fits hold nothing out.
TEST_F(RepeatedRunTest, BandsOfWhatIsHeldOutAreCalibrated) {
  const auto recorded = [&](const std::string& name, double drag, std::uint64_t seed) {
    Json scene = SceneOf(60.0);
    scene["materials"]["drag"] = drag;
    SyntheticOptions synthetic;
    synthetic.noise_sigma = 1e-4;
    synthetic.seed = seed;
    WriteMotion(SimulatedText(scene.dump(), synthetic), folder_.File(name));
    return folder_.File(name);
  };
  RunOptions options;
  options.target_paths = {recorded("a.bin", 0.15, 1), recorded("b.bin", 0.15, 2)};
  options.holdout_paths = {recorded("c.bin", 1.0, 3)};                             // in other air
  options.reading.scene_path = folder_.Write("scene.json", SceneOf(60.0).dump());  // with less air
  options.fit.parameters = {"k_stretch"};
  options.output = folder_.File("out");
  options.report_page = false;
  options.repeat = true;
  options.calibrates_bands = true;
  const RunResult result = Identify(options);
  ASSERT_TRUE(result.checks.repetitions);
  EXPECT_EQ(result.checks.repetitions->fits.size(), 2u);
  ASSERT_TRUE(result.checks.held_bands);
  const HeldBands& bands = *result.checks.held_bands;
  EXPECT_TRUE(bands.all.IsTooNarrow()) << bands.all.rmse << " of " << bands.all.rmse_if_right.high;
  ASSERT_TRUE(bands.calibration);
  EXPECT_GT(bands.calibration->factor, 1.5);
  EXPECT_GT(bands.calibration->inside, bands.all.inside);
  const Json json = Json::parse(Text("out/result.json")), card = Json::parse(Text("out/fabric.json"));
  EXPECT_EQ(json["holdout"]["bands"]["calibration"]["force_factor"].get<double>(), bands.calibration->factor);
  ASSERT_FALSE(json["missing_force"].empty());
  EXPECT_EQ(card["missing_force"].size(), json["missing_force"].size());
  EXPECT_EQ(card["missing_force"][0]["factor"].get<double>(), bands.calibration->factor);
  EXPECT_NE(result.table.find("bands of 90 % are too narrow: they held "), std::string::npos) << result.table;
}

TEST_F(RepeatedRunTest, PredictionsOfEachOtherNeedTwoRecordings) {
  RunOptions options = Options();
  options.repeat = false;
  options.transfer = true;
  options.holdout_draws = 0;
  ExpectInvalid(options, {"--transfer", "--holdout_draws above 0"});
  options.holdout_draws = 20;
  options.target_paths.resize(1);
  ExpectInvalid(options, {"--transfer", "at least two recordings"});
}

}  // namespace
}  // namespace clothid::repeated_run_test
