#include "identify/export/export.h"

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "sim/obstacle/round_shapes.h"
#include "tests/expect_error.h"
#include "tests/sim/garments.h"
#include "tests/sim/plain_scenes.h"

namespace clothid::export_test {
namespace {

// What no file here can tell is refused before a fit, not left out after it.
TEST(ExpectExportableTest, RefusesWhatIsSewn) {
  const Scene plain = ClothScene(SquareGrid(4, 0.3), 0.01);
  EXPECT_NO_THROW(ExpectExportable(plain, "a.bin"));
  EXPECT_FALSE(ExportCloth(plain, plain.nominal_parameters(), {"mujoco"}).empty());
  Scene garment = plain, buttoned = plain;
  garment.mesh = WithUvRest(plain.mesh);
  buttoned.mesh.links = {{0, {15, 15}, 0.0, 100.0, 0.0}};
  for (const Scene& scene : {garment, buttoned}) {
    ExpectError([&] { ExpectExportable(scene, "a.bin"); }, ErrorKind::kUsage,
                {"a.bin: expected a cloth without seams", "\"rest\": \"uv\""});
    ExpectError([&] { ExportCloth(scene, scene.nominal_parameters(), {"mujoco"}); }, ErrorKind::kUsage,
                {"expected a cloth without seams"});
  }
}

std::string TextOf(const Scene& scene, const std::string& simulator) {
  return ExportCloth(scene, scene.nominal_parameters(), {simulator}).front().text;
}

// Every file says what becomes of the friction of the cloth with itself, and of the distance at which it meets itself.
TEST(ExportSelfContactTest, IsTranslatedOrSaidToBeMissing) {
  Scene scene = ClothScene(SquareGrid(4, 0.3), 0.01);
  scene.obstacles.push_back(
      {"table", std::make_shared<Plane>(Eigen::Vector3d(0, 0, -1), Eigen::Vector3d(0, 0, 1)), 0.4, 0.001});
  const std::map<std::string, std::vector<std::string>> words = {
      {"mujoco", {"The cloth goes through itself", "selfcollide=\"none\""}},
      {"newton",
       {"\nMU_SELF = 0.25\n", "\"particle_self_contact_radius\": 0.002", "soft_contact_mu = MU_SELF\n", "MU = 0.4 "}},
      {"arcsim", {"obstacles, Coulomb's: 0.4;", "\"friction\" 0.25; not mapped: its thickness"}},
      {"blender", {"use_self_collision = True\n", "self_distance_min = 0.002 ", "not mapped: mu.self"}},
      {"ppf", {"\"friction\": 0.25,", "friction mode \"max\"", "Not mapped: thickness"}}};
  for (const auto& [simulator, expected] : words) {
    SCOPED_TRACE(simulator);
    scene.self_contact.reset();
    const std::string without = TextOf(scene, simulator);
    scene.self_contact = SelfContact{0.25, 0.002};
    const std::string with = TextOf(scene, simulator);
    EXPECT_NE(with.find("mu.self 0.25, Coulomb friction of the cloth with itself;  thickness 0.002 m\n"),
              std::string::npos);
    EXPECT_EQ(without.find("self 0.25"), std::string::npos);
    for (const std::string& text : expected) EXPECT_NE(with.find(text), std::string::npos) << text << "\n" << with;
  }
  scene.self_contact->friction_coefficient = 0.6;
  EXPECT_NE(TextOf(scene, "ppf").find("friction mode \"min\""), std::string::npos);
}

// None of them stiffens: they get the secant at the strain that was seen, and say so.
TEST(ExportStiffeningTest, IsCutToTheSecantThatWasSeen) {
  Scene scene = ClothScene(SquareGrid(4, 0.3), 0.01);
  scene.membrane = MembraneLaw::kYarn;
  scene.material.warp_stiffness = 100.0;
  scene.material.weft_stiffness = 80.0;
  scene.material.shear_stiffness = 50.0;
  scene.material.warp_stiffening = 5.0;
  FabricCard card;
  card.membrane = MembraneLaw::kYarn;
  card.constants.resize(1);
  card.constants[0].kind = ParameterKind::kWarpStiffness;
  card.constants[0].seen_from = 0.0;
  card.constants[0].seen_to = 0.2;
  const auto text = [&](const FabricCard* seen) {
    return ExportCloth(scene, scene.nominal_parameters(), {"arcsim"}, {}, seen).front().text;
  };
  const std::string secant = text(&card);  // 100 (e - 1) N/m
  EXPECT_NE(secant.find("k_warp 171.8 N/m at 20 % and k_weft 80 N/m at 0 %"), std::string::npos) << secant;
  EXPECT_NE(secant.find("\"stretching\": [[85.91"), std::string::npos) << secant;
  EXPECT_NE(text(nullptr).find("\"stretching\": [[50, 0, 40, 50]"), std::string::npos) << text(nullptr);
}

}  // namespace
}  // namespace clothid::export_test
