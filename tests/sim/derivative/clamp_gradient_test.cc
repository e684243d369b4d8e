// adjoint = sensitivity = central finite differences of a cloth in a jaw that turns, and what it turns the jaw by.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "sim/cloth/cloth_model.h"
#include "tests/sim/clamped_strip.h"
#include "tests/sim/curved_rest.h"
#include "tests/sim/derivative/gradient_case.h"
#include "tests/sim/pieces_scene.h"
#include "tests/sim/shipped_scenes.h"
#include "tests/sim/woven_scene.h"

namespace clothid::clamp_gradient_test {
namespace {

enum class Cloth { kEdges, kPatches, kWoven, kCurved, kPieces };

using Case = std::pair<Cloth, Integrator>;

Scene ClampedScene(Cloth cloth, Integrator integrator) {
  Scene scene = ShippedScene("drape", 7, integrator);
  scene.parameters["k_bend"].nominal = 1e-3;
  scene.material.bending_stiffness = 1e-3;
  scene.material.damping = 0.02;
  scene.duration = 0.3;
  if (cloth == Cloth::kPatches) scene.bending = {BendingLaw::kPatches, 0.3};
  if (cloth == Cloth::kWoven) scene = Woven(std::move(scene));
  if (cloth == Cloth::kCurved) scene = CurvedAtRest(std::move(scene));
  if (cloth == Cloth::kPieces) scene = InPieces(std::move(scene), 0.5, 3.0);
  return InATurningJaw(std::move(scene));
}

class ClampGradientTest : public ::testing::TestWithParam<Case> {
 protected:
  ClampGradientTest() : scene_(ClampedScene(GetParam().first, GetParam().second)) {}
  const Scene scene_;
};

TEST_P(ClampGradientTest, AdjointEqualsSensitivityEqualsDifferences) {
  const GradientCase gradient(scene_);
  const Cloth cloth = GetParam().first;
  const char* const bending = cloth == Cloth::kWoven ? "bend_warp" : cloth == Cloth::kPieces ? "k_bend.a" : "k_bend";
  for (const char* name : {bending, "density", "x_0"}) EXPECT_TRUE(gradient.HasInfluence(name)) << name;
  ExpectAgreement(gradient, 1e-6);
}

// Forces upon nodes and upon slopes are the derivatives of the energy by them.
TEST_P(ClampGradientTest, ForcesAreDerivativesOfTheEnergy) {
  Scene scene = scene_;
  std::mt19937_64 generator(3);
  std::normal_distribution<double> normal;
  const auto noise = [&](Eigen::Index size) {
    return Eigen::VectorXd::NullaryExpr(size, [&] { return normal(generator); }).eval();
  };
  const Eigen::VectorXd x = scene.initial_positions + 0.01 * noise(scene.initial_positions.size());
  const Eigen::VectorXd slopes = scene.handles.slopes.At(0.1);
  const Eigen::VectorXd dx = noise(x.size()), dd = noise(slopes.size());
  const Parameters parameters = scene.nominal_parameters();
  Eigen::VectorXd force, upon_slopes;
  const auto energy = [&](const Eigen::VectorXd& positions, const Eigen::VectorXd& directions) {
    scene.handles.slopes = HandlePath(Eigen::VectorXd::Zero(1), directions);
    const ClothModel model(scene);
    force = Eigen::VectorXd::Zero(x.size());
    upon_slopes = Eigen::VectorXd::Zero(slopes.size());
    double sum = 0.0;
    for (const auto& term : model.forces().terms()) {
      if (term->group() != ForceGroup::kElastic || term->energy_share() != EnergyShare::kBending) continue;
      const ForcePoint point{parameters, 0.0, 0.0, positions, positions};
      sum += term->AddForce(point, nullptr, &force);
      term->AddSlopeForce(point, &upon_slopes);
    }
    return sum;
  };
  constexpr double kStep = 1e-6;
  const double by_nodes = (energy(x + kStep * dx, slopes) - energy(x - kStep * dx, slopes)) / (2.0 * kStep);
  const double by_slopes = (energy(x, slopes + kStep * dd) - energy(x, slopes - kStep * dd)) / (2.0 * kStep);
  energy(x, slopes);
  EXPECT_NEAR(-force.dot(dx), by_nodes, 1e-6 * std::abs(by_nodes));
  EXPECT_NEAR(-upon_slopes.dot(dd), by_slopes, 1e-6 * std::abs(by_slopes));
}

std::string CaseName(const ::testing::TestParamInfo<Case>& info) {
  const std::vector<const char*> names = {"Edges", "Patches", "Woven", "Curved", "Pieces"};
  return names[static_cast<std::size_t>(info.param.first)];
}

INSTANTIATE_TEST_SUITE_P(Cloths, ClampGradientTest,
                         ::testing::Values(Case{Cloth::kEdges, Integrator::kEuler},
                                           Case{Cloth::kPatches, Integrator::kSdirk2},
                                           Case{Cloth::kWoven, Integrator::kSdirk2},
                                           Case{Cloth::kCurved, Integrator::kEuler},
                                           Case{Cloth::kPieces, Integrator::kEuler}),
                         CaseName);

}  // namespace
}  // namespace clothid::clamp_gradient_test
