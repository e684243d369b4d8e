#include "identify/repetition/finished_fits.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/identify/repetition/single_fits.h"
#include "tests/temporary_folder.h"

namespace clothid {
namespace {

using Json = nlohmann::ordered_json;

Json ParameterJson(double value, const std::string& scale) {
  return {{"value", value}, {"std", 0.1 * value}, {"lower95", 0.8 * value}, {"upper95", 1.2 * value},
          {"scale", scale}, {"frozen", false},    {"step_error", 0.01},     {"mesh_error", nullptr}};
}

Json ResultJson(double stiffness) {
  return {{"schema", "clothid.result/1"},
          {"status", "converged"},
          {"exit_code", 0},
          {"verdict", {"usable: every fitted parameter is identifiable"}},
          {"parameters", {{"mu", ParameterJson(0.25, "linear")}, {"k_stretch", ParameterJson(stiffness, "log")}}},
          {"provenance", {{"version", "0.4.0"}, {"input_sha256", "12"}}}};
}

class FinishedFitsTest : public testing::Test {
 protected:
  std::string Path(const std::string& name) const { return folder_.File(name); }

  std::string Add(const std::string& name, const Json& result) const {
    std::filesystem::create_directories(Path(name));
    folder_.Write(name + "/result.json", result.dump(1));
    return Path(name);
  }

  // A folder with this result is refused.
  void ExpectRefused(const Json& result, std::initializer_list<const char*> fragments) const {
    const std::vector<std::string> folders = {Add("good", ResultJson(50.0)), Add("bad", result)};
    ExpectError([&] { ReadFinishedFits(folders); }, ErrorKind::kBadData, fragments);
  }

