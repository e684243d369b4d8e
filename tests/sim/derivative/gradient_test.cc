// adjoint = sensitivity = central finite differences, for every parameter, in every shipped scene, contact mode and
// integrator.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <memory>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "sim/obstacle/triangulated_surface.h"
#include "tests/sim/curved_rest.h"
#include "tests/sim/derivative/gradient_case.h"
#include "tests/sim/pieces_scene.h"
#include "tests/sim/scene/triangle_meshes.h"
#include "tests/sim/shipped_scenes.h"
#include "tests/sim/woven_scene.h"

namespace clothid::gradient_test {
namespace {

using GradientParam = std::tuple<std::string, ContactMode, Integrator>;

class GradientTest : public ::testing::TestWithParam<GradientParam> {};

// The cases with either integrator.
std::vector<GradientParam> WithIntegrators(const std::vector<std::pair<std::string, ContactMode>>& cases) {
  std::vector<GradientParam> params;
  for (const Integrator integrator : {Integrator::kEuler, Integrator::kSdirk2}) {
    for (const auto& [name, mode] : cases) params.emplace_back(name, mode, integrator);
  }
  return params;
}

Scene SceneOf(const GradientParam& param, int nodes) {
  Scene scene = ShippedScene(std::get<0>(param), nodes);
  scene.contact_mode = std::get<1>(param);
  scene.integrator = std::get<2>(param);
  if (scene.integrator == Integrator::kSdirk2 && std::get<0>(param) == "slope") Land(&scene);
  return scene;
}

TEST_P(GradientTest, AdjointEqualsSensitivityEqualsDifferences) {
  const auto [name, mode, integrator] = GetParam();
  const Scene scene = SceneOf(GetParam(), integrator == Integrator::kEuler ? 12 : 9);
  const bool gap_mode_sphere = name == "drape" && mode == ContactMode::kGap;
  ExpectAgreement(GradientCase(scene), gap_mode_sphere ? 1e-5 : 1e-6);
}

std::string CaseName(const ::testing::TestParamInfo<GradientParam>& info) {
  return std::get<0>(info.param) + (std::get<1>(info.param) == ContactMode::kGap ? "Gap" : "Velocity") +
         (std::get<2>(info.param) == Integrator::kEuler ? "" : "Sdirk2");
}

INSTANTIATE_TEST_SUITE_P(Scenes, GradientTest,
                         ::testing::ValuesIn(WithIntegrators({{"drape", ContactMode::kGap},
                                                              {"drape", ContactMode::kVelocity},
                                                              {"slope", ContactMode::kGap},
                                                              {"slope", ContactMode::kVelocity},
                                                              {"wind", ContactMode::kGap}})),
                         CaseName);

class PatchBendingGradientTest : public GradientTest {};

TEST_P(PatchBendingGradientTest, AdjointEqualsSensitivityEqualsDifferences) {
  Scene scene = SceneOf(GetParam(), 10);
  scene.bending = {BendingLaw::kPatches, 0.3};
  const GradientCase gradient(scene);
  EXPECT_EQ(gradient.HasInfluence("k_bend"), std::get<0>(GetParam()) != "slope");  // on which the cloth lies flat
  ExpectAgreement(gradient, 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Scenes, PatchBendingGradientTest,
                         ::testing::Values(GradientParam("drape", ContactMode::kGap, Integrator::kEuler),
                                           GradientParam("drape", ContactMode::kVelocity, Integrator::kEuler),
                                           GradientParam("slope", ContactMode::kGap, Integrator::kEuler),
                                           GradientParam("wind", ContactMode::kGap, Integrator::kEuler),
                                           GradientParam("wind", ContactMode::kGap, Integrator::kSdirk2)),
                         CaseName);

// Internal damping with a relaxation time of some steps.
Scene Damped(Scene scene) {
  scene.material.damping = 0.01 * scene.nominal_parameters().material.stretch_stiffness;
  return scene;
}

class DampedGradientTest : public GradientTest {};

TEST_P(DampedGradientTest, AdjointEqualsSensitivityEqualsDifferences) {
  const GradientCase gradient(Damped(SceneOf(GetParam(), 8)));
  EXPECT_TRUE(gradient.HasInfluence("damping"));
  EXPECT_EQ(gradient.HasInfluence("mu"), std::get<0>(GetParam()) == "drape");
  ExpectAgreement(gradient, 1e-6);
}

// Not `slope`, on which the cloth slides without strain.
INSTANTIATE_TEST_SUITE_P(Scenes, DampedGradientTest,
                         ::testing::ValuesIn(WithIntegrators({{"drape", ContactMode::kGap},
                                                              {"drape", ContactMode::kVelocity},
                                                              {"wind", ContactMode::kGap}})),
                         CaseName);

class WovenGradientTest : public GradientTest {};

TEST_P(WovenGradientTest, AdjointEqualsSensitivityEqualsDifferences) {
  Scene scene = Woven(SceneOf(GetParam(), 7));
  scene.duration *= 0.4;
  const GradientCase gradient(scene);
  for (const char* name : {"k_warp", "k_weft", "k_shear", "k_poisson", "bend_warp", "bend_weft", "bend_twist"}) {
    EXPECT_TRUE(gradient.HasInfluence(name)) << name;
  }
  EXPECT_EQ(gradient.HasInfluence("mu"), std::get<0>(GetParam()) == "drape");
  ExpectAgreement(gradient, 1e-6);
}

TEST_P(WovenGradientTest, OfYarnsInPiecesToo) {
  Scene scene = Knitted(SceneOf(GetParam(), 7));
  scene.duration *= 0.3;
  const GradientCase gradient(InPieces(scene, 1.5, 0.6));
  for (const char* name : {"k_warp", "k_weft", "k_shear", "k_poisson", "stiffening_warp", "stiffening_weft", "k_weft.a",
                           "stiffening_warp.b"}) {
    EXPECT_TRUE(gradient.HasInfluence(name)) << name;
  }
  ExpectAgreement(gradient, 1e-6);
}

TEST_P(WovenGradientTest, WithInternalDampingToo) {
  Scene scene = Woven(SceneOf(GetParam(), 6));
  scene.material.damping = 0.01 * scene.material.warp_stiffness;
  scene.duration *= 0.3;
  const GradientCase gradient(scene);
  EXPECT_TRUE(gradient.HasInfluence("damping"));
  EXPECT_TRUE(gradient.HasInfluence("k_poisson"));
  ExpectAgreement(gradient, 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Scenes, WovenGradientTest,
                         ::testing::ValuesIn(WithIntegrators({{"drape", ContactMode::kGap},
                                                              {"drape", ContactMode::kVelocity},
                                                              {"wind", ContactMode::kGap}})),
                         CaseName);

// Constants of pieces, and of all of them at once, isotropic and woven.
class PiecesGradientTest : public GradientTest {};

TEST_P(PiecesGradientTest, AdjointEqualsSensitivityEqualsDifferences) {
  for (const bool woven : {false, true}) {
    Scene scene = SceneOf(GetParam(), 7);
    scene.duration *= 0.25;
    scene.bending.law = BendingLaw::kPatches;
    if (woven) scene = Woven(scene);
    scene.material.damping = woven ? 0.3 : 0.5;
    scene.material.drag = 0.05;
    const GradientCase gradient(InPieces(scene, 1.5, 0.6));
    for (const char* name : {"density.a", "density.b", "damping.a", "drag.b"}) {
      EXPECT_TRUE(gradient.HasInfluence(name)) << name;
    }
    for (const char* name : {"k_stretch.a", "k_bend.a"}) EXPECT_NE(gradient.HasInfluence(name), woven) << name;
    for (const char* name : {"k_warp.b", "k_poisson.a", "bend_weft.b"}) {
      EXPECT_EQ(gradient.HasInfluence(name), woven) << name;
    }
    ExpectAgreement(gradient, 1e-6);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Scenes, PiecesGradientTest,
    ::testing::ValuesIn(WithIntegrators({{"drape", ContactMode::kGap}, {"wind", ContactMode::kGap}})), CaseName);

// With bending about a curved rest shape, of one constant and of three.
class CurvedGradientTest : public GradientTest {};

TEST_P(CurvedGradientTest, AdjointEqualsSensitivityEqualsDifferences) {
  for (const bool woven : {false, true}) {
    Scene scene = SceneOf(GetParam(), 7);
    scene.duration *= 0.2;
    const GradientCase gradient(CurvedAtRest(woven ? Woven(scene) : scene));
    EXPECT_TRUE(gradient.HasInfluence(woven ? "bend_twist" : "k_bend"));
    ExpectAgreement(gradient, 1e-6);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Scenes, CurvedGradientTest,
    ::testing::ValuesIn(WithIntegrators({{"drape", ContactMode::kGap}, {"wind", ContactMode::kGap}})), CaseName);

// A cloth that falls on a ball, a bar and a table, each with a friction of its own.
Scene ThreeObstacles() {
  Scene scene = ShippedScene("drape", 9);
  scene.handles = {};
  scene.duration = 0.4;
  scene.mesh.rest_positions.row(2).setZero();
  scene.initial_positions = scene.mesh.rest_positions.reshaped();
  scene.obstacles.clear();
  scene.obstacles.push_back({"ball", std::make_shared<Sphere>(Eigen::Vector3d(-0.12, 0.12, -0.1), 0.09), 0.2, 0.002});
  scene.obstacles.push_back(
      {"bar", std::make_shared<Capsule>(Eigen::Vector3d(0.05, 0.3, -0.12), Eigen::Vector3d(0.3, 0.4, -0.1), 0.06), 0.5,
       0.0});
  scene.obstacles.push_back({"table",
                             std::make_shared<Plane>(Eigen::Vector3d(0.0, 0.0, -0.25), Eigen::Vector3d(0.05, 0.0, 1.0)),
                             0.1, 0.001});
  return scene;
}

TEST(GradientOfSeveralObstaclesTest, EachFrictionCoefficientHasItsOwnDerivative) {
  const GradientCase gradient(ThreeObstacles());
  for (int i = 1; i <= 3; ++i) EXPECT_TRUE(gradient.has_influence(i)) << gradient.name(i);
  EXPECT_NEAR(gradient.adjoint(0), gradient.adjoint(1) + gradient.adjoint(2) + gradient.adjoint(3),
              1e-10 * std::abs(gradient.adjoint(0)));
  ExpectAgreement(gradient, 1e-5);
}

// `drape` on a tilted cube, whose edges and vertices the contact distance rounds off: nodes slide over them without a
// jump of their normals.
Scene OnCube(ContactMode mode, Integrator integrator) {
  Scene scene = ShippedScene("drape", integrator == Integrator::kEuler ? 12 : 11);
  scene.contact_mode = mode;
  scene.integrator = integrator;
  TriangleMesh cube = CubeMesh(0.14);
  cube.vertices =
      Eigen::AngleAxisd(0.4, Eigen::Vector3d(0.6, 0.8, 0.1).normalized()).toRotationMatrix() * cube.vertices;
  cube.vertices.colwise() += Eigen::Vector3d(0.03, 0.25, -0.35);
  SceneObstacle& obstacle = scene.obstacles[0];
  obstacle.shape = std::make_shared<TriangulatedSurface>(cube.vertices, cube.faces);
  obstacle.contact_distance = 0.02;
  return scene;
}

class GradientOnTrianglesTest : public ::testing::TestWithParam<std::tuple<ContactMode, Integrator>> {};

TEST_P(GradientOnTrianglesTest, AdjointEqualsSensitivityEqualsDifferences) {
  const Scene scene = OnCube(std::get<0>(GetParam()), std::get<1>(GetParam()));
  const GradientCase gradient(scene);
  const Rollout& rollout = gradient.rollout();
  int on_faces = 0, off_faces = 0;
  for (int step = 1; step < rollout.num_steps(); ++step) {
    for (const ContactRecord& contact : rollout.records[rollout.last_record[step]].contacts.nodes) {
      const Eigen::Vector3d start = rollout.positions(step).segment<3>(3 * contact.node);
      const bool is_flat = scene.obstacles[0].shape->Closest(start).normal_gradient.isZero(0.0);
      ++(is_flat ? on_faces : off_faces);
    }
  }
  EXPECT_GT(on_faces, 100);
  EXPECT_GT(off_faces, 100);
  EXPECT_TRUE(gradient.HasInfluence("mu"));
  ExpectAgreement(gradient, 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Modes, GradientOnTrianglesTest,
                         ::testing::Values(std::tuple(ContactMode::kGap, Integrator::kEuler),
                                           std::tuple(ContactMode::kVelocity, Integrator::kEuler),
                                           std::tuple(ContactMode::kGap, Integrator::kSdirk2)),
                         [](const auto& test) {
                           const bool gap = std::get<0>(test.param) == ContactMode::kGap;
                           return std::string(gap ? "Gap" : "Velocity") +
                                  (std::get<1>(test.param) == Integrator::kEuler ? "" : "Sdirk2");
                         });

class GradientOfSubstepsTest : public ::testing::TestWithParam<Integrator> {};

TEST_P(GradientOfSubstepsTest, SubstepsAreDifferentiatedThrough) {
  Scene scene = ShippedScene("drape", 6);
  scene.integrator = GetParam();
  scene.solver.max_newton_iterations = 3;  // too few for some steps, which are then cut
  const GradientCase gradient(scene);
  ASSERT_GT(gradient.num_substeps(), 0);
  for (int i = 0; i < gradient.num_directions(); ++i) {
    if (!gradient.has_influence(i)) continue;
    EXPECT_NEAR(gradient.adjoint(i), gradient.sensitivity(i), 1e-10 * std::abs(gradient.adjoint(i)))
        << gradient.name(i);
  }
}

// The strain rate of a substep is over its own length and from its own start.
TEST_P(GradientOfSubstepsTest, SubstepsWithInternalDampingToo) {
  Scene scene = Damped(ShippedScene("drape", 6));
  scene.integrator = GetParam();
  scene.duration = 0.2;
  scene.solver.max_newton_iterations = 3;
  const GradientCase gradient(scene);
  ASSERT_GT(gradient.num_substeps(), 0);
  ExpectAgreement(gradient, 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Integrators, GradientOfSubstepsTest,
                         ::testing::Values(Integrator::kEuler, Integrator::kSdirk2),
                         [](const auto& test) { return std::string(IntegratorName(test.param)); });

TEST(GradientByLuTest, ReducedAndLuAgree) {
  const Scene scene = ShippedScene("drape", 8);
  const GradientCase reduced(scene), lu(scene, AdjointMethod::kLu);
  for (int i = 0; i < reduced.num_directions(); ++i) {
    EXPECT_NEAR(reduced.adjoint(i), lu.adjoint(i), 1e-10 * std::abs(lu.adjoint(i))) << reduced.name(i);
  }
}

}  // namespace
}  // namespace clothid::gradient_test
