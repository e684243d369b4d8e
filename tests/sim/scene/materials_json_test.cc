// Laws and constants of warp and weft in a scene.
#include "sim/scene/materials_json.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "sim/scene/scene_json.h"
#include "sim/scene/warp.h"
#include "tests/expect_error.h"

namespace clothid::materials_json_test {
namespace {

constexpr ErrorKind kBadData = ErrorKind::kBadData;
const char* const kWoven = R"("membrane": "orthotropic", "k_warp": 200, "k_weft": 150, "k_shear": 10)";
const char* const kBent = R"("bending": "patches", "bend_warp": 2e-4, "bend_weft": 1e-4, "bend_twist": 5e-5)";

std::string Text(const std::string& materials, const std::string& more = "") {
  return R"({"clothid_scene": 1, "duration": 1,
"mesh": {"grid": {"nodes": [3, 3], "size": [0.2, 0.2]}},
"materials": {)" +
         materials + "}" + more + "}";
}

Scene Read(const std::string& materials, const std::string& more = "") {
  return ParseScene(Text(materials, more), "scene.json", "");
}

void ExpectBad(const std::string& materials, const std::string& fragment, const std::string& more = "") {
  ExpectError([&] { Read(materials, more); }, kBadData, {"scene.json", fragment.c_str()});
}

std::string Both(const char* more = "") { return std::string(kWoven) + ", " + kBent + more; }

TEST(ReadMaterials, ReadsConstantsOfWarpAndWeft) {
  const Scene scene =
      Read(Both(R"(, "k_poisson": -20, "bend_poisson": 0.1, "warp_direction": [1, 1, 0], "warp_angle": 45)"));
  EXPECT_EQ(scene.membrane, MembraneLaw::kOrthotropic);
  EXPECT_EQ(scene.material.warp_stiffness, 200.0);
  EXPECT_EQ(scene.material.weft_stiffness, 150.0);
  EXPECT_EQ(scene.material.shear_stiffness, 10.0);
  EXPECT_EQ(scene.material.poisson_stiffness, -20.0);
  EXPECT_TRUE(scene.bending.orthotropic);
  EXPECT_TRUE(scene.has_bending());
  EXPECT_EQ(scene.material.warp_bending, 2e-4);
  EXPECT_EQ(scene.material.weft_bending, 1e-4);
  EXPECT_EQ(scene.material.twist_bending, 5e-5);
  EXPECT_EQ(scene.bending.poisson, 0.1);
  const Eigen::Matrix3Xd warp = WarpDirections(scene.warp, scene.mesh);
  EXPECT_LT((warp.colwise() - Eigen::Vector3d::UnitY()).norm(), 1e-15);
  EXPECT_EQ(Read(kWoven).material.poisson_stiffness, 0.0);
  EXPECT_FALSE(Read(kWoven).has_bending());
}

TEST(ReadMaterials, ReadsAMembraneOfYarns) {
  constexpr char kYarns[] = R"("membrane": "yarn", "k_warp": 700, "k_weft": 320, "k_shear": 20, "stiffening_warp": 6)";
  const Scene scene = Read(kYarns);
  EXPECT_EQ(scene.membrane, MembraneLaw::kYarn);
  EXPECT_TRUE(scene.has_warp() && scene.has(ParameterKind::kWarpStiffness));
  EXPECT_EQ(scene.material.warp_stiffening, 6.0);
  EXPECT_EQ(scene.material.weft_stiffening, 0.0);
  EXPECT_TRUE(scene.has(ParameterKind::kWeftStiffening));
  ExpectBad(R"("membrane": "yarn")", "'materials.k_warp': is missing");
  ExpectBad(R"("stiffening_warp": 6)", "'materials.stiffening_warp': expected \"membrane\": \"yarn\" beside it");
  ExpectBad(std::string(kYarns) + R"(, "stiffening_weft": -1)", "'materials.stiffening_weft'");
  EXPECT_FALSE(Read(kWoven).has(ParameterKind::kWarpStiffening));
}

TEST(ReadMaterials, NamesWhatDoesNotGoTogether) {
  ExpectBad(R"("membrane": "knit")", "'materials.membrane': expected \"arap\", \"orthotropic\" or \"yarn\"");
  ExpectBad(R"("membrane": "orthotropic")", "'materials.k_warp': is missing");
  ExpectBad(R"("membrane": "orthotropic", "k_warp": 1, "k_weft": 2)", "'materials.k_shear': is missing");
  ExpectBad(R"("k_warp": 1, "k_weft": 2, "k_shear": 1)",
            "expected \"membrane\": \"orthotropic\" or \"yarn\" beside it");
  ExpectBad(R"("k_poisson": 1)", "'materials.k_poisson': expected \"membrane\": \"orthotropic\" or \"yarn\" beside it");
  ExpectBad(std::string(kWoven) + R"(, "k_stretch": 5)", "'materials.k_stretch': expected none beside 'k_warp'");
  ExpectBad(std::string(kBent) + R"(, "k_bend": 0)", "'materials.k_bend': expected none beside 'bend_warp'");
  ExpectBad(R"("bending": "patches", "bend_warp": 1e-4)", "'materials.bend_weft': is missing");
  ExpectBad(R"("bending": "edges", "bend_warp": 1, "bend_weft": 1, "bend_twist": 1)",
            "'materials.bend_warp': expected \"bending\": \"patches\" beside it");
  ExpectBad(R"("membrane": "orthotropic", "k_warp": 0, "k_weft": 2, "k_shear": 1)",
            "'materials.k_warp': expected a number > 0");
  ExpectBad(R"("warp_angle": 30)", "'materials.warp_angle': expected an orthotropic membrane, or bend_warp, beside it");
  ExpectBad(std::string(kWoven) + R"(, "warp_direction": [0, 0, 2])", "triangle 0 is perpendicular to it");
  ExpectBad(std::string(kWoven) + R"(, "warp_direction": [0, 0, 0])", "expected a direction, not zero");
}

TEST(ReadMaterials, ReadsWhatTheClothBendsTo) {
  const auto is_flat = [](const std::string& version, const std::string& materials) {
    const std::string text = "{\"clothid_scene\": " + version + R"(, "duration": 1,
        "mesh": {"grid": {"nodes": [3, 3], "size": [0.2, 0.2]}}, "materials": {)" +
                             materials + "}}";
    return ParseScene(text, "scene.json", "").bending.is_flat_at_rest;
  };
  EXPECT_FALSE(is_flat("2", ""));
  EXPECT_TRUE(is_flat("2", R"("bend_rest": "flat")"));
  EXPECT_TRUE(is_flat("1", R"("bending": "patches")")) << "as it was";
  EXPECT_FALSE(is_flat("1", R"("bending": "patches", "bend_rest": "mesh")"));
  EXPECT_TRUE(is_flat("2", R"("bending": "edges", "bend_rest": "flat")"));
  ExpectBad(R"("bending": "edges", "bend_rest": "mesh")",
            "'materials.bend_rest': expected \"bending\": \"patches\" beside it");
  ExpectBad(R"("bend_rest": "curved")", "'materials.bend_rest': expected \"mesh\" or \"flat\"");
}

TEST(ReadMaterials, AsksForEnergiesThatAreNeverNegative) {
  ExpectBad(std::string(kWoven) + R"(, "k_poisson": -180)",
            "k_poisson^2 must be below k_warp k_weft, and is 32400, not below 30000");
  ExpectBad(R"("bending": "patches", "bend_warp": 1e-3, "bend_weft": 1e-5, "bend_twist": 1e-5, "bend_poisson": 0.3)",
            "(bend_poisson (bend_warp + bend_weft)/2)^2 must be below bend_warp bend_weft");
}

TEST(ReadMaterials, ASceneHasTheParametersOfItsLaws) {
  const Scene plain = Read(""), woven = Read(Both());
  for (const char* name : {"k_warp", "k_weft", "k_shear", "k_poisson", "bend_warp", "bend_weft", "bend_twist"}) {
    EXPECT_EQ(ParameterName(ParseParameter(name, woven), {}), name);
    ExpectError([&] { ParseParameter(name, plain); }, ErrorKind::kUsage,
                {"parameter '", name, "': the scene has no such term",
                 "expected one of k_stretch, k_bend, density, drag, damping, drag_normal, drag_tangential, added_mass, "
                 "pressure, mu"});
    ExpectBad("", std::string("parameter '") + name + "'",
              std::string(R"(, "parameters": {")") + name + R"(": {"nominal": 1}})");
  }
  for (const char* name : {"k_stretch", "k_bend"}) {
    ExpectError([&] { ParseParameter(name, woven); }, ErrorKind::kUsage,
                {name,
                 "expected one of density, drag, damping, k_warp, k_weft, k_shear, k_poisson, bend_warp, "
                 "bend_weft, bend_twist, drag_normal, drag_tangential, added_mass, pressure, mu"});
  }
  ExpectError([&] { ParseParameter("k", woven); }, ErrorKind::kUsage,
              {"unknown parameter 'k'; expected one of density"});
}

TEST(ReadMaterials, PoissonsCouplingMayBeNegative) {
  const Scene scene = Read(kWoven, R"(, "parameters": {"k_poisson": {"nominal": -5, "lower": -50, "upper": 50}})");
  EXPECT_EQ(scene.nominal_parameters().material.poisson_stiffness, -5.0);
  EXPECT_EQ(scene.parameters.at("k_poisson").lower_bound, -50.0);
  ExpectBad(kWoven, "key 'parameters.k_warp.lower': expected a number >= 0",
            R"(, "parameters": {"k_warp": {"lower": -1}})");
  Parameters parameters = scene.nominal_parameters();
  parameters.material.warp_bending = 1e-4;
  ExpectError([&] { ValidateParameters(parameters, scene, "scene"); }, kBadData,
              {"parameter 'bend_warp' is 0.000100, but the scene was set up without it"});
  parameters = scene.nominal_parameters();
  parameters.material.poisson_stiffness = std::nan("");
  ExpectError([&] { ValidateParameters(parameters, scene, "scene"); }, kBadData, {"'k_poisson'", "a finite number"});
}

TEST(MaterialsJsonTest, ReadsWhatIsBelieved) {
  const Scene scene = Read("\"density\": 0.2", R"(, "parameters": {"mu": {"prior": {"mean": 0.3, "std": 0.1}},
    "density": {"prior": {"median": 0.15, "factor": 2}}, "drag": {"nominal": 1}})");
  EXPECT_EQ(scene.parameters.at("mu").prior.center, 0.3);
  EXPECT_EQ(scene.parameters.at("mu").prior.spread, 0.1);
  EXPECT_EQ(scene.parameters.at("density").prior.center, 0.15);
  EXPECT_EQ(scene.parameters.at("density").prior.spread, 2.0);
  EXPECT_FALSE(scene.parameters.at("drag").prior.is_given());
  Scene wrong = scene;
  wrong.parameters["density"].prior.spread = 1.0;
  ExpectError([&] { ValidateScene(wrong, "scene"); }, kBadData, {"parameters.density.prior", "a factor > 1"});
  wrong = scene;
  wrong.parameters["mu"].frozen = true;
  ExpectError([&] { ValidateScene(wrong, "scene"); }, kBadData, {"parameters.mu.prior", "frozen"});
}

}  // namespace
}  // namespace clothid::materials_json_test