  TemporaryFolder folder_;
};

TEST_F(FinishedFitsTest, FindsThemInOrder) {
  for (const char* name : {"array/r10", "array/r2", "array/r1", "single"}) Add(name, ResultJson(50.0));
  std::filesystem::create_directories(Path("array/.hidden"));
  folder_.Write("array/log.txt", "");
  EXPECT_EQ(FindFinishedFits({Path("single"), Path("array")}),
            (std::vector<std::string>{Path("single"), Path("array/r1"), Path("array/r10"), Path("array/r2")}));
}

TEST_F(FinishedFitsTest, NamesWhatIsMissing) {
  Add("array/r1", ResultJson(50.0));
  for (const char* name : {"array/r2", "array/r3"}) std::filesystem::create_directories(Path(name));
  ExpectError([&] { FindFinishedFits({Path("array")}); }, ErrorKind::kBadData, {"array: r2 and r3: ", "missing"});
  for (int i = 10; i < 30; ++i) std::filesystem::create_directories(Path("array/r" + std::to_string(i)));
  ExpectError([&] { FindFinishedFits({Path("array")}); }, ErrorKind::kBadData, {"r10, ", " and 14 more: "});
  std::filesystem::create_directories(Path("empty"));
  ExpectError([&] { FindFinishedFits({Path("empty")}); }, ErrorKind::kBadData, {"empty: expected result.json"});
  ExpectError([&] { FindFinishedFits({Path("nowhere")}); }, ErrorKind::kIo, {"nowhere: expected the folder"});
}

TEST_F(FinishedFitsTest, ReadsEstimates) {
  Json unused = ResultJson(70.0);
  unused["status"] = "not_converged";
  unused["exit_code"] = 6;
  unused["verdict"] = {"do not use: the error is of the size of the cloth"};
  unused["parameters"]["mu"]["std"] = nullptr;
  const std::vector<SingleFit> fits = ReadFinishedFits({Add("a", ResultJson(50.0)), Add("b", unused)});
  EXPECT_EQ(fits[0].name, Path("a"));
  EXPECT_EQ(fits[0].sha256, "12");
  EXPECT_EQ(fits[0].why_not_used, "");
  EXPECT_EQ(fits[1].why_not_used, "do not use: the error is of the size of the cloth");
  const SingleEstimate stiffness = *fits[0].Find("k_stretch");
  EXPECT_EQ(stiffness.scale, ParameterScale::kLog);
  EXPECT_EQ(stiffness.value, 50.0);
  EXPECT_EQ(stiffness.std, 5.0);
  EXPECT_EQ(stiffness.step_error, 0.01);
  EXPECT_TRUE(std::isnan(stiffness.mesh_error));
  EXPECT_TRUE(std::isnan(fits[1].Find("mu")->std));
}

TEST_F(FinishedFitsTest, NamesFolderAndKeyOfWhatIsNoFinishedFit) {
  const auto changed = [](const std::string& pointer, const Json& value) {
    Json json = ResultJson(60.0);
    json[Json::json_pointer(pointer)] = value;
    return json;
  };
  ExpectRefused(changed("/schema", "other"), {"bad/result.json", "'schema'", "clothid.result/1"});
  ExpectRefused(changed("/status", "interrupted"), {"bad/result.json", "'status'", "got 'interrupted'"});
  ExpectRefused(changed("/status", "pooled"), {"'status'", "got 'pooled'"});
  ExpectRefused(changed("/repetitions", Json::object()), {"'repetitions'", "judged together"});
  ExpectRefused(changed("/provenance/version", "0.3.0"), {"'provenance.version'", "expected '0.4.0'", "'0.3.0'"});
  ExpectRefused(changed("/parameters/mu/value", nullptr), {"'parameters.mu.value'", "number"});
  ExpectRefused(changed("/parameters/mu/scale", "cubic"), {"'parameters.mu.scale'", "linear"});
  ExpectRefused(changed("/parameters/mu", Json{{"value", 1.0}}), {"'parameters.mu.scale'", "fit the recording again"});
  ExpectRefused(changed("/parameters/mu/std", "x"), {"'parameters.mu.std'"});
}

TEST_F(FinishedFitsTest, ChoosesSharedParameters) {
  std::vector<SingleFit> fits = {Fit("a", {Friction(0.2, 0.1), Stiffness(50.0, 1.0)}),
                                 Fit("b", {Stiffness(60.0, 1.0), Friction(0.3, 0.1)})};
  EXPECT_EQ(SharedParameters(fits, {}, {}), (std::vector<std::string>{"mu", "k_stretch"}));
  EXPECT_EQ(SharedParameters(fits, {"k_stretch"}, {}), std::vector<std::string>{"k_stretch"});
  EXPECT_EQ(SharedParameters(fits, {}, {"mu"}), std::vector<std::string>{"k_stretch"});
  fits[1].estimates.push_back(Estimate("shift.x", ParameterScale::kLinear, 0.0, 1.0));
  EXPECT_EQ(SharedParameters(fits, {}, {"shift"}), (std::vector<std::string>{"mu", "k_stretch"}));
  ExpectError([&] { SharedParameters(fits, {}, {}); }, ErrorKind::kBadData,
              {"b/result.json", "'parameters'", "expected mu and k_stretch, as a has", "shift.x"});
  ExpectError([&] { SharedParameters(fits, {"density"}, {}); }, ErrorKind::kBadData, {"a/result.json", "'density'"});
  fits[1].estimates[0].scale = ParameterScale::kLinear;
  ExpectError([&] { SharedParameters(fits, {"mu"}, {}); }, ErrorKind::kBadData, {"'parameters.k_stretch.scale'"});
}

TEST_F(FinishedFitsTest, LeavesOutKnotsOfTheWindAndFrozenParameters) {
  SingleEstimate frozen = Friction(0.2, 0.1);
  frozen.is_frozen = true;
  const SingleEstimate knot = Estimate("wind.x.3", ParameterScale::kLinear, 1.0, 0.1);
  const std::vector<SingleFit> fits = {Fit("a", {frozen, knot, Stiffness(50.0, 1.0)}),
                                       Fit("b", {frozen, Stiffness(50.0, 1.0)})};
  EXPECT_EQ(SharedParameters(fits, {}, {}), std::vector<std::string>{"k_stretch"});
}

}  // namespace
}  // namespace clothid
