// Measured constants of cloth, and where they stand in for those that a scene does not give.
#include "sim/fabric/fabric.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "sim/scene/scene_json.h"
#include "tests/expect_error.h"

namespace clothid::fabric_test {
namespace {

Scene Read(const std::string& members, const std::string& version = "2") {
  return ParseScene("{\"clothid_scene\": " + version +
                        ", \"duration\": 1, \"mesh\": {\"grid\": {\"nodes\": [3, 3], \"size\": [0.2, 0.2]}}" + members +
                        "}",
                    "scene.json", "");
}

TEST(FabricTest, TypicalValuesLieWithinWhatWasMeasured) {
  for (const Fabric& fabric : Fabrics()) {
    for (const MeasuredConstant& constant : {fabric.density, fabric.k_stretch, fabric.k_bend}) {
      EXPECT_EQ(std::isnan(constant.typical), std::isnan(constant.lowest)) << fabric.name;
      if (std::isnan(constant.typical)) continue;
      EXPECT_GT(constant.lowest, 0.0) << fabric.name;
      EXPECT_LE(constant.lowest, constant.typical) << fabric.name;
      EXPECT_LE(constant.typical, constant.highest) << fabric.name;
    }
    EXPECT_EQ(FindFabric(fabric.name), &fabric);
  }
  EXPECT_EQ(FindFabric("velvet"), nullptr);
}

TEST(FabricTest, StandsInForWhatTheSceneDoesNotGive) {
  const Scene knit = Read(R"(, "fabric": "knit")");
  EXPECT_EQ(knit.fabric, "knit");
  EXPECT_EQ(knit.material.density, 0.245);
  EXPECT_EQ(knit.material.stretch_stiffness, 72.0);
  EXPECT_EQ(knit.material.bending_stiffness, 3.2e-5);
  EXPECT_TRUE(knit.has_bending());
  const Scene own = Read(R"(, "fabric": "knit", "materials": {"density": 0.2, "k_bend": 0},
                          "parameters": {"k_stretch": {"nominal": 50}})");
  EXPECT_EQ(own.material.density, 0.2);
  EXPECT_EQ(own.nominal_parameters().material.stretch_stiffness, 50.0);
  EXPECT_FALSE(own.has_bending());
  EXPECT_EQ(Read(R"(, "fabric": "light")").material.stretch_stiffness, Scene().material.stretch_stiffness)
      << "nobody measured that of light fabrics";
}

TEST(FabricTest, RigidityStandsInForRigiditiesAlone) {
  EXPECT_FALSE(Read(R"(, "fabric": "denim")", "1").has_bending()) << "by edges";
  EXPECT_FALSE(Read(R"(, "fabric": "denim", "materials": {"bending": "edges"})").has_bending());
  const Scene woven = Read(R"(, "fabric": "denim",
                            "materials": {"bend_warp": 2e-4, "bend_weft": 1e-4, "bend_twist": 5e-5})");
  EXPECT_EQ(woven.material.bending_stiffness, 0.0);
  EXPECT_EQ(woven.material.density, 0.324);
}

TEST(FabricTest, IsWrittenIntoTheFirstLineOfAScene) {
  EXPECT_EQ(WithFabric("{\n  \"clothid_scene\": 2\n}", "knit", "--fabric", "s.json"),
            "{\"fabric\": \"knit\", \n  \"clothid_scene\": 2\n}");
  EXPECT_EQ(WithFabric(" {}", "knit", "--fabric", "s.json"), " {\"fabric\": \"knit\"}");
  const std::string own = R"({"fabric": "knit"})";
  EXPECT_EQ(WithFabric(own, "knit", "--fabric", "s.json"), own);
  ExpectError([&] { WithFabric(own, "denim", "--fabric", "s.json"); }, ErrorKind::kUsage, {"--fabric", "\"knit\""});
  ExpectError([&] { WithFabric("{}", "velvet", "--fabric", "s.json"); }, ErrorKind::kUsage,
              {"--fabric: expected one of light", "'velvet'"});
  ExpectError([&] { WithFabric("{", "knit", "--fabric", "s.json"); }, ErrorKind::kBadData, {"s.json"});
  for (const char* wrong : {"\"velvet\"", "1"}) {
    ExpectError([&] { Read(std::string(", \"fabric\": ") + wrong); }, ErrorKind::kBadData,
                {"key 'fabric': expected one of light"});
  }
}

}  // namespace
}  // namespace clothid::fabric_test
