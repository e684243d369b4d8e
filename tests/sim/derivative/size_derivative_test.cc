// Derivatives by the size of the cloth at rest: adjoint = sensitivity = central differences, in every term that a scene
// can have; and what a size does to a rollout.
#include "sim/derivative/size_derivative.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "sim/base/error.h"
#include "sim/derivative/adjoint.h"
#include "sim/derivative/sensitivity.h"
#include "sim/rollout/rollout.h"
#include "sim/rollout/simulator.h"
#include "tests/expect_error.h"
#include "tests/sim/clamped_strip.h"
#include "tests/sim/curved_rest.h"
#include "tests/sim/derivative/same_branches.h"
#include "tests/sim/scene/triangle_meshes.h"
#include "tests/sim/sheet_meshes.h"
#include "tests/sim/shipped_scenes.h"
#include "tests/sim/woven_scene.h"

namespace clothid::size_derivative_test {
namespace {

const std::vector<ParameterId> kSizes = {{ParameterKind::kSize, 0}, {ParameterKind::kSize, 1}};

// A scalar of the trajectory, L = 1/2 sum over steps of |x - target|^2.
double Cost(const Rollout& rollout, const Eigen::VectorXd& target) {
  double cost = 0.0;
  for (int step = 0; step <= rollout.num_steps(); ++step) {
    cost += 0.5 * (rollout.positions(step) - target).squaredNorm();
  }
  return cost;
}

void ExpectAgreement(Scene scene, const char* name, bool touches = false) {
  scene.solver.step_tolerance = 1e-11;
  scene.parameters["size.x"].nominal = 1.015;
  scene.parameters["size.y"].nominal = 1.02;
  Simulator simulator(scene);
  const Parameters parameters = scene.nominal_parameters();
  const Rollout rollout = Simulate(parameters, scene.num_steps(), &simulator);
  ASSERT_TRUE(rollout.ok()) << name << ": " << rollout.failure->ToString();
  EXPECT_EQ(rollout.counts.contacts > 100, touches) << name;
  const Eigen::VectorXd target = 0.95 * rollout.initial_positions.array() + 0.02;
  const auto seed = [&](int step, Eigen::MatrixXd* gradient) { gradient->col(0) += rollout.positions(step) - target; };
  const Eigen::VectorXd adjoint = PullBack(rollout, kSizes, 1, seed, &simulator).parameters.col(0);
  Eigen::Vector2d sensitivity = Eigen::Vector2d::Zero();
  PushForward(
      parameters, scene.num_steps(), {kSizes, {}, {}, {}},
      [&](int, const Eigen::VectorXd& x, const Eigen::MatrixXd& dx) { sensitivity += dx.transpose() * (x - target); },
      &simulator);
  for (int i = 0; i < 2; ++i) {
    EXPECT_GT(std::abs(adjoint[i]), 1e-3 * Cost(rollout, target)) << name << " " << i;
    EXPECT_NEAR(adjoint[i], sensitivity[i], 1e-10 * std::abs(adjoint[i])) << name << " " << i;
    double error = 1.0;
    for (const double step : {1e-5, 1e-6, 1e-4, 3e-7}) {
      Parameters above = parameters, below = parameters;
      above.size[i] += step;
      below.size[i] -= step;
      const Rollout plus = Simulate(above, scene.num_steps(), &simulator);
      const Rollout minus = Simulate(below, scene.num_steps(), &simulator);
      if (!HaveSameBranches(rollout, plus) || !HaveSameBranches(rollout, minus)) continue;
      const double difference = (Cost(plus, target) - Cost(minus, target)) / (2.0 * step);
      error = std::min(error, std::abs(difference - adjoint[i]) / std::abs(adjoint[i]));
      if (error < 1e-7) break;
    }
    EXPECT_LE(error, 1e-6) << name << " " << i;
  }
}

// Warp and weft at an angle to the mesh, in membrane and bending; internal damping; drag by direction.
Scene WithEveryTerm(Scene flat) {
  Scene scene = Woven(std::move(flat));
  Material& material = scene.material;
  material.damping = 0.01 * material.warp_stiffness;
  material.normal_drag = 0.3;
  material.tangential_drag = 0.1;
  material.added_mass = 0.02;
  scene.wind.mean = {0.3, 1.0, -0.2};
  scene.wind.gust = {0.0, 0.5, 0.2};
  scene.wind.frequency = 10.0;
  scene.wind.wave_vector = {4.0, 0.0, 2.0};
  return scene;
}

TEST(SizeDerivativeTest, AdjointIsSensitivityIsCentralDifferencesInContact) {
  for (const Integrator integrator : {Integrator::kEuler, Integrator::kSdirk2}) {
    for (const ContactMode mode : {ContactMode::kGap, ContactMode::kVelocity}) {
      Scene scene = WithEveryTerm(ShippedScene("drape", 7, integrator));
      scene.contact_mode = mode;
      scene.duration *= 0.4;
      ExpectAgreement(scene, IntegratorName(integrator), /*touches=*/true);
    }
  }
}

TEST(SizeDerivativeTest, AdjointIsSensitivityIsCentralDifferencesWithDragAndBendingOfAnyForm) {
  Scene scene = ShippedScene("wind", 7, Integrator::kSdirk2);
  scene.duration *= 0.3;
  ExpectAgreement(scene, "edges");
  scene.bending = {BendingLaw::kPatches, 0.3};
  scene.fields = {{ParameterKind::kStretchStiffness, Eigen::MatrixXd{{60.0, 90.0}, {110.0, 80.0}}},
                  {ParameterKind::kDensity, Eigen::MatrixXd{{0.1, 0.2}}}};
  ExpectAgreement(scene, "fields");
  scene.fields.clear();
  ExpectAgreement(CurvedAtRest(scene), "curved at rest");
}

TEST(SizeDerivativeTest, AdjointIsSensitivityIsCentralDifferencesOfAClampedCloth) {
  Scene scene = ShippedScene("drape", 7, Integrator::kSdirk2);
  scene.parameters["k_bend"].nominal = 1e-3;
  scene.duration *= 0.25;
  scene.bending = {BendingLaw::kPatches, 0.3};
  ExpectAgreement(InATurningJaw(scene), "along the edges");
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  scene.mesh.rest_positions = (turn * scene.mesh.rest_positions).eval();
  scene.initial_positions = scene.mesh.rest_positions.reshaped();
  ExpectAgreement(InATurningJaw(scene), "at an angle");
}

TEST(SizeDerivativeTest, IsBuiltForSizesAlone) {
  const Scene scene = ShippedScene("wind", 5);
  const Parameters parameters = scene.nominal_parameters();
  const Simulator simulator(scene);
  EXPECT_EQ(SizeDerivative(parameters, {{ParameterKind::kStretchStiffness}}, simulator).num_models(), 0);
  const SizeDerivative one(parameters, {{ParameterKind::kSize, 1}, {ParameterKind::kDensity}}, simulator);
  EXPECT_EQ(one.num_models(), 4);
  EXPECT_THROW(one.MassSlopes({ParameterKind::kSize, 0}), std::logic_error);
}

// The grid has the axes x and z.
TEST(SizedSceneTest, IsTheSceneOfAnotherMesh) {
  for (const Integrator integrator : {Integrator::kEuler, Integrator::kSdirk2}) {
    Scene scene = WithEveryTerm(ShippedScene("wind", 6, integrator));
    scene.duration = 0.2;
    scene.wind.wave_vector.setZero();  // the one mesh is stretched about its middle, the other one from a corner
    Scene other = scene;
    other.mesh.rest_positions = Eigen::Vector3d(1.1, 1.0, 0.9).asDiagonal() * scene.mesh.rest_positions;
    Parameters parameters = scene.nominal_parameters();
    Simulator simulator(scene), other_simulator(other);
    const Rollout first = Simulate(parameters, scene.num_steps(), &simulator);
    EXPECT_EQ(&simulator.model().scene(), &simulator.scene());  // nothing is built
    const Rollout expected = Simulate(parameters, scene.num_steps(), &other_simulator);
    parameters.size = {1.1, 0.9};
    const Rollout rollout = Simulate(parameters, scene.num_steps(), &simulator);
    ASSERT_TRUE(rollout.ok() && expected.ok());
    EXPECT_EQ(rollout.initial_positions, scene.initial_positions);
    EXPECT_LT((rollout.positions(scene.num_steps()) - expected.positions(scene.num_steps())).norm(), 1e-7);
    EXPECT_GT((rollout.positions(scene.num_steps()) - first.positions(scene.num_steps())).norm(), 1e-3);
    const Rollout again = Simulate(scene.nominal_parameters(), scene.num_steps(), &simulator);
    EXPECT_EQ(again.positions(scene.num_steps()), first.positions(scene.num_steps()));
    EXPECT_EQ(&simulator.model().scene(), &simulator.scene());
  }
}

// Whatever cancels in bending of one size, on any mesh, is no fault in another.
TEST(SizedSceneTest, HasAModelOnEveryMeshWithEveryLaw) {
  for (const SheetKind kind : kSheetKinds) {
    for (const Bending& bending : {Bending{BendingLaw::kEdges}, Bending{BendingLaw::kPatches, 0.3},
                                   Bending{BendingLaw::kPatches, 0.0}, Bending{BendingLaw::kPatches, 0.2, true}}) {
      Scene scene = ShippedScene("wind", 5);
      GridOptions grid;
      grid.nodes = {7, 7};  // of squares
      scene.mesh = MakeSheet(kind, grid);
      scene.initial_positions = scene.mesh.rest_positions.reshaped();
      scene.initial_velocities = Eigen::VectorXd::Zero(scene.initial_positions.size());
      scene.bending = bending;
      scene.duration = 0.15;
      if (bending.orthotropic) {
        scene.material.bending_stiffness = 0.0;
        scene.material.warp_bending = scene.material.weft_bending = scene.material.twist_bending = 1e-4;
      }
      const Parameters own = scene.nominal_parameters();
      Parameters parameters = own;
      parameters.size = {1.07, 0.95};
      Simulator simulator(scene);
      const Eigen::VectorXd first = Simulate(own, 3, &simulator).positions(3);
      const std::string name = SheetName(kind) + (bending.orthotropic ? " orthotropic" : "");
      EXPECT_NO_THROW(EXPECT_TRUE(Simulate(parameters, 3, &simulator).ok())) << name;
      EXPECT_EQ(Simulate(own, 3, &simulator).positions(3), first) << name;
      if (kind == SheetKind::kIrregular) ExpectAgreement(scene, name.c_str());
    }
  }
}

TEST(SizedSceneTest, WantsAFactorAndAFront) {
  Scene scene = ShippedScene("wind", 5);
  scene.parameters["size.x"].nominal = 0.0;
  ExpectError([&] { ValidateScene(scene, "scene"); }, ErrorKind::kBadData, {"size.x", "0.1 to 10"});
  scene.parameters["size.x"].nominal = -1.0;
  ExpectError([&] { ValidateScene(scene, "scene"); }, ErrorKind::kBadData, {"size.x"});
  const TriangleMesh cube = CubeMesh(0.1);
  scene.mesh = {cube.vertices, cube.faces};
  scene.handles = {};
  scene.initial_positions = cube.vertices.reshaped();
  scene.initial_velocities = Eigen::VectorXd::Zero(scene.initial_positions.size());
  scene.parameters["size.x"].nominal = 1.1;
  ExpectError([&] { ValidateScene(scene, "scene"); }, ErrorKind::kBadData, {"scene", "front"});
}

}  // namespace
}  // namespace clothid::size_derivative_test
