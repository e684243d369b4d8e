// adjoint = sensitivity = central finite differences where the rest shape is a UV map and cloth is sewn.
#include <gtest/gtest.h>

#include "tests/sim/derivative/gradient_case.h"
#include "tests/sim/garments.h"
#include "tests/sim/shipped_scenes.h"

namespace clothid::garment_gradient_test {
namespace {

constexpr int kNodes = 8;

enum class SewingKind { kNone, kJoined, kFolded, kDrawn };

struct GarmentParam {
  const char* name;
  SewingKind sewing;
  Integrator integrator;
};

// The scene's cloth, cut in the middle; one piece lies elsewhere in the map.
Mesh SewnMesh(const Mesh& whole, SewingKind sewing) {
  if (sewing == SewingKind::kNone) return WithUvRest(whole);
  const Eigen::Vector3d start = whole.rest_positions.col(4), across = whole.rest_positions.col(5) - start;
  CutMesh cut = Cut(WithUvRest(whole), GridLine(kNodes, kNodes, true, 4),
                    [&](const Eigen::Vector3d& x) { return across.dot(x - start) > 0.0; });
  LayElsewhere(0.7, {1.0, 2.0}, &cut);
  Seam seam = SeamOf(cut);
  seam.is_fold = sewing == SewingKind::kFolded;
  seam.is_drawn = sewing == SewingKind::kDrawn;
  seam.closing_time = 0.13;
  for (std::size_t i = 0; seam.is_drawn && i < cut.beyond.size(); ++i) {  // open by up to 3 mm
    cut.mesh.rest_positions.col(cut.beyond[i]) += 1e-3 * static_cast<double>(i % 4) * across.normalized();
  }
  return Sewn(cut.mesh, {seam});
}

Scene GarmentScene(const std::string& name, const GarmentParam& garment) {
  Scene scene = ShippedScene(name, kNodes);
  scene.integrator = garment.integrator;
  scene.bending = {BendingLaw::kPatches, 0.2};
  scene.duration = 0.3;
  return WithMesh(scene, SewnMesh(scene.mesh, garment.sewing));
}

class GarmentGradientTest : public ::testing::TestWithParam<GarmentParam> {};

TEST_P(GarmentGradientTest, AdjointEqualsSensitivityEqualsDifferences) {
  const GradientCase gradient(GarmentScene("wind", GetParam()));
  for (const char* name : {"k_stretch", "k_bend", "density", "x_0", "v_0"}) {
    EXPECT_TRUE(gradient.HasInfluence(name)) << name;
  }
  ExpectAgreement(gradient, 1e-6);
}

// Over a sphere, by a held edge: the seam starts at a handle.
TEST_P(GarmentGradientTest, InContactToo) {
  const GradientCase gradient(GarmentScene("drape", GetParam()));
  EXPECT_TRUE(gradient.HasInfluence("mu"));
  ExpectAgreement(gradient, 1e-5);
}

std::vector<GarmentParam> AllGarments() {
  std::vector<GarmentParam> all;
  for (const Integrator integrator : {Integrator::kEuler, Integrator::kSdirk2}) {
    for (const auto& [name, sewing] :
         {std::pair("InOnePiece", SewingKind::kNone), std::pair("Joined", SewingKind::kJoined),
          std::pair("Folded", SewingKind::kFolded), std::pair("Drawn", SewingKind::kDrawn)}) {
      all.push_back({name, sewing, integrator});
    }
  }
  return all;
}

INSTANTIATE_TEST_SUITE_P(Garments, GarmentGradientTest, ::testing::ValuesIn(AllGarments()), [](const auto& test) {
  return std::string(test.param.name) + (test.param.integrator == Integrator::kEuler ? "" : "Sdirk2");
});

}  // namespace
}  // namespace clothid::garment_gradient_test
