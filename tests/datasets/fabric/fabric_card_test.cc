// fabric.json: it reads back, names what is wrong with it, and dresses a scene.
#include "datasets/fabric/fabric_card.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "datasets/fabric/scene_with_fabric.h"
#include "sim/scene/scene_json.h"
#include "tests/expect_error.h"

namespace clothid::fabric_card_test {
namespace {

using Json = nlohmann::ordered_json;
using Kind = ParameterKind;

CardConstant Told(Kind kind, double value, double lower, double upper) {
  CardConstant constant;
  constant.kind = kind;
  constant.value = value;
  constant.known_by = KnownBy::kFitted;
  constant.lower95 = lower;
  constant.upper95 = upper;
  return constant;
}

CardConstant Assumed(Kind kind, double value) {
  CardConstant constant;
  constant.kind = kind;
  constant.value = value;
  return constant;
}

// Of a cloth that was pulled along its warp.
FabricCard YarnCard() {
  FabricCard card;
  card.program = "0.0.0";
  card.membrane = MembraneLaw::kYarn;
  card.constants = {Assumed(Kind::kDensity, 0.2),          Told(Kind::kWarpStiffness, 400.0, 380.0, 421.0),
                    Assumed(Kind::kWeftStiffness, 1000.0), Assumed(Kind::kShearStiffness, 500.0),
                    Assumed(Kind::kPoissonStiffness, 0.0), Told(Kind::kWarpStiffening, 3.0, 2.5, 3.6),
                    Assumed(Kind::kWeftStiffening, 3.0)};
  card.constants[1].seen_from = 0.0;
  card.constants[1].seen_to = 0.25;
  card.constants[1].scatter = 0.1;
  CardRecording recording;
  recording.name = "warp.bin";
  recording.kind = "tensile curve";
  recording.num_nodes = 81;
  recording.edge_length = 0.01;
  recording.time_step = 0.1;
  card.recordings = {recording};
  return card;
}

class FabricCardTest : public testing::Test {
 protected:
  FabricCardTest() {
    std::string name = testing::TempDir() + "clothid_card_XXXXXX";
    EXPECT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
    path_ = folder_ + "/fabric.json";
  }
  ~FabricCardTest() override { std::filesystem::remove_all(folder_); }

  const std::string& Write(const std::string& text) const {
    std::ofstream(path_, std::ios::binary) << text;
    return path_;
  }

  // The text of the card with `value` at the place `pointer`.
  void ExpectRefused(const char* pointer, const Json& value, const char* culprit) const {
    Json json = Json::parse(FabricCardJson(YarnCard()));
    json[Json::json_pointer(pointer)] = value;
    Write(json.dump(2));
    ExpectError([&] { ReadFabricCard(path_); }, ErrorKind::kBadData, {path_.c_str(), culprit});
  }

