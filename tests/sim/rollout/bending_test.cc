// Bending by patches in rollouts, against the theory of thin plates: a heavy strip and a vibrating one, clamped at one
// end, 20.5 elements long.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "tests/sim/heavy_elastica.h"
#include "tests/sim/plain_scenes.h"
#include "tests/sim/sheet_meshes.h"

namespace clothid::bending_test {
namespace {

constexpr double kLength = 0.1;     // m, from the clamp
constexpr double kRigidity = 1e-4;  // N m
constexpr int kHeld = 4;            // columns; fewer would leave the clamp to the fits at the border of the mesh
constexpr int kColumns = 20 + kHeld, kRows = 5;
constexpr double kSpacing = kLength / 20.5;

// The strip along x in the xy plane. Its first columns are held, which clamps it in the middle between the last two.
Scene ClampedStrip(SheetKind kind) {
  GridOptions grid;
  grid.nodes = {kColumns, kRows};
  grid.size = {(kColumns - 1) * kSpacing, (kRows - 1) * kSpacing};
  grid.origin = {-(kHeld - 1.5) * kSpacing, 0.0, 0.0};
  Scene scene = ClothScene(grid, 1.0);
  scene.mesh = MakeSheet(kind, grid, kHeld);
  scene.initial_positions = scene.mesh.rest_positions.reshaped();
  scene.material.density = 0.2;
  scene.material.stretch_stiffness = 1000.0;
  scene.material.bending_stiffness = kRigidity;
  scene.bending.law = BendingLaw::kPatches;
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kHeld; ++column) scene.handles.nodes.push_back(row * kColumns + column);
  }
  scene.solver.step_tolerance = 1e-10;
  return scene;
}

// The mean of the last column.
Eigen::Vector3d Tip(const Eigen::VectorXd& positions) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int row = 0; row < kRows; ++row) sum += positions.segment<3>(3 * (row * kColumns + kColumns - 1));
  return sum / kRows;
}

class ClampedStripTest : public ::testing::TestWithParam<SheetKind> {};

TEST_P(ClampedStripTest, SagsAsTheElastica) {
  for (const double load : {1.0, 4.0, 12.0}) {  // rho g L^3/D; the tip sinks by 12, 43 and 74 % of the length
    Scene scene = ClampedStrip(GetParam());
    scene.time_step = 0.3;
    scene.gravity = {0.0, 0.0, -load * kRigidity / (scene.material.density * std::pow(kLength, 3))};
    const Rollout rollout = SimulateNominal(scene, 30);
    const Eigen::Vector3d tip = Tip(rollout.positions(30));
    ASSERT_LT((tip - Tip(rollout.positions(29))).norm(), 1e-5 * kLength);  // it has come to rest
    const Eigen::Vector2d expected = HeavyElastica(load, kLength).tip();
    EXPECT_NEAR(-tip.z(), expected.y(), 0.01 * expected.y()) << "load " << load;
    EXPECT_NEAR(tip.x(), expected.x(), 0.01 * expected.x()) << "load " << load;
  }
}

// The lowest mode of a clamped plate that bends one way, omega = 1.8751^2 sqrt(D/(rho L^4)), 1/s.
TEST_P(ClampedStripTest, VibratesAsAPlate) {
  constexpr double kRoot = 1.875104068711961;  // of cos b cosh b = -1
  Scene scene = ClampedStrip(GetParam());
  const double omega = kRoot * kRoot * std::sqrt(kRigidity / (scene.material.density * std::pow(kLength, 4)));
  const double period = 2.0 * kPi / omega;
  constexpr int kSteps = 200;  // per period: backward Euler is slower by 0.03 %
  scene.time_step = period / kSteps;
  scene.gravity.setZero();
  const double ratio = (std::cosh(kRoot) + std::cos(kRoot)) / (std::sinh(kRoot) + std::sin(kRoot));
  for (int node = 0; node < scene.mesh.num_nodes(); ++node) {
    const double b = kRoot * std::max(0.0, scene.mesh.rest_positions(0, node)) / kLength;
    const double shape = std::cosh(b) - std::cos(b) - ratio * (std::sinh(b) - std::sin(b));
    if (node % kColumns >= kHeld) scene.initial_positions[3 * node + 2] = 1e-4 * kLength * shape;
  }
  const Rollout rollout = SimulateNominal(scene, kSteps);
  std::vector<double> crossings;  // of the tip through the plane, s
  for (int step = 1; step <= kSteps; ++step) {
    const double before = Tip(rollout.positions(step - 1)).z(), after = Tip(rollout.positions(step)).z();
    if (before * after < 0.0) crossings.push_back((step - 1 + before / (before - after)) * scene.time_step);
  }
  ASSERT_EQ(crossings.size(), 2u);
  EXPECT_NEAR(2.0 * (crossings[1] - crossings[0]), period, 0.01 * period);
}

// Not the equilateral one, whose ends are zigzag.
INSTANTIATE_TEST_SUITE_P(Kinds, ClampedStripTest,
                         ::testing::Values(SheetKind::kRightAngled, SheetKind::kAlternating, SheetKind::kIrregular),
                         [](const auto& test) { return SheetName(test.param); });

}  // namespace
}  // namespace clothid::bending_test
