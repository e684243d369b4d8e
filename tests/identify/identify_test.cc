// What `identify` refuses as a program: one line, the right exit code, nothing left behind.
#include <gtest/gtest.h>

#include <string>

#include "tests/tools/tool_test.h"

namespace clothid::identify_test {
namespace {

class IdentifyTest : public ToolTest {
 protected:
  IdentifyTest() { ExpectSuccess("simulate --scene " + WriteScene(SphereJson()) + " --output good.bin"); }

  void ExpectFlagsRefused(const std::string& flags, const std::string& culprit) const {
    ExpectRefused("identify --target good.bin --output result " + flags, 1, culprit);
  }
};

TEST_F(IdentifyTest, RefusesWrongFlags) {
  ExpectRefused("identify --output result", 1, "--target");
  ExpectRefused("identify --target good.bin extra", 1, "'extra'");
  ExpectFlagsRefused("--bogus", "identify: --bogus: unknown flag; see identify --help");
  ExpectFlagsRefused("--threads 1.5", "identify: --threads: expected a whole number, got '1.5'");
  ExpectFlagsRefused("--seed -1", "identify: --seed: expected a whole number >= 0, got '-1'");
  ExpectFlagsRefused("--step_tolerance nan", "identify: --step_tolerance: expected a finite number, got 'nan'");
  ExpectFlagsRefused("--discretization=time", "identify: --discretization: expected step, mesh or all, got 'time'");
  ExpectFlagsRefused("--report=maybe", "identify: --report: expected true or false, got 'maybe'");
  ExpectFlagsRefused("--fit", "identify: --fit: expected a value behind it");
  ExpectFlagsRefused("--fit mu --fit mu", "--fit: 'mu' is given twice");
  ExpectFlagsRefused("--jacobian exact", "exact");
  ExpectFlagsRefused("--jacobian newton", "newton");
  ExpectFlagsRefused("--loss cubic", "cubic");
  ExpectFlagsRefused("--max_iterations 0", "--max_iterations");
  ExpectFlagsRefused("--threads 0", "--threads");
  ExpectFlagsRefused("--fit mu,,k_stretch", "--fit");
  ExpectFlagsRefused("--fit weight", "weight");
  ExpectFlagsRefused("--fit mu.ghost", "mu.ghost");
}

TEST_F(IdentifyTest, RefusesFlagsThatDoNothing) {
  ExpectFlagsRefused("--seed 3", "--seed: expected with --starts");
  for (const std::string jacobian : {"sensitivity", "numeric"}) {
    ExpectFlagsRefused("--adjoint lu --jacobian " + jacobian, "--adjoint: expected with --jacobian adjoint");
    ExpectFlagsRefused("--adjoint reduced:1e-4 --jacobian " + jacobian, "--adjoint: expected with --jacobian adjoint");
  }
}

TEST_F(IdentifyTest, ListsMayBeGivenInPartsAndWithBlanks) {
  const std::string fit = "identify --target good.bin --report=false --output ";
  const ToolResult whole = Run(fit + "whole --fit mu,k_stretch --start mu=0.2,k_stretch=110");
  EXPECT_NE(whole.out.find("\nmu "), std::string::npos) << whole.err;
  EXPECT_NE(whole.out.find("\nk_stretch "), std::string::npos);
  EXPECT_EQ(Run(fit + "parts --fit mu --fit=k_stretch --start mu=0.2 --start k_stretch=110").out, whole.out);
  EXPECT_EQ(Run(fit + "blanks --fit 'mu, k_stretch' --start ' mu = 0.2, k_stretch = 110'").out, whole.out);
  EXPECT_EQ(
      Run(fit + "last --max-iterations 1 --fit mu,k_stretch --start mu=0.2,k_stretch=110 --max_iterations 50").out,
      whole.out)
      << "of other flags the last counts";
}

TEST_F(IdentifyTest, NamesThatAreNoUtf8LoseNoFit) {
  std::filesystem::copy_file(folder() / "good.bin", folder() / "g\xff.bin");
  const ToolResult fit = Run("identify --target 'g\xff.bin' --fit k_stretch --output 'r\xff'");
  EXPECT_EQ(fit.exit_code, 0) << fit.err;
  const auto result = nlohmann::json::parse(ReadBytes(folder() / "r\xff" / "result.json"));
  EXPECT_NE(result["provenance"]["flags"].get<std::string>().find("g\xef\xbf\xbd.bin"), std::string::npos);
  EXPECT_TRUE(std::filesystem::exists(folder() / "r\xff" / "report.html"));
}

TEST_F(IdentifyTest, RefusesToReplaceWhatItReads) {
  EXPECT_EQ(Run("identify --target good.bin --fit k_stretch --report=false --output r").exit_code, 0);
  ExpectRefused("identify --target r/predicted.bin --output r", 1,
                "--target: r/predicted.bin: the results in --output r");
  ExpectRefused("identify --target good.bin --holdout ./r/predicted.bin --output r", 1, "--holdout: ./r/predicted.bin");
  std::filesystem::copy_file(folder() / "scene.json", folder() / "r/profile.csv");
  ExpectRefused("identify --target good.bin --scene r/profile.csv --output r/", 1, "--scene: r/profile.csv");
  EXPECT_EQ(Run("identify --target r/predicted.bin --fit k_stretch --report=false --output other").exit_code, 0);
}

TEST_F(IdentifyTest, RefusesWrongParameters) {
  ExpectFlagsRefused("--start mu=nan", "mu");
  ExpectFlagsRefused("--start mu=-0.1", "mu");
  ExpectFlagsRefused("--start k_stretch=-1", "k_stretch");
  ExpectFlagsRefused("--start k_stretch=0", "k_stretch");
  ExpectFlagsRefused("--start k_stretch=inf", "k_stretch");
  ExpectFlagsRefused("--start k_stretch", "k_stretch");
  ExpectFlagsRefused("--lower mu=0.5 --upper mu=0.4", "mu");
  ExpectFlagsRefused("--lower k_stretch=nan", "k_stretch");
}

TEST_F(IdentifyTest, RefusesWrongParametersOfARecording) {
  ExpectFlagsRefused("--fit mu,shift.w", "'shift.w'");
  ExpectFlagsRefused("--fit shift,shift.x", "--fit: 'shift.x' is given twice");
  ExpectFlagsRefused("--fit mu,drag@1", "--fit: 'drag@1'");
  ExpectFlagsRefused("--each weight", "weight");
  ExpectFlagsRefused("--each mu,,drag", "--each");
  ExpectFlagsRefused("--start shift=0.1", "--start: 'shift'");
  ExpectFlagsRefused("--fit mu,time_offset --start time_offset=1", "time_offset");
  ExpectFlagsRefused("--fit mu,time_offset --upper time_offset=1", "time_offset");  // longer than the recording
  ExpectFlagsRefused("--fit mu,turn --lower turn=-4", "turn.x");
  ExpectFlagsRefused("--each drag --lower drag@1=0.1 --start drag=1", "drag@1");  // one recording has no suffix
  ExpectFlagsRefused("--fit k_stretch,align --profile shift", "--profile: 'shift'");
}

TEST_F(IdentifyTest, ParametersOfARecordingAreInTheResult) {
  ExpectSuccess("simulate --scene " + WriteScene(SphereJson()) + " --set k_stretch=120 --output a.bin");
  ExpectSuccess("simulate --scene " + WriteScene(SphereJson()) + " --set k_stretch=120 --output b.bin");
  const ToolResult fit = Run(
      "identify --target a.bin,b.bin --fit k_stretch,shift --each time_offset --start shift=0.001,time_offset@2=0.002 "
      "--lower time_offset=-0.01 --output result");
  EXPECT_EQ(fit.exit_code, 0) << fit.err << fit.out;
  const auto result = nlohmann::json::parse(ReadBytes(folder() / "result/result.json"));
  const auto& parameters = result["parameters"];
  EXPECT_EQ(parameters.size(), 6u);
  EXPECT_NEAR(parameters["k_stretch"]["value"].get<double>(), 120.0, 1e-2);
  EXPECT_EQ(parameters["shift.y"]["start"], 0.001);
  EXPECT_EQ(parameters["time_offset@1"]["start"], 0.0);
  EXPECT_EQ(parameters["time_offset@2"]["start"], 0.002);
  for (const char* name : {"shift.x", "shift.y", "shift.z", "time_offset@1", "time_offset@2"}) {
    EXPECT_NEAR(parameters[name]["value"].get<double>(), 0.0, 1e-5) << name;
  }
  EXPECT_NE(fit.out.find("time_offset@2   "), std::string::npos) << fit.out;
  const std::string convergence = ReadBytes(folder() / "result/convergence.csv");
  EXPECT_NE(convergence.find(",shift.x,shift.y,shift.z,time_offset@1,time_offset@2,"), std::string::npos);
}

TEST_F(IdentifyTest, RefusesFilesThatCannotBeOpenedOrWritten) {
  ExpectRefused("identify --target absent.bin --output result", 1, "absent.bin");
  ExpectRefused("identify --target good.bin --scene absent.json --output result", 1, "absent.json");
  ExpectRefused("identify --target good.bin --output good.bin", 1, "good.bin");
  ExpectRefused("identify --target good.bin --output good.bin/result", 1, "good.bin/result");
  ExpectRefused("identify --target good.bin --output /proc/result", 1, "/proc/result");
}

TEST_F(IdentifyTest, RefusesBadRecordings) {
  const std::string good = ReadBytes(folder() / "good.bin");
  WriteBytes(folder() / "bad.bin", good.substr(0, good.size() - 8));
  ExpectRefused("identify --target bad.bin --output result", 2, "bad.bin");
  std::string flipped = good;
  flipped.back() = static_cast<char>(flipped.back() ^ 1);
  WriteBytes(folder() / "bad.bin", flipped);
  ExpectRefused("identify --target good.bin,bad.bin --output result", 2, "bad.bin");
  WriteBytes(folder() / "bad.json", R"({"clothid_scene": 1, "handels": []})");
  ExpectRefused("identify --target good.bin --scene bad.json --output result", 2, "handels");
}

// What `motion check` calls a problem ends the run before the fit; what it warns of is told.
TEST_F(IdentifyTest, ChecksRecordingsFirst) {
  ExpectSuccess("motion convert good.bin mm.bin --scale 1000");
  const std::string fit = "identify --fit k_stretch --max_iterations 1 --report=false --output result --target ";
  ExpectRefused(fit + "mm.bin", 2, "mm.bin: cannot be fitted as it is: edge lengths");
  ExpectRefused(fit + "good.bin,mm.bin", 2, "--scale 0.001 (--check=false fits it anyway)");
  EXPECT_NE(Run(fit + "mm.bin --check=false").exit_code, 2);
  nlohmann::ordered_json scene = SphereJson();
  scene["materials"]["density"] = 150;
  WriteScene(scene, "grams.json");
  const std::string told = Run(fit + "good.bin --scene grams.json").err;
  EXPECT_EQ(told.rfind("identify: good.bin: warning: density: 150 kg/m^2", 0), 0u) << told;
  EXPECT_EQ(Run(fit + "good.bin --scene grams.json --check=false").err.find("warning"), std::string::npos);
}

}  // namespace
}  // namespace clothid::identify_test