  std::string folder_, path_;
};

Scene Dressed(const std::string& members, const FabricCard& card, const std::string& version = "2") {
  const std::string text = "{\"clothid_scene\": " + version +
                           ", \"duration\": 1, \"mesh\": {\"grid\": {\"nodes\": [3, 3], \"size\": [0.2, 0.2]}}" +
                           members + "}";
  return ParseScene(WithFabricCard(text, card, "scene.json"), "scene.json", "");
}

TEST_F(FabricCardTest, ReadsBackWhatItWrote) {
  const FabricCard card = YarnCard();
  const FabricCard again = ReadFabricCard(Write(FabricCardJson(card)));
  EXPECT_EQ(FabricCardJson(again), FabricCardJson(card));
  EXPECT_EQ(again.membrane, MembraneLaw::kYarn);
  ASSERT_NE(again.Find(Kind::kWarpStiffness), nullptr);
  EXPECT_EQ(again.Find(Kind::kWarpStiffness)->seen_to, 0.25);
  EXPECT_TRUE(std::isnan(again.recordings[0].load));
  EXPECT_EQ(again.Find(Kind::kStretchStiffness), nullptr);
}

TEST_F(FabricCardTest, KeepsTheForcesThatSimulationsLack) {
  FabricCard card = YarnCard();
  EXPECT_EQ(FabricCardJson(card).find("missing_force"), std::string::npos);
  card.missing_forces = {{0.2, 0.05, 0.1, 2.5}, {0.1, 1.0, 0.1, 2.5}};
  const FabricCard again = ReadFabricCard(Write(FabricCardJson(card)));
  ASSERT_EQ(again.missing_forces.size(), 2u);
  EXPECT_EQ(again.missing_forces[0].deviation, 0.2);
  EXPECT_EQ(again.missing_forces[0].length, 0.1);
  EXPECT_EQ(again.missing_forces[1].time, 1.0);
  EXPECT_EQ(again.missing_forces[1].factor, 2.5);
  Json json = Json::parse(FabricCardJson(card));
  json["missing_force"] = json["missing_force"][0];  // as older cards have it
  EXPECT_EQ(ReadFabricCard(Write(json.dump())).missing_forces.size(), 1u);
  json["missing_force"]["factor"] = -1.0;
  Write(json.dump());
  ExpectError([&] { ReadFabricCard(path_); }, ErrorKind::kBadData, {"key 'missing_force.factor'"});
}

TEST_F(FabricCardTest, NamesWhatIsWrong) {
  ExpectRefused("/schema", "clothid.result/1", "key 'schema': expected \"clothid.fabric/1\"");
  ExpectRefused("/color", "red", "color");
  ExpectRefused("/membrane", "rubber", "key 'membrane': expected one of \"arap\"");
  ExpectRefused("/constants/k_stretch", Json::object(), "key 'constants.k_stretch': expected a constant of a cloth");
  ExpectRefused("/constants/mu", Json::object(), "key 'constants.mu': expected a constant of a cloth");
  ExpectRefused("/constants/k_warp/value", -1.0, "key 'constants.k_warp.value': expected a finite number > 0");
  ExpectRefused("/constants/k_warp/unit", "N/cm", "key 'constants.k_warp.unit': expected \"N/m\"");
  ExpectRefused("/constants/k_warp/known", "guessed", "key 'constants.k_warp.known': expected one of");
  ExpectRefused("/constants/k_warp/lower95", nullptr, "key 'constants.k_warp': expected 0 < lower95 < upper95");
  ExpectRefused("/constants/k_weft/lower95", 3.0, "key 'constants.k_weft': expected lower95 and upper95 null");
  ExpectRefused("/constants/k_warp/seen/quantity", "load", "key 'constants.k_warp.seen.quantity': expected \"strain\"");
  ExpectRefused("/recordings/0/nodes", 0, "key 'recordings[0].nodes'");
  Json json = Json::parse(FabricCardJson(YarnCard()));
  json["constants"].erase("k_shear");
  Write(json.dump());
  ExpectError([&] { ReadFabricCard(path_); }, ErrorKind::kBadData, {"key 'constants.k_shear': is missing"});
}

TEST_F(FabricCardTest, PriorIsAsWideAsIntervalAndScatter) {
  CardConstant constant = Told(Kind::kWarpStiffness, 400.0, 400.0 / 1.21, 400.0 * 1.21);
  EXPECT_NEAR(std::log(constant.Prior().spread), std::log(1.21) / 1.96, 1e-12);
  EXPECT_EQ(constant.Prior().center, 400.0);
  constant.scatter = 0.3;
  EXPECT_NEAR(std::log(constant.Prior().spread), std::hypot(0.3, std::log(1.21) / 1.96), 1e-12);
  CardConstant believed;
  believed.kind = Kind::kWarpStiffness;
  believed.Believe({400.0, 1.3});
  EXPECT_EQ(believed.Prior().center, 400.0);
  EXPECT_NEAR(believed.Prior().spread, 1.3, 1e-12);
  const CardConstant coupling = Told(Kind::kPoissonStiffness, -10.0, -30.0, 10.0);
  EXPECT_NEAR(coupling.Prior().spread, 20.0 / 1.96, 1e-12) << "no logarithm";
}

TEST_F(FabricCardTest, DressesASceneOfAnotherLaw) {
  const Scene scene = Dressed(R"(, "materials": {"density": 0.3, "k_stretch": 50, "k_bend": 1e-5},
                                  "parameters": {"k_stretch": {"lower": 1}, "density": {"frozen": true}})",
                              YarnCard());
  EXPECT_EQ(scene.membrane, MembraneLaw::kYarn);
  EXPECT_EQ(scene.material.warp_stiffness, 400.0);
  EXPECT_EQ(scene.material.warp_stiffening, 3.0);
  EXPECT_EQ(scene.material.weft_stiffness, 1000.0) << "assumed, but the law needs it";
  EXPECT_EQ(scene.material.density, 0.3) << "assumed by the card, known to the scene";
  EXPECT_EQ(scene.material.bending_stiffness, 1e-5) << "the card has none";
  EXPECT_EQ(scene.parameters.count("k_stretch"), 0u);
  EXPECT_TRUE(scene.parameters.at("density").frozen);
  const ParameterPrior prior = scene.parameters.at("k_warp").prior;
  EXPECT_EQ(prior.center, 400.0);
  EXPECT_EQ(prior.spread, YarnCard().Find(Kind::kWarpStiffness)->Prior().spread);
  EXPECT_EQ(scene.parameters.count("k_weft"), 0u) << "nothing tells it";
}

TEST_F(FabricCardTest, KeepsWhatASceneOfTheSameLawKnows) {
  const Scene scene =
      Dressed(R"(, "materials": {"membrane": "yarn", "k_warp": 1, "k_weft": 2, "k_shear": 3, "warp_angle": 30},
                  "parameters": {"k_warp": {"nominal": 90, "lower": 10, "upper": 5000},
                                 "stiffening_warp": {"nominal": 5, "frozen": true}})",
              YarnCard());
  EXPECT_EQ(scene.nominal_parameters().material.warp_stiffness, 400.0);
  EXPECT_EQ(scene.material.weft_stiffness, 2.0);
  EXPECT_EQ(scene.material.shear_stiffness, 3.0);
  EXPECT_EQ(scene.warp.angle, 30.0);
  EXPECT_EQ(scene.parameters.at("k_warp").lower_bound, 10.0);
  EXPECT_EQ(scene.nominal_parameters().material.warp_stiffening, 3.0);
  EXPECT_FALSE(scene.parameters.at("stiffening_warp").prior.is_given()) << "frozen";
}

