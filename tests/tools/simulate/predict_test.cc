// `simulate --result`: predictions of a scene by a fit, and what is refused of them.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "datasets/motion/motion_file.h"
#include "tests/identify/prediction/result_text.h"
#include "tests/tools/tool_test.h"

namespace clothid::predict_test {
namespace {

using Json = nlohmann::ordered_json;

class PredictTest : public ToolTest {
 protected:
  PredictTest() {
    scene_ = WriteScene(SphereJson());
    Json fit = ResultText({{"k_stretch", {100.0, 2.0}}, {"mu", {0.3, 0.01, 1.0, false}}});
    WriteBytes(folder() / "alone.json", fit.dump(2));
    fit["missing_force"] = ForcesText({{0.05, 0.03, 0.1}});
    WriteBytes(folder() / "result.json", fit.dump(2));
  }

  std::string Command(const std::string& flags) const {
    return "simulate --scene " + scene_ + " --output out.bin --draws 20 " + flags;
  }

 private:
  std::string scene_;
};

TEST_F(PredictTest, WritesTheMedianAndTheBands) {
  const ToolResult result = Run(Command("--result result.json --bands bands.npz --view page.html"));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  for (const char* part : {"drawn           k_stretch and mu", "lacks a force of 0.05 N/m^2", "rollouts        20",
                           "at 0.05 s: +- ", "more than the cloth at rest"}) {
    EXPECT_NE(result.out.find(part), std::string::npos) << part << "\n" << result.out;
  }
  const MotionTensors median = ReadMotionTensors((folder() / "out.bin").string());
  EXPECT_EQ(median.positions.rows(), 48);
  EXPECT_EQ(median.positions.cols(), 6);
  EXPECT_EQ(median.provenance, "predicted: the median of 20 rollouts, seed 1");
  const ToolResult archive =
      Run("python3 -c \"import zipfile; a = zipfile.ZipFile('bands.npz'); print(a.testzip(), "
          "len(a.read('positions.npy')))\"");
  EXPECT_EQ(archive.out, "None " + std::to_string(128 + 8 * 5 * 6 * 48) + "\n") << archive.err;
}

// A card of the cloth in place of a result, and every rollout beside the bands.
TEST_F(PredictTest, TakesACardAndKeepsTheDraws) {
  Json card = {{"schema", "clothid.fabric/1"}, {"clothid", "a test"},         {"membrane", "arap"},
               {"bend_poisson", 0.0},          {"constants", Json::object()}, {"recordings", Json::array()}};
  card["constants"]["k_stretch"] = {{"value", 100.0}, {"unit", "N/m"},  {"known", "fitted"}, {"lower95", 90.0},
                                    {"upper95", 111}, {"scatter", 0.1}, {"seen", nullptr}};
  WriteBytes(folder() / "fabric.json", card.dump());
  EXPECT_NE(Run(Command("--result fabric.json")).out.find("tells no force that it lacks"), std::string::npos);
  card["missing_force"] = Json::array();
  for (const double time : {0.05, 1.0}) {
    card["missing_force"].push_back({{"deviation_N_m2", 0.05}, {"time_s", time}, {"length_m", 0.1}, {"factor", 1.0}});
  }
  WriteBytes(folder() / "fabric.json", card.dump());
  const ToolResult result = Run(Command("--result fabric.json --bands bands.npz --keep_draws"));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  for (const char* part : {"drawn           k_stretch", "0.05 N/m^2 for 0.05 s and 0.05 N/m^2 for 1 s"}) {
    EXPECT_NE(result.out.find(part), std::string::npos) << part << "\n" << result.out;
  }
  const ToolResult archive =
      Run("python3 -c \"import zipfile; a = zipfile.ZipFile('bands.npz'); print(len(a.read('draws.npy')))\"");
  EXPECT_EQ(archive.out, std::to_string(128 + 8 * 20 * 6 * 48) + "\n") << archive.err;
  ExpectRefused(Command("--result fabric.json --keep_draws"), 1, "--keep_draws");
}

TEST_F(PredictTest, ThePageHasCloudAndBands) {
  ExpectSuccess(Command("--result result.json --of area --view page.html --bands b.npz"));
  const std::string page = ReadBytes(folder() / "page.html");
  const std::string mark = "id=\"data\">";
  const std::size_t begin = page.find(mark);
  ASSERT_NE(begin, std::string::npos);
  const std::size_t first = begin + mark.size();
  const Json data = Json::parse(page.substr(first, page.find("</script>", first) - first));
  const Json& prediction = data["prediction"];
  EXPECT_EQ(prediction["cloths"], 8);
  EXPECT_NE(prediction["status"].get<std::string>().find("worth more than the cloth at rest"), std::string::npos);
  ASSERT_EQ(prediction["charts"].size(), 3u) << prediction["charts"];
  EXPECT_EQ(prediction["charts"][0]["name"], "deviation");
  EXPECT_TRUE(prediction["charts"][1]["lines"].contains("parameters"));
  EXPECT_TRUE(prediction["charts"][1]["lines"].contains("force"));
  EXPECT_EQ(prediction["charts"][2]["name"], "area");
  const Json &low = prediction["charts"][2]["lines"]["5 %"], &high = prediction["charts"][2]["lines"]["95 %"];
  ASSERT_EQ(low.size(), 6u);
  EXPECT_LE(low[5].get<double>(), high[5].get<double>());
  EXPECT_EQ(data["cloud_points"][0], 8 * 16);
  EXPECT_TRUE(data["findings"].empty());
}

TEST_F(PredictTest, ThreadsChangeNoByte) {
  ExpectSuccess(Command("--result result.json --bands one.npz --seed 7"));
  const std::string median = ReadBytes(folder() / "out.bin");
  ExpectSuccess(Command("--result result.json --bands two.npz --seed 7 --threads 3"));
  EXPECT_EQ(ReadBytes(folder() / "out.bin"), median);
  EXPECT_EQ(ReadBytes(folder() / "two.npz"), ReadBytes(folder() / "one.npz"));
}

TEST_F(PredictTest, SaysWhereTheModelLacksNoForce) {
  const ToolResult result = Run(Command("--result alone.json"));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("tells no force that it lacks"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("not linear"), std::string::npos) << result.out;
}

TEST_F(PredictTest, SpreadsByWhatIsAskedFor) {
  const ToolResult alone = Run(Command("--result result.json --sources parameters"));
  EXPECT_NE(alone.out.find("not drawn"), std::string::npos) << alone.out << alone.err;
  EXPECT_NE(alone.out.find("step and mesh 0 %"), std::string::npos) << alone.out;
}

TEST_F(PredictTest, WarnsOfFitsThatMustNotBeUsed) {
  Json fit = ResultText({{"k_stretch", {100.0, 2.0}}});
  fit["usable"] = "no";
  fit["verdict"] = {"do not use: the fit is negative", "another line"};
  WriteBytes(folder() / "bad.json", fit.dump());
  const ToolResult result = Run(Command("--result bad.json"));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "simulate: warning: bad.json: the fit says: do not use: the fit is negative\n");
}

TEST_F(PredictTest, RefusesWhatPredictsNothing) {
  const std::string command = Command("--result result.json ");
  ExpectRefused(Command("--bands b.npz"), 1, "expected with --result");
  ExpectRefused(command + "--noise 0.001", 1, "--noise: expected without --result");
  ExpectRefused(command + "--set mu=0.1", 1, "--set: expected without --result");
  ExpectRefused(command + "--draws 5", 1, "--draws: expected a number from 19 to 10000");
  ExpectRefused(command + "--sources force,luck", 1,
                "--sources: expected some of parameters, force, step, mesh, start and handles");
  ExpectRefused(command + "--bands out.bin", 1, "--bands: out.bin: expected another file than --output");
  ExpectRefused(command + "--bands result.json", 1, "result.json: would replace an input");
  ExpectRefused(command + "--bands absent/b.npz", 1, "absent/b.npz: cannot be written");
  ExpectRefused(Command("--result absent.json"), 1, "absent.json");
  WriteBytes(folder() / "plan.json", R"({"schema": "clothid.plan/1"})");
  ExpectRefused(Command("--result plan.json"), 2, "plan.json:1: key 'schema': expected \"clothid.result/1\"");
  WriteBytes(folder() / "warp.json", ResultText({{"k_warp", {100.0, 2.0}}}).dump());
  ExpectRefused(Command("--result warp.json"), 2,
                "warp.json: key 'parameters.k_warp': expected a parameter that scene.json has");
}

}  // namespace
}  // namespace clothid::predict_test
