// The forces at handles: closed forms, balances of momentum and energy over rollouts.
#include "sim/rollout/handle_forces.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <utility>

#include "sim/base/error.h"
#include "sim/rollout/energy_loss.h"
#include "sim/rollout/pair_forces.h"
#include "tests/sim/held_rollouts.h"
#include "tests/sim/plain_scenes.h"
#include "tests/sim/self_contact_scenes.h"

namespace clothid::handle_forces_test {
namespace {

// A plate that moves along its normal through air at rest.
TEST(HandleForcesTest, IsTheDragOfAPlate) {
  for (const AirLaw law : {AirLaw::kLinear, AirLaw::kQuadratic}) {
    for (const Integrator integrator : kIntegrators) {
      Scene scene = ClothScene(SquareGrid(4, 0.1), 0.01);
      scene.integrator = integrator;
      scene.gravity.setZero();
      scene.duration = 0.1;
      scene.air_law = law;
      scene.material.normal_drag = 0.7;
      scene.material.tangential_drag = 0.2;
      scene.material.pressure = 5.0;
      scene.handles.nodes = FirstRow(8);
      const Simulator simulator(scene);
      const HandleForces forces(simulator.model(), scene.nominal_parameters(), 10, {scene.handles.nodes});
      constexpr double kSpeed = 3.0;
      HandleForces::States states;
      for (std::size_t k = 0; k < 3; ++k) {
        Eigen::VectorXd positions = scene.initial_positions;
        for (int node = 0; node < 16; ++node) positions[3 * node + 2] += kSpeed * 0.01 * static_cast<double>(k);
        states[k] = forces.Gather(positions);
      }
      const double area = simulator.model().node_areas().head(8).sum();
      const double drag = 0.7 * (law == AirLaw::kQuadratic ? kSpeed * kSpeed : kSpeed);
      const Eigen::Vector3d expected(0.0, 0.0, area * (drag - 5.0));
      EXPECT_LT((forces.At(5, states) - expected).norm(), 1e-11 * expected.norm());
    }
  }
}

// At rest in air that stands still it is what the energy grows by where the handles move.
TEST(HandleForcesTest, IsTheSlopeOfTheEnergyOfEveryForce) {
  Scene scene = WithEveryForce(ShakenCloth(Integrator::kSdirk2, 0.01));
  scene.gravity.setZero();
  scene.node_force.setZero();
  scene.wind = Wind();
  scene.material.pressure = 0.0;  // has no energy
  const Simulator simulator(scene);
  const HandleGroups groups = {{0, 1, 2}, {4, 5}};
  const HandleForces forces(simulator.model(), scene.nominal_parameters(), scene.num_steps(), groups);
  std::mt19937_64 generator(5);
  std::normal_distribution<double> normal;
  Eigen::VectorXd positions = 1.03 * scene.initial_positions;
  for (double& coordinate : positions) coordinate += 0.004 * normal(generator);
  constexpr int kStep = 7;
  const Eigen::MatrixXd near = forces.Gather(positions);
  const Eigen::VectorXd force = forces.At(kStep, {near, near, near});
  const Eigen::VectorXd still = Eigen::VectorXd::Zero(positions.size());
  for (Eigen::Index row = 0; row < force.size(); ++row) {
    const auto energy_at = [&](double shift) {
      Eigen::VectorXd moved = positions;
      for (const int node : groups[static_cast<std::size_t>(row / 3)]) moved[3 * node + row % 3] += shift;
      return StateEnergy(scene.nominal_parameters(), moved, still, simulator, kStep * scene.time_step).elastic();
    };
    const double difference = (energy_at(1e-5) - energy_at(-1e-5)) / 2e-5;
    EXPECT_NEAR(force[row], difference, 1e-7 * force.norm()) << row;
  }
}

TEST(HandleForcesTest, IsTheWeightOfAClothThatHangsAtRest) {
  for (const Integrator integrator : kIntegrators) {
    SCOPED_TRACE(IntegratorName(integrator));
    GridOptions grid = SquareGrid(5, 0.2);
    grid.axes = {Eigen::Vector3d::UnitX(), -Eigen::Vector3d::UnitZ()};
    Scene scene = ClothScene(grid, 0.02);
    scene.integrator = integrator;
    scene.duration = 6.0;
    scene.handles.nodes = FirstRow(5);
    scene.material.drag = 1.0;
    scene.material.damping = 0.5;
    const HeldRollout run(scene, {FirstRow(5)});
    const Eigen::Vector3d force = run.values.rightCols(1);
    EXPECT_LE((force - Eigen::Vector3d(0.0, 0.0, 9.81 * run.total_mass())).norm(), 1e-5 * 9.81 * run.total_mass());
  }
}

// k/2 |F - R|^2 of a strip whose ends stand e apart, and whose sides are held to the rest width: k e per width.
TEST(HandleForcesTest, IsTheStressOfAStretchedStrip) {
  GridOptions grid;
  grid.nodes = {5, 3};
  grid.size = {0.2, 0.05};
  Scene scene = ClothScene(grid, 0.01);
  scene.gravity.setZero();
  scene.duration = 0.02;
  constexpr double kStrain = 0.04;
  for (int node = 0; node < scene.mesh.num_nodes(); ++node) scene.handles.nodes.push_back(node);
  for (int node = 0; node < scene.mesh.num_nodes(); ++node) scene.initial_positions[3 * node] *= 1.0 + kStrain;
  scene.handles.nodes.pop_back();  // a cloth must have a node that moves, here one where forces cancel but along x
  const std::vector<int> left = {0, 5, 10};
  const HeldRollout run(scene, {left});
  const double expected = -scene.material.stretch_stiffness * kStrain * 0.05;
  EXPECT_NEAR(run.values(0, 0), expected, 1e-9 * std::abs(expected));
  EXPECT_LE(std::abs(run.values(1, 0)) + std::abs(run.values(2, 0)), 1e-12);
}

// Of yarns that stiffen k (exp(b e) - 1)/b per width.
TEST(HandleForcesTest, IsTheCurveOfAStripOfYarns) {
  GridOptions grid;
  grid.nodes = {5, 3};
  grid.size = {0.2, 0.05};
  Scene scene = ClothScene(grid, 0.01);
  scene.gravity.setZero();
  scene.duration = 0.02;
  scene.membrane = MembraneLaw::kYarn;
  Material& material = scene.material;
  material.stretch_stiffness = 0.0;
  material.warp_stiffness = material.weft_stiffness = 80.0;
  material.shear_stiffness = 15.0;
  material.warp_stiffening = 20.0;
  scene.handles.nodes = FirstRow(14);
  for (const double strain : {0.02, 0.1, 0.3}) {
    Scene strained = scene;
    for (int node = 0; node < 15; ++node) strained.initial_positions[3 * node] *= 1.0 + strain;
    const HeldRollout run(strained, {{0, 5, 10}});
    const double expected = -80.0 * std::expm1(20.0 * strain) / 20.0 * 0.05;
    EXPECT_NEAR(run.values(0, 0), expected, 1e-9 * std::abs(expected)) << strain;
  }
}

// Lifted as a whole: weight and inertia of all of it, in each group of its own nodes.
TEST(HandleForcesTest, LiftsAClothHeldEverywhere) {
  Scene scene = ClothScene(SquareGrid(3, 0.1), 0.01);
  scene.duration = 0.2;
  scene.handles.nodes = {0, 1, 2, 3, 4, 5, 6, 7};
  const Eigen::Vector3d acceleration(0.5, 0.0, 2.0);
  MoveHandles(
      21, [&](double t) -> Eigen::Vector3d { return 0.5 * t * t * acceleration; }, &scene);
  const HeldRollout run(scene, {{0, 1, 2}, {3}});
  const double mass = scene.material.density * run.simulator.model().nodes().mass_areas()[3];
  const Eigen::Vector3d force = run.values.col(1).tail<3>();
  // In the first steps node 8 has not moved yet.
  EXPECT_LE((force - mass * (acceleration - scene.gravity)).norm(), 1e-3 * mass * 9.81);
}

// Momentum: what all handles take is what all nodes gain less what acts on them from outside.
double MomentumDefect(const HeldRollout& run, int step) {
  const Scene& scene = run.scene;
  const ClothModel& model = run.simulator.model();
  const bool is_euler = scene.integrator == Integrator::kEuler;
  const Eigen::VectorXd acceleration = run.AccelerationAt(is_euler ? step - 1 : step);
  const Eigen::VectorXd ends = run.rollout.positions(is_euler ? step : step + 1);
  const Eigen::VectorXd velocity =
      (ends - run.rollout.positions(step - 1)) / ((is_euler ? 1.0 : 2.0) * scene.time_step);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int node = 0; node < model.num_nodes(); ++node) {
    const double mass = scene.material.density * model.nodes().mass_areas()[node];
    sum += mass * (acceleration.segment<3>(3 * node) - scene.gravity) - scene.node_force;
    sum -= scene.material.drag * model.nodes().drag()->areas()[node] *
           (model.nodes().drag()->WindAt(node, step * scene.time_step, scene.wind) - velocity.segment<3>(3 * node));
  }
  if (model.forces().has(ForceGroup::kAir)) {  // of a step of backward Euler
    HeldForces held;
    held.start.origins = {{&run.rollout.positions(step - 1), 1.0}};
    held.start.predicted = 2.0 * run.rollout.positions(step - 1) - run.rollout.positions(step - 2);
    for (const int node : scene.handles.nodes) held.start.predicted.segment<3>(3 * node) = ends.segment<3>(3 * node);
    model.forces().Hold(run.rollout.parameters, step * scene.time_step, &held);
    Eigen::VectorXd force = Eigen::VectorXd::Zero(ends.size());
    model.forces().AddForce(ForceGroup::kAir,
                            {run.rollout.parameters, scene.time_step, step * scene.time_step, ends, velocity}, held,
                            &force);
    sum -= force.reshaped(3, model.num_nodes()).rowwise().sum();
  }
  return (run.values.col(step) - sum).norm() / run.values.col(step).norm();
}

TEST(HandleForcesTest, ClosesTheBalanceOfMomentumOfBackwardEuler) {
  const HeldRollout run(ShakenCloth(Integrator::kEuler, 0.01), {FirstRow(6)});
  for (int step = 2; step <= run.scene.num_steps(); ++step) EXPECT_LE(MomentumDefect(run, step), 1e-8) << step;
}

// Forces in the cloth add up to nothing, those of the air do not.
TEST(HandleForcesTest, ClosesTheBalanceOfMomentumWithEveryForce) {
  for (const AirLaw law : {AirLaw::kLinear, AirLaw::kQuadratic}) {
    Scene scene = WithEveryForce(ShakenCloth(Integrator::kEuler, 0.01));
    scene.air_law = law;
    const HeldRollout run(scene, {FirstRow(6)});
    for (int step = 2; step <= scene.num_steps(); ++step) EXPECT_LE(MomentumDefect(run, step), 1e-8) << step;
  }
}

TEST(HandleForcesTest, ClosesTheBalanceOfMomentumOfSdirk2InSecondOrder) {
  const auto largest = [](double time_step) {
    Scene scene = ShakenCloth(Integrator::kSdirk2, time_step);
    scene.material.stretch_stiffness = 5.0;  // so slow that the steps resolve all of its modes
    MoveHandles(
        3, [](double t) -> Eigen::Vector3d { return Eigen::Vector3d(0.0, 0.4, 0.3) * t * t; }, &scene);
    const HeldRollout run(scene, {FirstRow(6)});
    double defect = 0.0;
    for (int step = 2 * run.scene.num_steps() / 3; step < run.scene.num_steps(); ++step) {
      defect = std::max(defect, MomentumDefect(run, step));
    }
    return defect;
  };
  const double coarse = largest(0.0025), fine = largest(0.00125);
  EXPECT_LE(coarse, 0.02);
  EXPECT_GE(coarse / fine, 3.0);
}

// A layer slides on another, all of which is held: what its contacts push the handles with is in the balance.
TEST(HandleForcesTest, CarriesALayerThatSlides) {
  Scene scene = LayersOnASlope(2, 0.44, 0.3, Integrator::kEuler, 0.005);
  scene.material.bending_stiffness = 0.0;  // at rest it is not flat
  scene.duration = 0.1;
  const HeldRollout run(scene, {scene.handles.nodes});
  for (int step = 2; step <= scene.num_steps(); ++step) {
    const StepRecord& end = run.rollout.records[run.rollout.last_record[step - 1]];
    ASSERT_FALSE(end.contacts.pairs.empty());
    const Eigen::Vector3d pushed =
        run.forces.OverGroups(PairForces(run.simulator.model(), run.rollout.parameters, end));
    const Eigen::VectorXd acceleration = run.AccelerationAt(step - 1);
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int node = 0; node < scene.mesh.num_nodes(); ++node) {
      const double mass = scene.material.density * run.simulator.model().nodes().mass_areas()[node];
      sum += mass * (acceleration.segment<3>(3 * node) - scene.gravity);
    }
    EXPECT_LE((run.values.col(step) - pushed - sum).norm(), 1e-8 * sum.norm()) << step;
    EXPECT_GE(pushed.norm(), 0.1 * sum.norm());
  }
}

