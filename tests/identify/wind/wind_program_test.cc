// `identify --wind_profile`, from the command line to the files, and back into a scene.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "tests/tools/tool_test.h"

namespace clothid::wind_program_test {
namespace {

using Json = nlohmann::ordered_json;

class WindProgramTest : public ToolTest {
 protected:
  WindProgramTest() {
    Json scene = BareScene();
    scene["clothid_scene"] = 2;
    scene["duration"] = 0.3;
    scene["materials"]["drag_normal"] = 0.5;
    scene["wind"]["mean"] = {0.2, 0.0, 0.5};
    WriteScene(scene);
    scene["wind"]["profile"]["times"] = {0.0, 0.15, 0.3};
    scene["wind"]["profile"]["velocities"] = {{0, 0, 0}, {0, 0, 2}, {0, 0, -1}};
    ExpectSuccess("simulate --scene " + WriteScene(scene, "truth.json") + " --noise 1e-4 --output cloth.bin");
  }

  Json Result(const std::string& name) const { return Json::parse(ReadBytes(folder() / name / "result.json")); }
};

TEST_F(WindProgramTest, WhatIsFittedCanBeSimulatedAgain) {
  const ToolResult fit = Run("identify --target cloth.bin --scene scene.json --fit drag_normal --wind_profile 7:z " +
                             std::string("--initial first --output result"));
  EXPECT_EQ(fit.exit_code, 0) << fit.err << fit.out;
  EXPECT_NE(fit.out.find("\nwind            z over 7 knots: "), std::string::npos) << fit.out;
  EXPECT_NE(fit.out.find("m/s in a second, chosen by the marginal likelihood\n"), std::string::npos) << fit.out;
  EXPECT_EQ(fit.out.find("\nwind.z.1"), std::string::npos) << fit.out;
  const Json result = Result("result"), wind = result["wind"], profile = wind["recordings"][0]["profile"];
  EXPECT_EQ(wind["smoothness_source"], "chosen by the marginal likelihood");
  EXPECT_EQ(profile["times"].size(), 7u);
  EXPECT_NEAR(profile["velocities"][3][2].get<double>(), 2.5, 0.6);
  EXPECT_EQ(profile["velocities"][3][2], result["parameters"]["wind.z.4"]["value"]);
  EXPECT_EQ(wind["recordings"][0]["fitted"][0]["component"], "z");
  EXPECT_EQ(wind["recordings"][0]["fitted"][0]["start"][6], 0.5);
  EXPECT_EQ(wind["recordings"][0]["fitted"][0]["upper95"].size(), 7u);
  EXPECT_NE(ReadBytes(folder() / "result" / "report.html").find("Wind over time"), std::string::npos);

  Json scene = Json::parse(ReadBytes(folder() / "scene.json"));
  scene["wind"] = {{"mean", {0.2, 0.0, 0.0}}, {"profile", profile}};
  scene["materials"]["drag_normal"] = result["parameters"]["drag_normal"]["value"];
  ExpectSuccess("simulate --scene " + WriteScene(scene, "again.json") + " --output again.bin");
  const ToolResult again = Run("identify --target cloth.bin --scene again.json --fit drag_normal --max_iterations 1 " +
                               std::string("--initial first --report=false --output again"));
  EXPECT_NEAR(Result("again")["rmse_m"].get<double>(), result["rmse_m"].get<double>(), 1e-6) << again.err;
}

TEST_F(WindProgramTest, EveryRecordingHasItsOwnWind) {
  WriteBytes(folder() / "twin.bin", ReadBytes(folder() / "cloth.bin"));
  const ToolResult fit = Run("identify --target cloth.bin,twin.bin --scene scene.json --fit drag_normal " +
                             std::string("--wind_profile 3:z --wind_smoothness 5 --initial first --output result"));
  EXPECT_EQ(fit.exit_code, 0) << fit.err << fit.out;
  EXPECT_NE(fit.out.find("\nwind            2: z over 3 knots: "), std::string::npos) << fit.out;
  EXPECT_NE(fit.out.find("\nsmoothness      5 m/s in a second, as given\n"), std::string::npos) << fit.out;
  const Json result = Result("result");
  EXPECT_EQ(result["wind"]["recordings"].size(), 2u);
  EXPECT_TRUE(result["parameters"].contains("wind.z.3@2"));
  EXPECT_NEAR(result["parameters"]["wind.z.2@1"]["value"].get<double>(),
              result["parameters"]["wind.z.2@2"]["value"].get<double>(), 1e-3);
}

TEST_F(WindProgramTest, RefusesWhatDoesNotGoTogether) {
  const auto expect = [this](const std::string& flags, const std::string& culprit) {
    ExpectRefused("identify --target cloth.bin --scene scene.json --output result " + flags, 1, culprit);
  };
  expect("--wind_profile 1", "--wind_profile: expected KNOTS or KNOTS:AXES, as in 8 or 8:xy");
  expect("--wind_profile 5 --fit wind.x", "take the place of 'wind.x'");
  expect("--wind_profile 5 --wind_smoothness -1", "--wind_smoothness");
  expect("--wind_smoothness 5", "--wind_smoothness: expected with --wind_profile, or with successive knots");
  expect("--wind_profile 5 --prior wind.x.2=0:1", "none of 'wind.x.2'");
}

}  // namespace
}  // namespace clothid::wind_program_test
