// Energy balances of rollouts against closed forms: what no work pays for is what the integrator loses
// (sim/rollout/energy_loss.h), to rounding.
#include "tests/tools/benchmark/energy_balance.h"

#include <gtest/gtest.h>

#include <memory>
#include <stdexcept>
#include <string>

#include "tools/benchmark/base/benchmark_scene.h"
#include "tools/benchmark/steps/stability_scene.h"

namespace clothid::energy_balance_test {
namespace {

constexpr int kNodes = 6;

Scene Cell(const std::string& scene, double stretch_stiffness, int step_rate, double mu) {
  return MakeStabilityScene({scene, ContactMode::kGap, stretch_stiffness, 1.0 / step_rate, mu}, kNodes);
}

Scene Extreme(const std::string& name) {
  for (const StabilityExtreme& extreme : StabilityExtremes()) {
    if (extreme.name == name) return extreme.scene(kNodes);
  }
  throw std::logic_error(name);
}

struct TestRun {
  Simulator simulator;
  Rollout rollout;
  explicit TestRun(const Scene& scene)
      : simulator(scene), rollout(Simulate(scene.nominal_parameters(), scene.num_steps(), &simulator)) {}

  EnergyBalance Balance() { return BalanceEnergy(rollout, &simulator); }
};

// A flat square of 1 m^2 without bending, far from anything.
Scene FlatSquare() {
  Scene scene = MakeStabilityCloth(kNodes, Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY());
  scene.mesh.rest_positions.row(2).setZero();
  StartAtRestShape(Eigen::Vector3d::Zero(), &scene);
  scene.integrator = Integrator::kEuler;
  scene.time_step = 0.01;
  scene.material.bending_stiffness = 0.0;
  return scene;
}

TEST(EnergyBalanceTest, FreeFallLosesWhatBackwardEulerTakes) {
  const Scene scene = FlatSquare();
  TestRun run(scene);
  ASSERT_TRUE(run.rollout.ok());
  const EnergyBalance balance = run.Balance();
  const double mass = scene.material.density, speed_change = 9.81 * scene.time_step;
  const double loss = scene.num_steps() * 0.5 * mass * speed_change * speed_change;
  EXPECT_EQ(balance.total.work(), 0.0);
  EXPECT_NEAR(balance.total.loss.inertia, loss, 1e-9 * loss);
  EXPECT_NEAR(balance.total.change, -loss, 1e-9 * loss);
  EXPECT_NEAR(balance.total.loss.elastic, 0.0, 1e-9 * loss);
  EXPECT_EQ(balance.excess, 0.0);
  EXPECT_EQ(balance.unexplained_steps, 0);
}

// Both ends of a strip move apart evenly by s L in n steps; the nodes between them stay. U = k A s^2/2, and the force
// at the end of each step does U (1 + 1/n) of work.
TEST(EnergyBalanceTest, HandlesDoTheWorkOfStretching) {
  constexpr int kSteps = 10;
  constexpr double kStretch = 0.1;
  Scene scene = FlatSquare();
  GridOptions grid;
  grid.nodes = {3, 2};
  grid.size = {1.0, 0.2};
  scene.mesh = MakeGrid(grid);
  StartAtRestShape(Eigen::Vector3d::Zero(), &scene);
  scene.gravity.setZero();
  scene.duration = kSteps * scene.time_step;
  scene.handles.nodes = {0, 2, 3, 5};
  Eigen::MatrixXd path(12, 2);
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector3d start = scene.initial_positions.segment<3>(3 * scene.handles.nodes[i]);
    path.block<3, 1>(3 * i, 0) = start;
    path.block<3, 1>(3 * i, 1) = start + Eigen::Vector3d((i % 2 == 0 ? -0.5 : 0.5) * kStretch, 0.0, 0.0);
  }
  scene.handles.path = HandlePath(Eigen::Vector2d(0.0, scene.duration), path);
  TestRun run(scene);
  ASSERT_TRUE(run.rollout.ok());
  const EnergyFlow flow = run.Balance().total;
  const double energy = 0.5 * scene.material.stretch_stiffness * 0.2 * kStretch * kStretch;
  EXPECT_NEAR(flow.change, energy, 1e-9 * energy);
  EXPECT_NEAR(flow.handle_work, energy * (1.0 + 1.0 / kSteps), 1e-9 * energy);
  EXPECT_NEAR(flow.loss.elastic, energy / kSteps, 1e-9 * energy);
  EXPECT_EQ(flow.air_work + flow.force_work + flow.contact_work, 0.0);
  EXPECT_LE(std::abs(flow.unexplained()), flow.tolerance);
  EXPECT_EQ(run.Balance().unexplained_steps, 0);
}

// An even wind blows a cloth away: v_n = w (1 - (1 + a)^-n), a = h c_d/rho.
TEST(EnergyBalanceTest, WindDoesTheWorkOfDrag) {
  Scene scene = FlatSquare();
  scene.gravity.setZero();
  scene.material.drag = 0.4;
  scene.wind.mean = Eigen::Vector3d(0.0, 1.0, 2.0);
  TestRun run(scene);
  ASSERT_TRUE(run.rollout.ok());
  const EnergyBalance balance = run.Balance();
  const double density = scene.material.density, a = scene.time_step * scene.material.drag / density;
  const double speed = scene.wind.mean.norm();
  double kinetic = 0.0, loss = 0.0, work = 0.0, v = 0.0;
  for (int step = 0; step < scene.num_steps(); ++step) {
    const double next = (v + a * speed) / (1.0 + a);
    work += density * a * (speed - next) * next;
    loss += 0.5 * density * (next - v) * (next - v);
    v = next;
  }
  kinetic = 0.5 * density * v * v;
  EXPECT_NEAR(balance.total.change, kinetic, 1e-9 * kinetic);
  EXPECT_NEAR(balance.total.air_work, work, 1e-9 * kinetic);
  EXPECT_NEAR(balance.total.loss.inertia, loss, 1e-9 * kinetic);
  EXPECT_EQ(balance.excess, 0.0);
  EXPECT_EQ(balance.unexplained_steps, 0);
}

TEST(EnergyBalanceTest, FrictionTakesEnergyAndObstaclesGiveItToWhatStartsInThem) {
  TestRun slope(Cell("slope", 100.0, 100, 0.1));
  const EnergyBalance slides = slope.Balance();
  EXPECT_LT(slides.total.contact_work, 0.0);
  EXPECT_LE(slides.total.push_work, 1e-12);
  TestRun inside(Extreme("inside"));
  const EnergyBalance pushed = inside.Balance();
  EXPECT_GT(pushed.total.push_work, 0.1);
  for (const EnergyBalance& balance : {slides, pushed}) {
    EXPECT_LE(balance.excess, balance.total.tolerance);
    EXPECT_EQ(balance.unexplained_steps, 0);
  }
}

// The last step made faster than the forces make it.
TEST(EnergyBalanceTest, FindsEnergyThatNoWorkPaysFor) {
  TestRun run(FlatSquare());
  const EnergyBalance before = run.Balance();
  StepRecord& record = run.rollout.records.back();
  record.velocities *= 1.01;
  record.positions =
      run.rollout.records[run.rollout.records.size() - 2].positions + record.time_step * record.velocities;
  const EnergyBalance after = run.Balance();
  EXPECT_EQ(before.unexplained_steps, 0);
  EXPECT_EQ(after.unexplained_steps, 1);
  EXPECT_GT(after.gain, before.gain);
}

Scene InStages(Scene scene) {
  scene.integrator = Integrator::kSdirk2;
  return scene;
}

TEST(StagesBalanceTest, FreeFallKeepsItsEnergy) {
  TestRun run(InStages(FlatSquare()));
  ASSERT_TRUE(run.rollout.ok());
  const EnergyBalance balance = run.Balance();
  EXPECT_NEAR(balance.total.change, 0.0, 1e-13 * balance.largest_energy);
  EXPECT_NEAR(balance.total.loss.inertia, 0.0, 1e-13 * balance.largest_energy);
  EXPECT_EQ(balance.unexplained_steps, 0);
}

// Hung by two corners and let go, without anything that takes energy: 1/20 of Euler's loss at the most.
TEST(StagesBalanceTest, ASwingKeepsItsEnergy) {
  Scene scene = Cell("wind", 100.0, 100, 0.0);
  scene.material.drag = 0.0;
  scene.wind = {};
  scene.duration = 1.0;
  TestRun euler(scene), stages(InStages(scene));
  ASSERT_TRUE(euler.rollout.ok() && stages.rollout.ok());
  const EnergyBalance lost = euler.Balance(), kept = stages.Balance();
  EXPECT_EQ(kept.unexplained_steps, 0);
  EXPECT_LT(lost.total.change, 0.0);
  EXPECT_LE(std::abs(kept.total.change), -lost.total.change / 20.0);
}

// Every term at once: wind, handles that move, internal damping, an obstacle.
TEST(StagesBalanceTest, ExplainsEveryStep) {
  Scene scene = InStages(Cell("drape", 100.0, 100, 0.35));
  scene.material.drag = 0.4;
  scene.material.damping = 0.2;
  scene.wind.mean = Eigen::Vector3d(1.0, 2.0, 0.0);
  scene.node_force = Eigen::Vector3d(0.0, 1e-3, 0.0);
  scene.handles.nodes = {0, kNodes - 1};
  Eigen::MatrixXd path(6, 2);
  for (int i = 0; i < 2; ++i) {
    const Eigen::Vector3d start = scene.initial_positions.segment<3>(3 * scene.handles.nodes[i]);
    path.block<3, 1>(3 * i, 0) = start;
    path.block<3, 1>(3 * i, 1) = start + Eigen::Vector3d(0.05, 0.0, 0.1);
  }
  scene.handles.path = HandlePath(Eigen::Vector2d(0.0, scene.duration), path);
  TestRun run(scene);
  ASSERT_TRUE(run.rollout.ok());
  const EnergyBalance balance = run.Balance();
  EXPECT_EQ(balance.unexplained_steps, 0);
  const EnergyFlow& flow = balance.total;
  for (const double term : {flow.force_work, flow.air_work, flow.handle_work, flow.contact_work, flow.loss.damping}) {
    EXPECT_GT(std::abs(term), 1e3 * flow.tolerance);
  }
  StepRecord& record = run.rollout.records.back();
  record.velocities *= 1.01;
  const StepRecord& first = run.rollout.records[run.rollout.records.size() - 2];
  record.positions += 0.01 * record.time_step * record.velocities;
  EXPECT_EQ(first.stage, Stage::kFirst);
  EXPECT_EQ(run.Balance().unexplained_steps, 1);
}

// A flat sheet falls on a plane: without strain nothing but contact changes its energy.
TEST(StagesBalanceTest, NoImpactGainsEnergy) {
  for (const double speed : {0.1, 0.5, 2.0}) {
    for (const double mu : {0.0, 0.2, 2.0}) {
      Scene scene = InStages(FlatSquare());
      AddObstacle("plane", std::make_shared<Plane>(Eigen::Vector3d(0.0, 0.0, -0.013), Eigen::Vector3d::UnitZ()), mu,
                  &scene);
      StartAtRestShape(Eigen::Vector3d(0.2, 0.3, -speed), &scene);
      TestRun run(scene);
      ASSERT_TRUE(run.rollout.ok());
      const EnergyBalance balance = run.Balance();
      EXPECT_LT(balance.total.contact_work, 0.0);
      EXPECT_LE(balance.contact_gain, 1e-10 * balance.largest_energy) << speed << " " << mu;
      EXPECT_EQ(balance.unexplained_steps, 0);
    }
  }
}

}  // namespace
}  // namespace clothid::energy_balance_test
