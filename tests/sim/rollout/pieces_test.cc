// Rollouts of a cloth of pieces, against one of a single piece and closed forms; forces at its handles.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "sim/cloth/cloth_model.h"
#include "sim/rollout/handle_forces.h"
#include "tests/sim/forces_of.h"
#include "tests/sim/pieces_scene.h"
#include "tests/sim/plain_scenes.h"
#include "tests/sim/woven_scene.h"

namespace clothid::pieces_test {
namespace {

// All terms that pieces can differ in; held by its first row.
Scene HangingCloth(Integrator integrator, bool woven) {
  GridOptions grid = SquareGrid(6, 0.3);
  grid.axes = {Eigen::Vector3d::UnitX(), Eigen::Vector3d(0.0, 0.8, -0.6)};
  Scene scene = ClothScene(grid, 0.01);
  scene.integrator = integrator;
  scene.duration = 0.2;
  for (int node = 0; node < 6; ++node) scene.handles.nodes.push_back(node);
  scene.material.bending_stiffness = 1e-3;
  scene.material.drag = 0.05;
  scene.material.damping = 0.2;
  scene.wind.mean = Eigen::Vector3d(0.3, 1.0, 0.2);
  return woven ? Woven(scene) : scene;
}

Eigen::VectorXd EndOf(const Scene& scene) {
  return SimulateNominal(scene, scene.num_steps()).positions(scene.num_steps());
}

TEST(PiecesTest, OfEqualConstantsAreOnePiece) {
  for (const Integrator integrator : {Integrator::kEuler, Integrator::kSdirk2}) {
    for (const bool woven : {false, true}) {
      const Scene scene = HangingCloth(integrator, woven);
      const Eigen::VectorXd whole = EndOf(scene);
      EXPECT_LE((EndOf(InPieces(scene, 1.0, 1.0)) - whole).norm(), 1e-12 * whole.norm()) << woven;
      EXPECT_GE((EndOf(InPieces(scene, 1.0, 1.5)) - whole).norm(), 1e-4 * whole.norm()) << woven;
    }
  }
}

// Whatever the level is, that the constants of pieces are in proportion to.
TEST(PiecesTest, DoNotDependOnTheConstantsOfTheWhole) {
  const Scene scene = InPieces(HangingCloth(Integrator::kSdirk2, false), 1.5, 0.6);
  Scene other = scene;
  for (double* level : {&other.material.density, &other.material.stretch_stiffness, &other.material.bending_stiffness,
                        &other.material.drag, &other.material.damping}) {
    *level *= 1.7;
  }
  const Eigen::VectorXd end = EndOf(scene);
  EXPECT_LE((EndOf(other) - end).norm(), 1e-12 * end.norm());
}

TEST(PiecesTest, OfParametersThatChangeAreThoseOfANewSimulator) {
  const Scene scene = InPieces(HangingCloth(Integrator::kSdirk2, false), 1.5, 0.6);
  Simulator simulator(scene);
  const Parameters first = scene.nominal_parameters();
  Parameters second = first;
  for (const ParameterKind kind : {ParameterKind::kStretchStiffness, ParameterKind::kBendingStiffness,
                                   ParameterKind::kDensity, ParameterKind::kDrag, ParameterKind::kDamping}) {
    SetParameter({kind, 0, 1}, 1.3 * GetParameter(first, {kind}), &second);
  }
  for (const Parameters& parameters : {second, first, second}) {
    Simulator fresh(scene);
    const Rollout rollout = Simulate(parameters, 5, &simulator), expected = Simulate(parameters, 5, &fresh);
    ASSERT_TRUE(rollout.ok() && expected.ok());
    EXPECT_EQ(rollout.positions(5), expected.positions(5));
  }
}

// Two strips in series, of k_a and k_b and as wide, drawn out by d: springs of k_a w/l_a and k_b w/l_b. At rest in
// drag after long steps.
TEST(PiecesTest, InSeriesStretchAsSpringsDo) {
  constexpr double kLength = 0.4, kDrawn = 0.01, kStiffA = 80.0, kStiffB = 30.0, kWidth = 0.1;
  GridOptions grid;
  grid.nodes = {9, 3};
  grid.size = {kLength, kWidth};
  Scene scene = ClothScene(grid, 5.0);
  scene.duration = 100.0;
  scene.gravity.setZero();
  scene.material.drag = 1.0;
  scene.mesh.piece_names = {"a", "b"};
  for (int f = 0; f < scene.mesh.num_faces(); ++f) {
    const bool is_left = scene.mesh.rest_positions.row(0)(scene.mesh.faces.col(f)).mean() < 0.25 * kLength;
    scene.mesh.face_pieces.push_back(is_left ? 0 : 1);
  }
  scene.pieces.assign(3, scene.material);
  scene.pieces[0].stretch_stiffness = kStiffA;
  scene.pieces[1].stretch_stiffness = kStiffB;
  for (int row = 0; row < 3; ++row) {
    scene.handles.nodes.insert(scene.handles.nodes.end(), {9 * row, 9 * row + 8});
    scene.initial_positions[3 * (9 * row + 8)] += kDrawn;
  }
  const double spring_a = kStiffA * kWidth / (0.25 * kLength), spring_b = kStiffB * kWidth / (0.75 * kLength);
  const double force = kDrawn * spring_a * spring_b / (spring_a + spring_b);

  Simulator simulator(scene);
  const Rollout rollout = Simulate(scene.nominal_parameters(), scene.num_steps(), &simulator);
  ASSERT_TRUE(rollout.ok()) << rollout.failure->ToString();
  const Eigen::VectorXd end = rollout.positions(scene.num_steps());
  for (int row = 0; row < 3; ++row) {
    const int seam = 9 * row + 2;
    EXPECT_NEAR(end[3 * seam] - 0.25 * kLength, force / spring_a, 1e-6 * force / spring_a) << row;
  }
  const HandleForces forces(simulator.model(), rollout.parameters, scene.num_steps(), {{0, 9, 18}, {8, 17, 26}});
  Eigen::MatrixXd states(3 * static_cast<Eigen::Index>(forces.nodes().size()), scene.num_steps() + 1);
  for (int step = 0; step <= scene.num_steps(); ++step) states.col(step) = forces.Gather(rollout.positions(step));
  const Eigen::VectorXd last = forces.Over(states).rightCols(1);
  EXPECT_NEAR(last[0], -force, 1e-6 * force);
  EXPECT_NEAR(last[3], force, 1e-6 * force);
}

// In any shape: the force of a cloth is the sum of those of its pieces.
TEST(PiecesTest, BendingEnergiesAddUp) {
  for (const BendingLaw law : {BendingLaw::kEdges, BendingLaw::kPatches}) {
    Scene scene = HangingCloth(Integrator::kEuler, false);
    scene.bending.law = law;
    Eigen::VectorXd positions = scene.mesh.rest_positions.reshaped();
    std::mt19937_64 generator(3);
    std::normal_distribution<double> normal(0.0, 0.01);
    for (double& x : positions) x += normal(generator);
    const auto force_of = [&](double a, double b, double rest) {
      Scene pieces = InPieces(scene, a, b);
      pieces.pieces[2].bending_stiffness = rest * scene.material.bending_stiffness;
      ClothModel model(pieces);
      model.SetVariation(pieces.nominal_parameters());
      Eigen::VectorXd force = Eigen::VectorXd::Zero(positions.size());
      for (const BendingTerm* term : BendingOf(model)) {
        AddBendingForce(*term, term->stiffness(pieces.material), positions, &force);
      }
      return force;
    };
    const Eigen::VectorXd whole = force_of(1.0, 1.0, 1.0);
    const Eigen::VectorXd sum = force_of(1.0, 0.0, 0.0) + force_of(0.0, 1.0, 0.0) + force_of(0.0, 0.0, 1.0);
    EXPECT_LE((sum - whole).norm(), 1e-12 * whole.norm());
    EXPECT_GE((force_of(2.0, 1.0, 1.0) - whole).norm(), 0.1 * whole.norm());
  }
}

TEST(PiecesTest, ForcesAtHandlesHaveTheirDerivatives) {
  for (const bool woven : {false, true}) {
    const Scene scene = InPieces(HangingCloth(Integrator::kSdirk2, woven), 1.5, 0.6);
    Simulator simulator(scene);
    const Parameters nominal = scene.nominal_parameters();
    const Rollout rollout = Simulate(nominal, scene.num_steps(), &simulator);
    ASSERT_TRUE(rollout.ok());
    const auto forces_at = [&](const Parameters& parameters) {
      simulator.UseParameters(parameters);
      return HandleForces(simulator.model(), parameters, scene.num_steps(), {scene.handles.nodes});
    };
    HandleForces forces = forces_at(nominal);
    Eigen::MatrixXd states(3 * static_cast<Eigen::Index>(forces.nodes().size()), scene.num_steps() + 1);
    for (int step = 0; step <= scene.num_steps(); ++step) states.col(step) = forces.Gather(rollout.positions(step));
    for (const ParameterId id : scene.piece_parameters()) {
      if (id.part != 0) continue;  // the one at the handles
      constexpr int kStep = 7;
      const double value = GetParameter(nominal, id), change = 1e-4 * std::abs(value);
      Parameters more = nominal, less = nominal;
      SetParameter(id, value + change, &more);
      SetParameter(id, value - change, &less);
      const HandleForces upper = forces_at(more);
      const Eigen::VectorXd high = upper.At(kStep, upper.StatesAt(kStep, states));
      const HandleForces lower = forces_at(less);
      const Eigen::VectorXd low = lower.At(kStep, lower.StatesAt(kStep, states));
      const HandleForces own = forces_at(nominal);
      const Eigen::VectorXd derivative = own.ParameterDerivative(id, kStep, own.StatesAt(kStep, states));
      const Eigen::VectorXd difference = (high - low) / (2.0 * change);
      EXPECT_GT(derivative.norm(), 0.0) << ParameterName(id, {}, scene.mesh.piece_names);
      EXPECT_LE((difference - derivative).norm(), 1e-6 * derivative.norm())
          << ParameterName(id, {}, scene.mesh.piece_names);
    }
  }
}

}  // namespace
}  // namespace clothid::pieces_test
