// One row of nodes clamps a cloth: against the theory of thin plates, the balance of moments, and under rotations.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <vector>

#include "sim/rollout/handle_forces.h"
#include "tests/sim/clamped_strip.h"
#include "tests/sim/heavy_elastica.h"
#include "tests/sim/moving_paths.h"

namespace clothid::clamp_test {
namespace {

constexpr int kSteps = 30;  // of .3 s, after which it has come to rest

class ClampTest : public ::testing::TestWithParam<SheetKind> {};

// By how much the rigidity of the elastica is another whose tip sinks as far as that of a strip.
double RigidityError(const ClampedStrip& strip, double load) {
  const Rollout rollout = SimulateNominal(strip.scene, kSteps);
  const double sunk = -strip.Tip(rollout.positions(kSteps)).z();
  const auto expected = [&](double at) { return HeavyElastica(at, ClampedStrip::kLength).tip().y(); };
  return (sunk - expected(load)) / ((expected(1.01 * load) - expected(load)) / 0.01);
}

TEST_P(ClampTest, OneRowSagsAsTheElastica) {
  const double load = 4.0;  // by 43 % of the length
  std::vector<double> errors;
  for (const int cells : {12, 24, 48}) errors.push_back(RigidityError(ClampedStrip(GetParam(), cells, load), load));
  EXPECT_LE(std::abs(errors[0]), 0.01);
  EXPECT_LE(std::abs(errors[1]), 0.003);
  EXPECT_LE(std::abs(errors[2]), 0.0008);
  // Of second order; of an irregular mesh, which is another each time, roughly.
  if (GetParam() != SheetKind::kIrregular) {
    EXPECT_NEAR(errors[0] / errors[1], 4.0, 0.3);
    EXPECT_NEAR(errors[1] / errors[2], 4.0, 0.3);
  }
}

// The lowest mode of a clamped plate that bends one way, omega = 1.8751^2 sqrt(D/(rho L^4)), 1/s.
TEST_P(ClampTest, OneRowVibratesAsAPlate) {
  constexpr double kRoot = 1.875104068711961;  // of cos b cosh b = -1
  ClampedStrip strip(GetParam(), 24, 0.0);
  Scene& scene = strip.scene;
  const double period =
      2.0 * kPi / (kRoot * kRoot) *
      std::sqrt(ClampedStrip::kDensity * std::pow(ClampedStrip::kLength, 4) / ClampedStrip::kRigidity);
  scene.time_step = period / 100;
  scene.integrator = Integrator::kSdirk2;
  const double ratio = (std::cosh(kRoot) + std::cos(kRoot)) / (std::sinh(kRoot) + std::sin(kRoot));
  for (int node = 0; node < scene.mesh.num_nodes(); ++node) {
    const double b = kRoot * scene.mesh.rest_positions(0, node) / ClampedStrip::kLength;
    const double shape = std::cosh(b) - std::cos(b) - ratio * (std::sinh(b) - std::sin(b));
    scene.initial_positions[3 * node + 2] = 1e-4 * ClampedStrip::kLength * shape;
  }
  const Rollout rollout = SimulateNominal(scene, 100);
  std::vector<double> crossings;  // of the tip through the plane, in steps
  for (int step = 1; step <= 100; ++step) {
    const double before = strip.Tip(rollout.positions(step - 1)).z(), after = strip.Tip(rollout.positions(step)).z();
    if (before * after < 0.0) crossings.push_back(step - 1 + before / (before - after));
  }
  ASSERT_EQ(crossings.size(), 2u);
  EXPECT_NEAR(2.0 * (crossings[1] - crossings[0]), 100.0, 0.3);
}

// Rows behind the last one change nothing, whatever the mesh has between them.
TEST_P(ClampTest, SeveralRowsClampAtTheLast) {
  for (const BendingLaw law : {BendingLaw::kPatches, BendingLaw::kEdges}) {
    if (law == BendingLaw::kEdges && GetParam() == SheetKind::kIrregular) continue;  // k_bend is that of the mesh
    ClampedStrip one(GetParam(), 12, 4.0, 1), three(GetParam(), 12, 4.0, 3);
    one.scene.bending.law = three.scene.bending.law = law;
    EXPECT_NEAR(RigidityError(three, 4.0), RigidityError(one, 4.0), 0.01);
  }
}

// Not the equilateral one, whose ends are zigzag.
INSTANTIATE_TEST_SUITE_P(Kinds, ClampTest,
                         ::testing::Values(SheetKind::kRightAngled, SheetKind::kAlternating, SheetKind::kIrregular),
                         [](const auto& test) { return SheetName(test.param); });

// Forces and moments at a group of handles at the end.
struct Held {
  Eigen::Vector3d force, moment;
};
Held LoadsAtEnd(const Scene& scene, const Rollout& rollout) {
  Simulator simulator(scene);
  const HandleForces forces(simulator.model(), rollout.parameters, rollout.num_steps(), {scene.handles.nodes});
  Eigen::MatrixXd states(3 * static_cast<Eigen::Index>(forces.nodes().size()), rollout.num_steps() + 1);
  for (int step = 0; step <= rollout.num_steps(); ++step) states.col(step) = forces.Gather(rollout.positions(step));
  return {forces.Over(states).col(rollout.num_steps()), forces.MomentsOver(states).col(rollout.num_steps())};
}

TEST(ClampLoadsTest, MomentIsWeightTimesArm) {
  for (const BendingLaw law : {BendingLaw::kPatches, BendingLaw::kEdges}) {
    ClampedStrip strip(SheetKind::kAlternating, 12, 4.0);
    strip.scene.bending.law = law;
    const Rollout rollout = SimulateNominal(strip.scene, kSteps);
    const Eigen::VectorXd& positions = rollout.positions(kSteps);
    Eigen::Vector3d middle = Eigen::Vector3d::Zero(), moment = middle, weight = middle;
    for (const int node : strip.scene.handles.nodes) middle += positions.segment<3>(3 * node) / strip.rows;
    const Eigen::VectorXd areas = NodeAreas(strip.scene.mesh);
    for (int node = 0; node < strip.scene.mesh.num_nodes(); ++node) {
      const Eigen::Vector3d force = ClampedStrip::kDensity * areas[node] * strip.scene.gravity;
      weight += force;
      moment += (positions.segment<3>(3 * node) - middle).cross(force);
    }
    const Held held = LoadsAtEnd(strip.scene, rollout);
    EXPECT_LE((held.force + weight).norm(), 1e-6 * weight.norm());
    EXPECT_LE((held.moment + moment).norm(), 1e-6 * moment.norm());
    EXPECT_GE(moment.norm(), 0.3 * weight.norm() * ClampedStrip::kLength);
  }
}

// A cloth that a jaw takes along is at rest relative to it, once shaking is over, and the load turns with it.
TEST(ClampLoadsTest, TurnsWithTheJaw) {
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.7, Eigen::Vector3d(0.3, -0.5, 0.8).normalized()).toRotationMatrix();
  for (const BendingLaw law : {BendingLaw::kPatches, BendingLaw::kEdges}) {
    ClampedStrip still(SheetKind::kAlternating, 8, 4.0), turned = still;
    still.scene.bending.law = turned.scene.bending.law = law;
    turned.scene.mesh.rest_positions = turn * still.scene.mesh.rest_positions;
    turned.scene.initial_positions = turned.scene.mesh.rest_positions.reshaped();
    turned.scene.gravity = turn * still.scene.gravity;
    ClampHandles({{turned.scene.handles.nodes}}, &turned.scene);
    const Rollout one = SimulateNominal(still.scene, 5), other = SimulateNominal(turned.scene, 5);
    const Eigen::Matrix3Xd expected = turn * one.positions(5).reshaped(3, still.scene.mesh.num_nodes());
    EXPECT_LE((other.positions(5) - expected.reshaped()).norm(), 1e-9 * expected.norm());
    const Held before = LoadsAtEnd(still.scene, one), after = LoadsAtEnd(turned.scene, other);
    EXPECT_LE((after.moment - turn * before.moment).norm(), 1e-7 * before.moment.norm());
  }
}

TEST(ClampHandlesTest, SlopesFollowTheJaw) {
  ClampedStrip strip(SheetKind::kRightAngled, 6, 0.0);
  Scene& scene = strip.scene;
  scene.time_step = 0.01;
  scene.duration = 0.5;
  const auto body = PathThrough(
      0.0, 0.5, 51, [](double t) { return Eigen::Vector3d(0.0, 0.2 * t, 0.1 * t); },
      [](double t) { return Eigen::Vector3d(0.4 * t, 2.0 * t, -0.3 * t); });
  scene.handles.path = AttachedPath(scene, scene.handles.nodes, *body);
  ClampHandles({{scene.handles.nodes, std::nullopt, body}}, &scene);
  const Eigen::Matrix3d turn = body->At(0.3).pose.leftCols<3>() * body->At(0.0).pose.leftCols<3>().transpose();
  const Eigen::VectorXd slopes = scene.handles.slopes.At(0.3);
  ASSERT_EQ(slopes.size(), 3 * (strip.rows - 1));
  for (int i = 0; i < strip.rows - 1; ++i) {
    EXPECT_LE((slopes.segment<3>(3 * i) - turn * Eigen::Vector3d::UnitX()).norm(), 1e-12);
  }
  // Of a part of the motion they are the same.
  Scene part = scene;
  part.start_time = 0.2;
  part.duration = 0.3;
  part.handles.path = scene.handles.path;
  ClampHandles({{part.handles.nodes, std::nullopt, body}}, &part);
  EXPECT_LE((part.handles.slopes.At(0.3) - slopes).norm(), 1e-12);
  // By the motion of the row alone, which does not see turns about itself.
  ClampHandles({{scene.handles.nodes}}, &scene);
  const Eigen::Vector3d row = turn * Eigen::Vector3d::UnitY();
  for (const double time : {0.0, 0.123, 0.3}) {
    EXPECT_NEAR(scene.handles.slopes.At(time).head<3>().norm(), 1.0, 1e-6);
  }
  EXPECT_NEAR(scene.handles.slopes.At(0.3).head<3>().dot(row), 0.0, 1e-6);
  // Given at the start: what is along the row does not count.
  ClampHandles({{scene.handles.nodes, Eigen::Vector3d(0.0, 5.0, -2.0)}}, &scene);
  EXPECT_LE((scene.handles.slopes.At(0.0).head<3>() - Eigen::Vector3d(0.0, 0.0, -1.0)).norm(), 1e-12);
}

// What four rows of nodes once did: the tip of a strip whose jaw is turned to the vertical hangs straight down.
TEST(ClampHandlesTest, HangsStraightFromAJawThatPointsDown) {
  ClampedStrip strip(SheetKind::kAlternating, 12, 4.0);
  ClampHandles({{strip.scene.handles.nodes, Eigen::Vector3d(0.0, 0.0, -1.0)}}, &strip.scene);
  strip.scene.integrator = Integrator::kEuler;
  const Rollout rollout = SimulateNominal(strip.scene, 2 * kSteps);
  const Eigen::Vector3d tip = strip.Tip(rollout.positions(2 * kSteps));
  EXPECT_NEAR(tip.x(), 0.0, 1e-6);
  EXPECT_NEAR(tip.z(), -ClampedStrip::kLength, 2e-3 * ClampedStrip::kLength);
}

}  // namespace
}  // namespace clothid::clamp_test
