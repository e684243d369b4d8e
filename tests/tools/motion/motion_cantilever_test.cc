// From the tables of a cantilever and of a tilted plate to constants, as a user goes.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/tools/tool_test.h"

namespace clothid::motion_cantilever_test {
namespace {

using Json = nlohmann::ordered_json;

class MotionCantileverTest : public ToolTest {
 protected:
  Json Fit(const std::string& name) const {
    const ToolResult fit = Run("identify --target bend.bin --fit " + name + " --report=false --output result");
    EXPECT_EQ(fit.exit_code, 0) << fit.out << fit.err;
    return Json::parse(ReadBytes(folder() / "result" / "result.json"))["parameters"][name];
  }

  std::string Convert(const std::string& flags) const {
    const ToolResult made = Run("motion convert_cantilever bend.csv bend.bin " + flags);
    EXPECT_EQ(made.exit_code, 0) << made.err;
    EXPECT_EQ(made.err, "");
    const ToolResult check = Run("motion check bend.bin");
    EXPECT_EQ(check.exit_code, 0) << check.err;
    EXPECT_EQ(check.out.find("warning"), std::string::npos) << check.out;
    return made.out;
  }
};

TEST_F(MotionCantileverTest, AFitHasTheRigidityAndTheIntervalOfTheTable) {
  WriteBytes(folder() / "bend.csv",
             "Specimen;Overhang [mm];Angle [deg]\n1;100,2;41,5\n2;103;42\n3;98,5;41\n4;101;40\n");
  const std::string out = Convert("--density 0.15");
  for (const char* words :
       {"k_bend 0.000190443 N m, 95 % interval 0.000174786 .. 0.000207504, of 4 tests",
        "identify --prior k_bend=0.000190443:1.10283", "fit it: identify --target bend.bin --fit k_bend"}) {
    EXPECT_NE(out.find(words), std::string::npos) << words << "\n" << out;
  }
  const Json fitted = Fit("k_bend");
  EXPECT_NEAR(fitted["value"].get<double>(), 1.90443e-4, 2e-3 * 1.90443e-4);
  EXPECT_NEAR(fitted["lower95"].get<double>(), 1.74786e-4, 0.01 * 1.74786e-4);
  EXPECT_NEAR(fitted["upper95"].get<double>(), 2.07504e-4, 0.01 * 2.07504e-4);
}

TEST_F(MotionCantileverTest, StripsAlongWarpWeftAndBiasTellTheTwist) {
  std::string targets;
  for (const auto& [direction, overhang] : {std::pair("warp", "80"), {"weft", "65"}, {"bias", "70"}}) {
    WriteBytes(folder() / "bend.csv", "Overhang [mm]\n" + std::string(overhang) + "\n");
    const std::string out = Convert("--density 0.15 --direction " + std::string(direction));
    EXPECT_EQ(out.find("--prior"), std::string::npos) << out;
    EXPECT_EQ(out.find("fit it beside strips") != std::string::npos, std::string(direction) == "bias") << out;
    std::filesystem::rename(folder() / "bend.bin", folder() / (std::string(direction) + ".bin"));
    targets += (targets.empty() ? "" : ",") + std::string(direction) + ".bin";
  }
  const ToolResult fit =
      Run("identify --target " + targets + " --fit bend_warp,bend_weft,bend_twist --report=false --output result");
  EXPECT_EQ(fit.exit_code, 0) << fit.out << fit.err;
  const Json parameters = Json::parse(ReadBytes(folder() / "result" / "result.json"))["parameters"];
  const double weight = 0.15 * 9.81, share = 0.4999;  // c/L at 41.5 degrees
  EXPECT_NEAR(parameters["bend_warp"]["value"].get<double>(), weight * std::pow(share * 0.08, 3), 1e-6);
  EXPECT_NEAR(parameters["bend_weft"]["value"].get<double>(), weight * std::pow(share * 0.065, 3), 1e-6);
  EXPECT_GT(parameters["bend_twist"]["value"].get<double>(), 2e-5);
  EXPECT_LT(parameters["bend_twist"]["value"].get<double>(), 4e-5);
}

TEST_F(MotionCantileverTest, AProfileTellsTheRigidityOfADirection) {
  // A strip of 100 mm with the bending length 50 mm: the elastica at tenths of its length.
  std::string table = "x [mm];z [mm]\n";
  double slope = 0.0, x = 0.0, z = 0.0;
  constexpr double kCurvatureAtClamp = 3.20179;  // over the length: then that of the tip is 0
  constexpr int kSteps = 10000;
  double curvature = kCurvatureAtClamp;
  for (int i = 0; i < kSteps; ++i) {
    curvature -= 8.0 / kSteps * (1.0 - (i + 0.5) / kSteps) * std::cos(slope);
    slope += curvature / kSteps;
    x += std::cos(slope) / kSteps;
    z -= std::sin(slope) / kSteps;
    if ((i + 1) % (kSteps / 10) == 0) table += std::to_string(100.0 * x) + ";" + std::to_string(100.0 * z) + "\n";
  }
  EXPECT_NEAR(curvature, 0.0, 0.01);
  WriteBytes(folder() / "bend.csv", table);
  const std::string out = Convert("--density 0.15 --direction weft --sigma 0.0005 --overhang 100");
  EXPECT_NE(out.find("10 points of a strip at rest"), std::string::npos) << out;
  EXPECT_NE(out.find("--fit bend_weft"), std::string::npos) << out;
  const double rigidity = 0.15 * 9.81 * 0.05 * 0.05 * 0.05;
  EXPECT_NEAR(Fit("bend_weft")["value"].get<double>(), rigidity, 0.01 * rigidity);
}

TEST_F(MotionCantileverTest, AnglesOfAPlateTellFriction) {
  WriteBytes(folder() / "plate.csv", "Angle (\xc2\xb0)\n20,5\n21\n19,8\n22\n20,9\n");
  const ToolResult words = Run("motion friction plate.csv");
  EXPECT_EQ(words.out,
            "mu 0.380732, 95 % interval 0.360812 .. 0.400652, standard deviation 0.0160429 of 5 tests\n"
            "as what is believed of the next specimen: identify --prior mu=0.380732:0.0248951\n");
  const Json report = Json::parse(Run("motion friction plate.csv --json").out);
  EXPECT_EQ(report["tests"], 5);
  // 2.776 is Student's t of four degrees of freedom.
  EXPECT_NEAR(report["upper95"].get<double>() - report["mu"].get<double>(), 2.776 * 0.0160429 / std::sqrt(5.0), 1e-5);
  EXPECT_NEAR(report["prior"]["std"].get<double>(), 2.776 / 1.96 * 0.0160429 * std::sqrt(1.2), 1e-5);
  WriteBytes(folder() / "plate.csv", "Angle [deg]\n45\n");
  EXPECT_EQ(Run("motion friction plate.csv").out, "mu 1; one test has no scatter: repeat it for an interval\n");
  EXPECT_FALSE(Json::parse(Run("motion friction plate.csv --json").out).contains("std"));
}

TEST_F(MotionCantileverTest, NamesWhatIsWrong) {
  WriteBytes(folder() / "bend.csv", "Overhang [mm]\n100\n");
  WriteBytes(folder() / "steep.csv", "Angle [deg]\n20\n95\n");
  WriteBytes(folder() / "bare.csv", "Angle\n20\n");
  const std::string convert = "motion convert_cantilever bend.csv bend.bin ";
  ExpectRefused("motion convert_cantilever bend.csv", 1, "a file to write");
  ExpectRefused(convert, 1, "--density: expected the mass per area, kg/m^2, > 0");
  ExpectRefused(convert + "--density 150", 1, "--density: expected the mass per area, kg/m^2, > 0 and at most 10");
  ExpectRefused(convert + "--density 0.15 --sigma 0", 1, "--sigma: expected a number > 0 (m)");
  ExpectRefused(convert + "--density 0.15 --overhang 0", 1, "--overhang: expected a number > 0 (mm)");
  ExpectRefused(convert + "--density 0.15 --overhang 100", 1, "--overhang: expected with a profile alone");
  ExpectRefused(convert + "--density 0.15 --direction up", 1, "--direction: expected warp, weft or bias, got 'up'");
  ExpectRefused("motion convert_cantilever steep.csv bend.bin --density 0.15", 2,
                "steep.csv:1: expected a header with columns of overhang and angle");
  ExpectRefused("motion friction steep.csv", 2, "steep.csv:3: expected an angle between 0 and 80 degrees");
  ExpectRefused("motion friction bare.csv", 2, "bare.csv:1: column 'Angle': expected a unit in brackets");
  ExpectRefused("motion friction none.csv", 1, "none.csv");
}

}  // namespace
}  // namespace clothid::motion_cantilever_test
