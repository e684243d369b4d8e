// From the table of a testing machine to the constants of its law, as a user goes.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include "datasets/motion/motion_file.h"
#include "tests/tools/tool_test.h"

namespace clothid::motion_curve_test {
namespace {

using Json = nlohmann::ordered_json;

class MotionCurveTest : public ToolTest {
 protected:
  static constexpr double kWidth = 0.05, kLength = 0.2;  // m
  static constexpr double kSlack = 0.003;                // m

  // Tension of a cloth that stiffens, N/m.
  static double Tension(double k, double b, double strain) { return k * std::expm1(b * strain) / b; }

  // Slack, the pull to 25 % of strain, and half of the way back, with noise of 0.3 % of the largest force; decimal
  // commas.
  static std::string Table(double k, double b) {
    constexpr double kPulled = 0.25, kRest = kLength + kSlack, kNoise = 0.003;
    constexpr int kNumReadings = 900;
    std::mt19937_64 generator(7);
    std::normal_distribution<double> normal;
    std::string text =
        "\"Specimen\";\"made up\"\n\"Width\";\"50,0\";\"mm\"\n\"Gauge length\";\"200,0\";\"mm\"\n\n"
        "\"Time\";\"Extension\";\"Force\"\n\"s\";\"mm\";\"N\"\n";
    for (int i = 0; i < kNumReadings * 3 / 2; ++i) {
      const double way = (i < kNumReadings ? i : 2 * kNumReadings - i) / (1.0 * kNumReadings);
      const double elongation = way * (kSlack + kPulled * kRest);
      const double strain = std::max(0.0, (elongation - kSlack) / kRest);
      const double force = kWidth * (Tension(k, b, strain) + kNoise * Tension(k, b, kPulled) * normal(generator)) *
                           (i <= kNumReadings ? 1.0 : 0.8);
      char line[100];
      std::snprintf(line, sizeof line, "%.4f;%.5f;%.6f\n", 0.1 * i, 1e3 * elongation, force);
      for (char* c = line; *c != 0; ++c) *c = *c == '.' ? ',' : *c;
      text += line;
    }
    return text;
  }

  // Pulls a strip of 50 x 100 mm between clamps by 15 % and writes the curve of a machine. The mesh is twice as fine as
  // that of a bias strip which is fitted.
  // Where warp and weft are coupled, with the width in the middle.
  void PullStrip(const std::string& direction, double poisson = 0.0) const {
    constexpr int kAcross = 17, kAlong = 33;
    constexpr double kPulled = 0.15, kStrip = 0.1;
    std::string header = "time", start = "0", end = "10", lower, upper;
    std::vector<int> nodes;
    for (const bool is_upper : {false, true}) {
      for (int i = 0; i < kAcross; ++i) {
        nodes.push_back(is_upper ? kAcross * (kAlong - 1) + i : i);
        std::string& group = is_upper ? upper : lower;
        group += (group.empty() ? "" : ",") + std::to_string(nodes.back());
        const std::string k = std::to_string(nodes.size() - 1), x = "," + std::to_string(kWidth * (i / 16.0 - 0.5));
        header += ",x" + k + ",y" + k + ",z" + k;
        start += x + ",0," + std::to_string(is_upper ? kStrip : 0.0);
        end += x + ",0," + std::to_string(is_upper ? kStrip * (1.0 + kPulled) : 0.0);
      }
    }
    WriteBytes(folder() / "path.csv", header + "\n" + start + "\n" + end + "\n");
    WriteScene({{"clothid_scene", 2},
                {"time_step", 0.1},
                {"integrator", "euler"},
                {"gravity", {0, 0, 0}},
                {"duration", 10},
                {"mesh",
                 {{"grid",
                   {{"nodes", {kAcross, kAlong}},
                    {"size", {kWidth, kStrip}},
                    {"origin", {-0.5 * kWidth, 0, 0}},
                    {"axes", {{1, 0, 0}, {0, 0, 1}}}}}}},
                {"handles", {{"nodes", nodes}, {"path", "path.csv"}}},
                {"solver", {{"step_tolerance", 1e-5}}},
                {"materials",
                 {{"density", 0.2},
                  {"membrane", "yarn"},
                  {"k_warp", 600},
                  {"k_weft", 250},
                  {"k_shear", 40},
                  {"k_poisson", poisson},
                  {"stiffening_warp", 5},
                  {"stiffening_weft", 3},
                  {"warp_direction", {direction == "weft" ? 1 : 0, 0, direction == "weft" ? 0 : 1}},
                  {"warp_angle", direction == "bias" ? 45 : 0}}}});
    ExpectSuccess("simulate --scene scene.json --forces --force_nodes " + lower + ":" + upper +
                  " --output fine.bin >/dev/null");
    const RecordedMotion fine = ReadMotion((folder() / "fine.bin").string());
    std::string table = std::string("Extension [mm];Force [N]") + (poisson == 0.0 ? "\n" : ";Width [mm]\n");
    const int left = kAcross * (kAlong / 2), right = left + kAcross - 1;
    for (int i = 0; i < fine.forces.num_readings(); ++i) {
      table += std::to_string(1e3 * kPulled * kStrip * fine.forces.times[i] / 10.0) + ";" +
               std::to_string(fine.forces.values(fine.forces.values.rows() - 1, i));
      const double width = fine.positions(3 * right, i) - fine.positions(3 * left, i);
      table += poisson == 0.0 ? "\n" : ";" + std::to_string(1e3 * width) + "\n";
    }
    WriteBytes(folder() / (direction + ".csv"), table);
  }

