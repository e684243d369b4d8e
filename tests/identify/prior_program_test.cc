// --prior and --fabric as a user gives them: what the program says, that it is what the library computes, and what it
// refuses.
#include <string>

#include "identify/run.h"
#include "tests/tools/tool_test.h"

namespace clothid::prior_program_test {
namespace {

using Json = nlohmann::ordered_json;

class PriorProgramTest : public ToolTest {
 protected:
  PriorProgramTest() {
    ExpectSuccess("simulate --scene " + WriteScene(SphereJson()) + " --noise 1e-4 --set k_stretch=120 --output a.bin");
  }

  Json Parameters(const std::string& folder_name) const {
    return Json::parse(ReadBytes(folder() / folder_name / "result.json"))["parameters"];
  }

  void ExpectFlagsRefused(const std::string& flags, const std::string& culprit) const {
    ExpectRefused("identify --target a.bin --output result " + flags, 1, culprit);
  }
};

TEST_F(PriorProgramTest, TellsWhatTheRecordingAdds) {
  const std::string identify = "identify --target a.bin --fit k_stretch,density --report=false ";
  const ToolResult fit = Run(identify + "--prior density=0.15:1.1 --output r");
  EXPECT_EQ(fit.exit_code, 0) << fit.err << fit.out;
  EXPECT_NE(fit.out.find("\nprior           density 0.15, factor 1.1; the recording adds nothing"), std::string::npos);
  EXPECT_NE(fit.out.find("the recording adds nothing to what was believed of density"), std::string::npos) << fit.out;
  const Json parameters = Parameters("r");
  EXPECT_EQ(parameters["density"]["prior"]["median"], 0.15);
  EXPECT_EQ(parameters["density"]["prior"]["factor"], 1.1);
  EXPECT_EQ(parameters["density"]["prior"]["adds_nothing"], true);
  EXPECT_EQ(parameters["density"]["identifiable"], false);
  EXPECT_EQ(parameters["density"]["usable"], "with care");
  EXPECT_EQ(parameters["k_stretch"]["identifiable"], true);
  EXPECT_FALSE(parameters["k_stretch"].contains("prior"));
  EXPECT_EQ(Run(identify + "--output without").exit_code, 4) << "without the prior nothing is told";
}

TEST_F(PriorProgramTest, FlagSceneAndLibraryAreOne) {
  const std::string identify = "identify --target a.bin --fit k_stretch --report=false ";
  EXPECT_EQ(Run(identify + "--prior k_stretch=150:1.01 --output flag").exit_code, 0);
  const double value = Parameters("flag")["k_stretch"]["value"];
  Json scene = SphereJson();
  scene["initial"] = {{"positions", "rest"}};  // as the recording has it
  scene["parameters"] = Json::parse(R"({"k_stretch": {"prior": {"median": 150, "factor": 1.01}}})");
  EXPECT_EQ(Run(identify + "--scene " + WriteScene(scene, "believed.json") + " --output scene").exit_code, 0);
  EXPECT_EQ(Parameters("scene")["k_stretch"]["value"], value);
  RunOptions options;
  options.target_paths = {(folder() / "a.bin").string()};
  options.fit.parameters = {"k_stretch"};
  options.fit.overrides.priors = {{"k_stretch", {150.0, 1.01}}};
  EXPECT_EQ(Identify(options).summary.parameters[0].value, value);
  EXPECT_EQ(Run(identify + "--output none").exit_code, 0);
  EXPECT_NE(Parameters("none")["k_stretch"]["value"], value);
}

TEST_F(PriorProgramTest, RefusesPriorsWithoutEffect) {
  ExpectFlagsRefused("--fit k_stretch --prior mu=0.3:0.1", "--prior: 'mu' is not among the fitted parameters");
  ExpectFlagsRefused("--fit k_stretch --prior k_stretch=100", "--prior: expected NAME=MEDIAN:FACTOR");
  ExpectFlagsRefused("--fit k_stretch --prior k_stretch=100:0.5", "the prior of 'k_stretch': expected MEDIAN:FACTOR");
  ExpectFlagsRefused("--fit mu --prior mu=0.3:0", "the prior of 'mu': expected MEAN:STD");
  Json scene = SphereJson();
  scene["parameters"] = Json::parse(R"({"k_stretch": {"frozen": true}})");
  ExpectFlagsRefused("--scene " + WriteScene(scene, "frozen.json") + " --fit mu,k_stretch --prior k_stretch=100:2",
                     "the prior of 'k_stretch' has no effect: the scene freezes the parameter");
}

TEST_F(PriorProgramTest, FabricsGiveWhatTheSceneDoesNot) {
  Json scene = SphereJson();
  scene["clothid_scene"] = 2;
  scene["materials"] = {{"density", 0.15}};
  ExpectSuccess("simulate --scene " + WriteScene(scene, "bare.json") + " --fabric knit --noise 1e-4 --output knit.bin");
  EXPECT_EQ(Run("identify --target knit.bin --fit k_stretch,k_bend --report=false --output r").exit_code % 4, 0);
  EXPECT_EQ(Parameters("r")["k_stretch"]["start"], 72.0) << "the recording's scene names the fabric";
  EXPECT_EQ(Parameters("r")["k_bend"]["start"], 3.2e-5);
  Run("identify --target a.bin --scene bare.json --fabric denim --fit k_stretch --report=false --output denim");
  EXPECT_EQ(Parameters("denim")["k_stretch"]["start"], 912.0);
  ExpectFlagsRefused("--fabric velvet", "--fabric: expected one of light, medium, heavy, knit, denim, got 'velvet'");
  ExpectRefused("identify --target knit.bin --fabric denim --output result", 1, "--fabric: expected none");
  ExpectRefused("simulate --scene bare.json --fabric velvet --output b.bin", 1, "--fabric: expected one of");
}

}  // namespace
}  // namespace clothid::prior_program_test
