// From the curve of a laboratory to the friction of a motion, by the card of the cloth, as a user goes.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "datasets/fabric/fabric_card.h"
#include "tests/tools/tool_test.h"

namespace clothid::card_program_test {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kWarp = 60.0, kStiffening = 4.0, kFriction = 0.25;

class CardProgramTest : public ToolTest {
 protected:
  Json Result(const std::string& name) const { return Json::parse(ReadBytes(folder() / name / "result.json")); }

  // The force over the strain of a strip of 50 x 200 mm, with a noise of 0.3 % of the largest.
  static std::string Curve() {
    constexpr double kWidth = 0.05, kLength = 200.0, kPulled = 0.2;  // m, mm
    std::mt19937_64 generator(3);
    std::normal_distribution<double> normal;
    const auto force = [&](double strain) { return kWidth * kWarp * std::expm1(kStiffening * strain) / kStiffening; };
    std::string text = "Width;50;mm\nGauge length;200;mm\n\nExtension;Force\nmm;N\n";
    for (int i = 0; i <= 200; ++i) {
      const double strain = kPulled * i / 200.0;
      text += std::to_string(kLength * strain) + ";" +
              std::to_string(force(strain) + 0.003 * force(kPulled) * normal(generator)) + "\n";
    }
    return text;
  }

  // A sheet held by an edge that falls on a ball, and slides.
  std::string WriteMotionScene(double time_step, const Json& materials, const std::string& name) const {
    Json scene = Json::parse(ReadBytes(CLOTHID_SOURCE_DIR "/datasets/drape.scene.json"));
    scene["time_step"] = time_step;
    scene["mesh"]["grid"]["nodes"] = {8, 8};
    scene["handles"] = {0, 1, 2, 3, 4, 5, 6, 7};
    scene["materials"] = materials;
    scene["materials"].update({{"density", 0.2}, {"k_bend", 2e-3}, {"drag", 0.05}});
    return WriteScene(scene, name);
  }

  void MakeCard() const {
    WriteBytes(folder() / "curve.csv", Curve());
    const ToolResult made = Run("motion convert_curve curve.csv curve.bin --direction warp");
    ASSERT_EQ(made.exit_code, 0) << made.err;
    const ToolResult fit = Run("identify --target curve.bin --fit k_warp,stiffening_warp --output lab");
    ASSERT_EQ(fit.exit_code, 0) << fit.out << fit.err;
  }
};

TEST_F(CardProgramTest, ConstantsOfTheLaboratoryNarrowTheFrictionOfAMotion) {
  MakeCard();
  const FabricCard card = ReadFabricCard((folder() / "lab/fabric.json").string());
  const Json warp = Result("lab")["parameters"]["k_warp"];
  const CardConstant* constant = card.Find(ParameterKind::kWarpStiffness);
  ASSERT_NE(constant, nullptr);
  EXPECT_EQ(constant->value, warp["value"].get<double>());
  EXPECT_EQ(constant->lower95, warp["lower95"].get<double>());
  EXPECT_EQ(constant->upper95, warp["upper95"].get<double>());
  EXPECT_NEAR(constant->seen_to, 0.2, 0.01);
  EXPECT_EQ(card.recordings[0].kind, "tensile curve");
  EXPECT_NE(ReadBytes(folder() / "lab/card.html").find("\"measured\":["), std::string::npos);

  const Json truth = {{"membrane", "yarn"},
                      {"k_warp", kWarp},
                      {"k_weft", 40},
                      {"k_shear", 20},
                      {"stiffening_warp", kStiffening},
                      {"stiffening_weft", 0},
                      {"warp_direction", {0, 1, -0.466}}};
  ExpectSuccess("simulate --scene " + WriteMotionScene(0.00125, truth, "truth.json") +
                " --set mu=" + std::to_string(kFriction) + " --noise 5e-3 --frame_rate 50 --output a.bin");
  Json guess = truth;
  guess["k_warp"] = 30;
  const std::string identify = "identify --target a.bin --scene " + WriteMotionScene(0.0025, guess, "guess.json") +
                               " --fit mu,k_warp --report=false ";
  Run(identify + "--output free");
  const ToolResult fit = Run(identify + "--fabric lab/fabric.json --output held");
  const Json mu = Result("held")["parameters"]["mu"], free = Result("free")["parameters"]["mu"];
  ASSERT_TRUE(mu["lower95"].is_number()) << fit.out << fit.err;
  EXPECT_LE(mu["lower95"].get<double>(), kFriction) << fit.out;
  EXPECT_GE(mu["upper95"].get<double>(), kFriction) << fit.out;
  const auto width = [](const Json& parameter) {
    return parameter["upper95"].get<double>() - parameter["lower95"].get<double>();
  };
  ASSERT_TRUE(free["lower95"].is_number());
  EXPECT_LT(width(mu), width(free));
  const Json prior = Result("held")["parameters"]["k_warp"];
  EXPECT_EQ(prior["start"].get<double>(), constant->value);
  EXPECT_EQ(prior["prior"]["median"].get<double>(), constant->value);
  EXPECT_NEAR(prior["prior"]["factor"].get<double>(), constant->Prior().spread, 1e-9);
}

TEST_F(CardProgramTest, ACardBringsItsLaw) {
  MakeCard();
  const std::string scene = WriteMotionScene(0.01, {{"k_stretch", 50}}, "arap.json");
  ExpectSuccess("simulate --scene " + scene + " --fabric lab/fabric.json --output a.bin");
  const ToolResult info = Run("motion info a.bin");
  EXPECT_NE(info.out.find("k_warp"), std::string::npos) << info.out;
  EXPECT_EQ(info.out.find("k_stretch"), std::string::npos) << info.out;
  // It is in the recording, priors and all.
  Run("identify --target a.bin --fit k_warp --report=false --output again");
  EXPECT_TRUE(Result("again")["parameters"]["k_warp"].contains("prior"));
}

TEST_F(CardProgramTest, RefusesWhatIsNoCard) {
  MakeCard();
  const std::string scene = WriteMotionScene(0.01, {{"k_stretch", 50}}, "arap.json");
  ExpectSuccess("simulate --scene " + scene + " --output a.bin");
  const std::string identify = "identify --target a.bin --fit mu --output ";
  ExpectRefused(identify + "r --fabric missing.json", 1, "missing.json");
  ExpectRefused(identify + "r --fabric lab/result.json", 2, "key 'schema': expected \"clothid.fabric/1\"");
  ExpectRefused(identify + "lab --fabric lab/fabric.json", 1, "--fabric: lab/fabric.json: the results in --output");
  ExpectRefused(identify + "r --fabric lab/fabric.json --prior k_warp=50:2", 1, "'k_warp' is not among");
  ExpectRefused("simulate --scene " + scene + " --fabric lab/card.html --output b.bin", 2, "lab/card.html");
}

}  // namespace
}  // namespace clothid::card_program_test