  Json Fit(const std::string& parameters, const std::string& targets = "curve.bin") const {
    const ToolResult fit =
        Run("identify --target " + targets + " --fit " + parameters + " --report=false --output result");
    EXPECT_EQ(fit.exit_code, 0) << fit.out << fit.err;
    return Json::parse(ReadBytes(folder() / "result" / "result.json"))["parameters"];
  }
};

TEST_F(MotionCurveTest, AFitFindsTheLawOfACurve) {
  WriteBytes(folder() / "curve.csv", Table(300.0, 6.0));
  for (const std::string direction : {"warp", "weft"}) {
    const ToolResult made = Run("motion convert_curve curve.csv curve.bin --direction " + direction);
    ASSERT_EQ(made.exit_code, 0) << made.err;
    EXPECT_EQ(made.err, "");
    for (const std::string& words :
         {std::string("left out: 449 readings after the end of the loading"), std::string("readings of slack"),
          "fit it: identify --target curve.bin --fit k_" + direction + ",stiffening_" + direction +
              ",force_bias.z\n"}) {
      EXPECT_NE(made.out.find(words), std::string::npos) << words << "\n" << made.out;
    }
    const ToolResult check = Run("motion check curve.bin");
    EXPECT_EQ(check.exit_code, 0) << check.out << check.err;
    const Json parameters = Fit("k_" + direction + ",stiffening_" + direction);
    EXPECT_NEAR(parameters["k_" + direction]["value"].get<double>(), 300.0, 0.02 * 300.0);
    EXPECT_NEAR(parameters["stiffening_" + direction]["value"].get<double>(), 6.0, 0.02 * 6.0);
  }
}

TEST_F(MotionCurveTest, CurvesAlongWarpWeftAndBiasTellTheShearStiffness) {
  for (const std::string direction : {"warp", "weft", "bias"}) {
    PullStrip(direction);
    const ToolResult made = Run("motion convert_curve " + direction + ".csv " + direction +
                                ".bin --specimen 50x100 --force_sigma 0.001 --direction " + direction);
    ASSERT_EQ(made.exit_code, 0) << made.err;
    EXPECT_EQ(made.err, "");
    EXPECT_NE(made.out.find(direction == "bias" ? "9 x 17 nodes" : "9 x 9 nodes"), std::string::npos) << made.out;
  }
  const Json parameters = Fit("k_warp,k_weft,k_shear,stiffening_warp,stiffening_weft", "warp.bin,weft.bin,bias.bin");
  EXPECT_NEAR(parameters["k_warp"]["value"].get<double>(), 600.0, 0.01 * 600.0);
  EXPECT_NEAR(parameters["k_weft"]["value"].get<double>(), 250.0, 0.01 * 250.0);
  EXPECT_NEAR(parameters["k_shear"]["value"].get<double>(), 40.0, 0.02 * 40.0);
  EXPECT_NEAR(parameters["stiffening_warp"]["value"].get<double>(), 5.0, 0.02 * 5.0);
  EXPECT_NEAR(parameters["stiffening_weft"]["value"].get<double>(), 3.0, 0.02 * 3.0);
}

// The truth has a mesh twice as fine.
TEST_F(MotionCurveTest, TheWidthTellsWhatCouplesWarpAndWeft) {
  for (const std::string direction : {"warp", "weft"}) {
    PullStrip(direction, 100.0);
    const ToolResult made = Run("motion convert_curve " + direction + ".csv " + direction +
                                ".bin --specimen 50x100 --force_sigma 0.001 --direction " + direction);
    ASSERT_EQ(made.exit_code, 0) << made.err;
    EXPECT_NE(made.out.find(" mm between the marks at rest"), std::string::npos) << made.out;
    EXPECT_NE(made.out.find(",k_poisson,force_bias.z"), std::string::npos) << made.out;
  }
  const Json parameters = Fit("k_warp,k_weft,k_poisson,stiffening_warp,stiffening_weft", "warp.bin,weft.bin");
  EXPECT_NEAR(parameters["k_poisson"]["value"].get<double>(), 100.0, 0.03 * 100.0);
  EXPECT_NEAR(parameters["k_warp"]["value"].get<double>(), 600.0, 0.01 * 600.0);
  EXPECT_NEAR(parameters["k_weft"]["value"].get<double>(), 250.0, 0.01 * 250.0);
}

TEST_F(MotionCurveTest, TheOrthotropicLawHasOneStiffness) {
  WriteBytes(folder() / "curve.csv", Table(300.0, 1e-9));
  const ToolResult made =
      Run("motion convert_curve curve.csv curve.bin --specimen 50x200 --direction weft "
          "--membrane orthotropic --strain 0:0.03 --nodes 3x4 --force_sigma 0.01");
  ASSERT_EQ(made.exit_code, 0) << made.err;
  EXPECT_NE(made.out.find("at strains outside of 0:0.03"), std::string::npos) << made.out;
  EXPECT_NE(made.out.find("3 x 4 nodes"), std::string::npos) << made.out;
  const Json parameters = Fit("k_weft");
  // St. Venant and Kirchhoff: Y e (1 + e)(1 + e/2).
  EXPECT_NEAR(parameters["k_weft"]["value"].get<double>(), 300.0 / (1.0 + 1.5 * 0.022), 0.02 * 300.0);
}

TEST_F(MotionCurveTest, TellsWhatIsDoubtful) {
  std::string table = "Extension [mm];Force [kN]\n";
  for (int i = 0; i < 200; ++i)
    table += std::to_string(0.2 * i) + ";" + std::to_string(i < 120 ? 0.1 * i : 0.1 * i - 3) + "\n";
  WriteBytes(folder() / "curve.csv", table);
  const ToolResult made = Run("motion convert_curve curve.csv curve.bin --specimen 50x200 --direction warp");
  EXPECT_EQ(made.exit_code, 0) << made.err;
  for (const char* words :
       {"slip                  warning  the force falls by 2.", "is the unit of the force off by 10^"}) {
    EXPECT_NE(made.out.find(words), std::string::npos) << words << "\n" << made.out;
  }
}

TEST_F(MotionCurveTest, NamesWhatIsWrong) {
  WriteBytes(folder() / "curve.csv", Table(300.0, 6.0));
  WriteBytes(folder() / "bare.csv", "Strain [%],Force [N]\n0,0\n1,1\n");
  WriteBytes(folder() / "bad.csv", "Strain [%],Force [lbf]\n0,0\n1,1\n");
  const std::string convert = "motion convert_curve curve.csv curve.bin --direction warp ";
  ExpectRefused("motion convert_curve curve.csv", 1, "a file to write");
  ExpectRefused("motion convert_curve curve.csv curve.bin", 1, "--direction: expected warp, weft or bias");
  ExpectRefused("motion convert_curve curve.csv curve.npy --direction warp", 1, ".bin");
  ExpectRefused("motion convert_curve curve.bin curve.bin --direction warp", 1, "curve.bin");
  ExpectRefused("motion convert_curve none.csv curve.bin --direction warp", 1, "none.csv");
  ExpectRefused("motion convert_curve bare.csv curve.bin --direction warp", 1, "bare.csv: does not tell the width");
  ExpectRefused("motion convert_curve bad.csv curve.bin --direction warp", 2, "bad.csv:1: column 'Force [lbf]'");
  ExpectRefused(convert + "--specimen 50", 1, "--specimen: expected WIDTHxLENGTH in mm");
  ExpectRefused(convert + "--specimen 0x200", 1, "--specimen: expected WIDTHxLENGTH in mm");
  ExpectRefused(convert + "--gauge -1", 1, "--gauge: expected a number > 0 (mm)");
  ExpectRefused(convert + "--strain 0.2:0.1", 1, "--strain: expected FROM:TO");
  ExpectRefused(convert + "--preload 0", 1, "--preload");
  ExpectRefused(convert + "--preload 1000", 2, "curve.csv: its largest force is");
  ExpectRefused(convert + "--membrane arap", 1, "--membrane: expected yarn or orthotropic");
  ExpectRefused(convert + "--nodes 9x2", 1, "--nodes: expected NXxNY");
  ExpectRefused(convert + "--frame_rate 25", 1, "frame_rate");
  ExpectRefused("motion convert curve.csv out.bin --force_sigma 1", 1, "--force_sigma: expected with --forces");
}

}  // namespace
}  // namespace clothid::motion_curve_test