TEST(HandleForcesTest, SumsGroups) {
  const Scene scene = ShakenCloth(Integrator::kSdirk2, 0.01);
  const HeldRollout all(scene, {FirstRow(6)}), parts(scene, {{0, 1, 5}, {2, 4, 3}});
  EXPECT_LE((parts.values.topRows(3) + parts.values.bottomRows(3) - all.values).norm(), 1e-10 * all.values.norm());
}

// Energy: pulled slowly, the work at the handles is the energy that the cloth stores.
TEST(HandleForcesTest, DoesTheWorkThatAStretchedClothStores) {
  for (const Integrator integrator : kIntegrators) {
    SCOPED_TRACE(IntegratorName(integrator));
    GridOptions grid;
    grid.nodes = {6, 4};
    grid.size = {0.2, 0.1};
    Scene scene = ClothScene(grid, 0.02);
    scene.integrator = integrator;
    scene.gravity.setZero();
    scene.duration = 8.0;
    scene.material.drag = 0.5;
    scene.membrane = MembraneLaw::kOrthotropic;
    scene.material.warp_stiffness = 80.0;
    scene.material.weft_stiffness = 50.0;
    scene.material.poisson_stiffness = 20.0;
    scene.material.shear_stiffness = 15.0;
    scene.handles.nodes = {0, 6, 12, 18, 5, 11, 17, 23};
    const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(41, 0.0, scene.duration);
    Eigen::MatrixXd path(24, times.size());
    for (Eigen::Index k = 0; k < times.size(); ++k) {
      const double s = times[k] / scene.duration;
      for (int i = 0; i < 8; ++i) {
        path.col(k).segment<3>(3 * i) = scene.initial_positions.segment<3>(3 * scene.handles.nodes[i]);
        if (i >= 4) path(3 * i, k) += 0.02 * s * s * (3.0 - 2.0 * s);
      }
    }
    scene.handles.path = HandlePath(times, path);
    const HeldRollout run(scene, {{0, 6, 12, 18}, {5, 11, 17, 23}});
    double work = 0.0;
    for (int step = 1; step <= scene.num_steps(); ++step) {
      const double moved = run.rollout.positions(step)[3 * 5] - run.rollout.positions(step - 1)[3 * 5];
      work += 0.5 * (run.values(3, step) + run.values(3, step - 1)) * moved;
    }
    const Eigen::VectorXd end = run.rollout.positions(scene.num_steps());
    const double stored =
        StateEnergy(run.rollout.parameters, end, Eigen::VectorXd::Zero(end.size()), run.simulator, 0.0).elastic();
    EXPECT_NEAR(work, stored, 2e-3 * stored);
    EXPECT_NEAR(run.values(0, scene.num_steps()), -run.values(3, scene.num_steps()), 1e-3 * run.values(3, 200));
  }
}

TEST(HandleForcesTest, RejectsGroupsThatAreNoHandles) {
  const Scene scene = ShakenCloth(Integrator::kEuler, 0.01);
  const Simulator simulator(scene);
  const auto make = [&](const HandleGroups& groups) {
    HandleForces(simulator.model(), scene.nominal_parameters(), 10, groups);
  };
  EXPECT_THROW(make({{}}), Error);
  EXPECT_THROW(make({{0, 6}}), Error);
  EXPECT_THROW(make({{-1}}), Error);
}

}  // namespace
}  // namespace clothid::handle_forces_test