TEST_F(FabricCardTest, BendingBecomesThatOfPatches) {
  FabricCard card;
  card.bend_poisson = 0.2;
  card.constants = {Assumed(Kind::kStretchStiffness, 77.0), Told(Kind::kWarpBending, 2e-5, 1e-5, 4e-5),
                    Assumed(Kind::kWeftBending, 1e-5), Assumed(Kind::kTwistBending, 5e-6)};
  const Scene scene = Dressed(R"(, "materials": {"k_stretch": 60, "k_bend": 1e-3})", card, "1");
  EXPECT_EQ(scene.bending.law, BendingLaw::kPatches);
  EXPECT_TRUE(scene.bending.orthotropic);
  EXPECT_EQ(scene.bending.poisson, 0.2);
  EXPECT_EQ(scene.material.warp_bending, 2e-5);
  EXPECT_EQ(scene.material.weft_bending, 1e-5);
  EXPECT_EQ(scene.material.stretch_stiffness, 60.0) << "no constant of the membrane is told";
}

TEST_F(FabricCardTest, RefusesWhatWouldHaveNoEffect) {
  FabricCard card;
  card.constants = {Told(Kind::kStretchStiffness, 77.0, 70.0, 85.0)};
  ExpectError([&] { Dressed(R"(, "fields": {"k_stretch": [[50, 60], [70, 80]]})", card); }, ErrorKind::kUsage,
              {"scene.json: key 'fields.k_stretch': expected none"});
  card.constants = {Assumed(Kind::kStretchStiffness, 77.0)};
  Write(FabricCardJson(card));
  ExpectError([&] { ReadToldCard(path_); }, ErrorKind::kBadData, {"fabric.json: key 'constants': expected one"});
  ExpectError([&] { WithFabricOrCard("{}", folder_ + "/none.json", "--fabric", "scene.json"); }, ErrorKind::kIo,
              {"none.json"});
  ExpectError([&] { WithFabricOrCard("{}", "velvet", "--fabric", "scene.json"); }, ErrorKind::kUsage,
              {"--fabric: expected one of light"});
  EXPECT_EQ(WithFabricOrCard("{}", "knit", "--fabric", "scene.json"), "{\"fabric\": \"knit\"}");
}

}  // namespace
}  // namespace clothid::fabric_card_test
