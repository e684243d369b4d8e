// From the table of a testing machine to the constants of its law, as a user goes.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>
#include <string>

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

  Json Fit(const std::string& parameters) const {
    const ToolResult fit = Run("identify --target curve.bin --fit " + parameters + " --report=false --output result");
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
          "fit it: identify --target curve.bin --fit k_" + direction + ",stiffening_" + direction}) {
      EXPECT_NE(made.out.find(words), std::string::npos) << words << "\n" << made.out;
    }
    const ToolResult check = Run("motion check curve.bin");
    EXPECT_EQ(check.exit_code, 0) << check.out << check.err;
    const Json parameters = Fit("k_" + direction + ",stiffening_" + direction);
    EXPECT_NEAR(parameters["k_" + direction]["value"].get<double>(), 300.0, 0.02 * 300.0);
    EXPECT_NEAR(parameters["stiffening_" + direction]["value"].get<double>(), 6.0, 0.02 * 6.0);
  }
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

TEST_F(MotionCurveTest, NamesWhatIsWrong) {
  WriteBytes(folder() / "curve.csv", Table(300.0, 6.0));
  WriteBytes(folder() / "bare.csv", "Strain [%],Force [N]\n0,0\n1,1\n");
  WriteBytes(folder() / "bad.csv", "Strain [%],Force [lbf]\n0,0\n1,1\n");
  const std::string convert = "motion convert_curve curve.csv curve.bin --direction warp ";
  ExpectRefused("motion convert_curve curve.csv", 1, "a file to write");
  ExpectRefused("motion convert_curve curve.csv curve.bin", 1, "--direction: expected warp or weft");
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
