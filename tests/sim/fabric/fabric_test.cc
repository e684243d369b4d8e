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
    for (const MeasuredConstant& constant :
         {fabric.density, fabric.k_stretch, fabric.k_bend, fabric.k_warp, fabric.k_weft, fabric.k_shear,
          fabric.stiffening_warp, fabric.stiffening_weft}) {
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

TEST(FabricTest, StandsInForWarpAndWeftTogether) {
  const Scene yarn = Read(R"(, "fabric": "knit", "materials": {"membrane": "yarn", "stiffening_weft": 3})");
  EXPECT_EQ(yarn.material.warp_stiffness, 56.2);
  EXPECT_EQ(yarn.material.weft_stiffness, 92.5);
  EXPECT_EQ(yarn.material.shear_stiffness, 23.0);
  EXPECT_EQ(yarn.material.warp_stiffening, 9.12);
  EXPECT_EQ(yarn.material.weft_stiffening, 3.0);
  const Scene orthotropic = Read(R"(, "fabric": "denim", "materials": {"membrane": "orthotropic"})");
  EXPECT_EQ(orthotropic.material.weft_stiffness, 2030.0);
  EXPECT_EQ(orthotropic.material.weft_stiffening, 0.0) << "that of a membrane of yarns";
  const Scene own = Read(R"(, "fabric": "knit",
                           "materials": {"membrane": "yarn", "k_warp": 200, "k_weft": 100, "k_shear": 50})");
  EXPECT_EQ(own.material.warp_stiffness, 200.0);
  EXPECT_EQ(own.material.warp_stiffening, 0.0) << "that of a knit belongs to its own stiffness";
  ExpectError([] { Read(R"(, "fabric": "light", "materials": {"membrane": "yarn"})"); }, ErrorKind::kBadData,
              {"'materials.k_warp'"});
  ExpectError([] { Read(R"(, "fabric": "knit", "materials": {"membrane": "yarn", "k_warp": 200})"); },
              ErrorKind::kBadData, {"'materials.k_weft'"});
}

// The tension of a yarn at 16.7 % is that which measured entries give: that of the mean knit lies between the least and
// the largest of the three.
TEST(FabricTest, YarnsStiffenAsWasMeasured) {
  const Fabric& knit = *FindFabric("knit");
  const auto tension = [](double k, double stiffening, double strain) {
    return k * std::expm1(stiffening * strain) / stiffening;
  };
  const auto measured = [](double entry) {
    const double stretch = 1.0 + 1.0 / 6.0;
    return stretch * 2.0 * entry * 0.5 * (stretch * stretch - 1.0);
  };
  const double warp = tension(knit.k_warp.typical, knit.stiffening_warp.typical, 1.0 / 6.0);
  EXPECT_GT(warp, measured(46.36));
  EXPECT_LT(warp, measured(78.71));
  const double weft = tension(knit.k_weft.typical, knit.stiffening_weft.typical, 1.0 / 6.0);
  EXPECT_GT(weft, measured(191.8));
  EXPECT_LT(weft, measured(405.9));
  const Fabric& denim = *FindFabric("denim");
  EXPECT_NEAR(tension(denim.k_warp.typical, denim.stiffening_warp.typical, 1.0 / 6.0), measured(232.03), 0.5);
  EXPECT_NEAR(tension(denim.k_weft.typical, denim.stiffening_weft.typical, 1.0 / 6.0), measured(1051.6), 2.0);
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
