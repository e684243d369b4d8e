// `benchmark stability`: energy balances against closed forms, audits of rollouts that lie, gradients that can be
// checked and that cannot, every extreme at a reduced size, and the command itself.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>

#include "sim/rollout/simulator.h"
#include "tests/tools/tool_test.h"
#include "tools/benchmark/base/benchmark_scene.h"
#include "tools/benchmark/steps/benchmark_stability.h"
#include "tools/benchmark/steps/stability_extremes.h"

namespace clothid {
namespace {

constexpr int kNodes = 6;

Scene Cell(const std::string& scene, double stretch_stiffness, int step_rate, double mu,
           ContactMode mode = ContactMode::kGap) {
  return MakeStabilityScene({scene, mode, stretch_stiffness, 1.0 / step_rate, mu}, kNodes);
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
  RolloutAudit Audit() { return AuditRollout(rollout, simulator.scene().num_steps(), &simulator); }
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

class RolloutAuditTest : public testing::Test {
 protected:
  RolloutAuditTest() : run_(Cell("drape", 100.0, 100, 0.35)) {}

  TestRun run_;
};

TEST_F(RolloutAuditTest, FindsNothingInAnHonestRollout) {
  ASSERT_TRUE(run_.rollout.ok());
  EXPECT_GT(run_.rollout.counts.contacts, 0);
  const RolloutAudit audit = run_.Audit();
  EXPECT_EQ(audit.violations(), 0);
  EXPECT_GT(audit.worst_residual, 0.0);
  EXPECT_LE(audit.worst_residual, 1.0);
  EXPECT_LE(audit.penetration, 1e-12);
}

TEST(StagesAuditTest, FindsNothingInAnHonestRollout) {
  Scene scene = Cell("drape", 100.0, 100, 0.35);
  scene.integrator = Integrator::kSdirk2;
  TestRun run(scene);
  ASSERT_TRUE(run.rollout.ok());
  const RolloutAudit audit = run.Audit();
  EXPECT_EQ(audit.violations(), 0);
  EXPECT_GT(audit.worst_residual, 0.0);
  EXPECT_LE(audit.worst_residual, 1.0);
  EXPECT_LE(audit.penetration, 1e-12);
}

TEST_F(RolloutAuditTest, FindsPositionsThatDoNotBelongToTheVelocities) {
  run_.rollout.records[10].positions.array() += 1e-6;
  const RolloutAudit audit = run_.Audit();
  EXPECT_EQ(audit.inconsistent, 2);  // the solve itself and the one that starts from it
  EXPECT_GE(audit.unsolved, 1);
}

TEST_F(RolloutAuditTest, FindsAStateThatDoesNotSolveItsStep) {
  StepRecord& record = run_.rollout.records.back();
  record.velocities[3 * 14] += 1e-3;
  record.positions[3 * 14] += 1e-3 * record.time_step;
  EXPECT_EQ(run_.Audit().unsolved, 1);
}

TEST_F(RolloutAuditTest, FindsBranchesThatAreNotThoseOfTheState) {
  for (StepRecord& record : run_.rollout.records) {
    if (record.contacts.empty()) continue;
    ContactBranch& branch = record.contacts.front().branch;
    branch = branch == ContactBranch::kSlip ? ContactBranch::kStick : ContactBranch::kSlip;
    break;
  }
  const RolloutAudit audit = run_.Audit();
  EXPECT_EQ(audit.inconsistent, 1);
  EXPECT_EQ(audit.violations(), 1);
}

TEST_F(RolloutAuditTest, FindsNumbersThatAreNone) {
  run_.rollout.records[3].velocities[5] = std::nan("");
  EXPECT_EQ(run_.Audit().not_finite, 1);
}

TEST_F(RolloutAuditTest, FindsANodeInTheObstacle) {
  StepRecord& record = run_.rollout.records.back();
  ASSERT_FALSE(record.contacts.empty());
  const Eigen::Index row = 3 * static_cast<Eigen::Index>(record.contacts.front().node);
  const Obstacle& ball = *run_.simulator.scene().obstacles.front().shape;
  const SurfacePoint nearest = ball.Closest(record.positions.segment<3>(row));
  const Eigen::Vector3d into = -(nearest.gap + 1e-3) * nearest.normal;
  record.positions.segment<3>(row) += into;
  record.velocities.segment<3>(row) += into / record.time_step;
  const RolloutAudit audit = run_.Audit();
  EXPECT_EQ(audit.too_deep, 1);
  EXPECT_GT(audit.penetration, 1e-4);
}

TEST_F(RolloutAuditTest, FindsARolloutThatEndsEarlyAndSaysItDidNot) {
  run_.rollout.records.pop_back();
  EXPECT_EQ(run_.Audit().missing_steps, 1);
  run_.rollout.failure.emplace();  // one that says so is no silent failure
  EXPECT_EQ(run_.Audit().missing_steps, 0);
}

TEST(StabilityGradientTest, AgreesWhereDifferencesSettle) {
  for (const char* scene : {"drape", "slope"}) {
    const StabilityGradient check = CheckGradient(Cell(scene, 100.0, 100, 0.35), 1);
    ASSERT_TRUE(check.is_checkable()) << check.Reasons();
    ASSERT_EQ(check.components.size(), 2u);
    EXPECT_EQ(check.components[0].parameter, "k_stretch");
    EXPECT_EQ(check.components[1].parameter, "mu");
    EXPECT_LE(check.error(), 1e-4) << scene;
    EXPECT_EQ(check.Reasons(), "");
  }
  const StabilityGradient wind = CheckGradient(Cell("wind", 100.0, 100, 0.0), 1);
  ASSERT_TRUE(wind.is_checkable()) << wind.Reasons();
  ASSERT_EQ(wind.components.size(), 3u);
  EXPECT_EQ(wind.components[2].parameter, "drag");
  EXPECT_LE(wind.error(), 1e-4);
}

TEST(StabilityGradientTest, SaysWhyItCannotCheck) {
  EXPECT_EQ(CheckGradient(Extreme("touching"), 1).Reasons(), "k_stretch: nothing depends on it");
  const std::string on_boundary = CheckGradient(Extreme("cone_boundary"), 1).Reasons();
  EXPECT_NE(on_boundary.find("mu: branches differ"), std::string::npos) << on_boundary;
  Scene impossible = Cell("drape", 1000.0, 30, 0.35);
  impossible.solver.max_newton_iterations = 1;
  impossible.solver.max_substep_halvings = 0;
  const StabilityGradient failed = CheckGradient(impossible, 1);
  EXPECT_FALSE(failed.is_checkable());
  EXPECT_TRUE(std::isnan(failed.error()));
  EXPECT_EQ(failed.Reasons().rfind("the rollout failed: step 1 did not converge", 0), 0u) << failed.Reasons();
}

// Both contact modes, soft and realistic, coarse steps.
TEST(StabilityTest, AGridHasNoFailures) {
  StabilityOptions options;
  options.settings = {"grid"};
  options.stretch_stiffness = {1.0, 1000.0};
  options.step_rates = {60, 30};
  options.friction_coefficients = {0.0, 0.35};
  options.nodes = kNodes;
  const StabilityBenchmark benchmark = RunStabilityBenchmark(options);
  ASSERT_EQ(benchmark.grid.size(), 2u * (2 * 2 * 2 * 2 * 2 + 4));
  EXPECT_TRUE(benchmark.extremes.empty());
  int checkable = 0;
  for (const StabilityRow& row : benchmark.grid) {
    SCOPED_TRACE(StabilityCsvLine(row));
    EXPECT_TRUE(row.ok());
    EXPECT_EQ(row.silent_failures(), 0);
    EXPECT_EQ(row.counts.steps, row.num_steps);
    EXPECT_FALSE(row.gains_energy());
    checkable += row.gradient.is_checkable();
    if (row.gradient.is_checkable()) {
      EXPECT_LE(row.gradient.error(), 1e-4);
    }
  }
  EXPECT_GE(checkable, 0.8 * static_cast<double>(benchmark.grid.size()));
}

// Whatever is given either ends with a balance or in an error.
TEST(StabilityTest, EveryExtremeBalancesOrSaysWhatIsWrong) {
  StabilityOptions options;
  options.settings = {"extremes"};
  options.nodes = kNodes;
  options.check_gradients = false;
  for (const StabilityRow& row : RunStabilityBenchmark(options).extremes) {
    SCOPED_TRACE(StabilityCsvLine(row));
    EXPECT_EQ(row.silent_failures(), 0);
    EXPECT_FALSE(row.gains_energy());
    if (row.name == "unconnected") {
      EXPECT_NE(row.error.find("node 36 belongs to no triangle"), std::string::npos);
    } else if (row.name == "slivers" || row.name == "collapsed") {
      EXPECT_TRUE(row.ok() || row.error.find("relative residual") != std::string::npos);
    } else {
      EXPECT_TRUE(row.ok());
    }
  }
}

class StabilityToolTest : public ToolTest {};

TEST_F(StabilityToolTest, PrintsTablesAndWritesEveryRow) {
  const std::string command =
      "benchmark stability --settings grid,nothing,unconnected --integrator sdirk2 --scene wind,slope --contact "
      "velocity --k_stretch "
      "10,1e5 "
      "--mu 0.1 --steps 30 --nodes 4 --nogradients --output ";
  const ToolResult one = Run(command + "one");
  EXPECT_EQ(one.exit_code, 0) << one.err;
  EXPECT_NE(one.out.find("\nsdirk2  slope   velocity  > 1e4"), std::string::npos) << one.out;
  EXPECT_NE(one.out.find("\nsdirk2  wind    gap       <= 1e4"), std::string::npos) << one.out;
  EXPECT_NE(one.out.find("\nfailed (1):\n  unconnected, gap, sdirk2, k 1000"), std::string::npos) << one.out;
  EXPECT_NE(one.err.find("row 6 of 6"), std::string::npos) << one.err;
  const std::string grid = ReadBytes(folder() / "one" / "stability.csv");
  EXPECT_EQ(grid.rfind("name,contact,integrator,k_stretch,time_step,mu,steps,done,failed_steps,error,", 0), 0u) << grid;
  EXPECT_EQ(std::count(grid.begin(), grid.end(), '\n'), 1 + 4) << grid;
  const std::string extremes = ReadBytes(folder() / "one" / "stability_extremes.csv");
  EXPECT_EQ(std::count(extremes.begin(), extremes.end(), '\n'), 1 + 2) << extremes;
  EXPECT_EQ(Run(command + "two --threads 2").out, one.out);
  EXPECT_EQ(ReadBytes(folder() / "two" / "stability.csv"), grid);
}

TEST_F(StabilityToolTest, RefusesWhatItCannotRun) {
  ExpectRefused("benchmark stability --settings gird", 1, "--settings: 'gird'");
  ExpectRefused("benchmark stability --scene sphere", 1, "--scene: 'sphere'");
  ExpectRefused("benchmark stability --integrator both", 1, "--integrator: 'both': expected euler or sdirk2");
  ExpectRefused("benchmark stability --contact both", 1, "--contact: 'both'");
  ExpectRefused("benchmark stability --k_stretch 0", 1, "--k_stretch");
  ExpectRefused("benchmark stability --k_stretch soft", 1, "--k_stretch: 'soft'");
  ExpectRefused("benchmark stability --mu -1", 1, "--mu");
  ExpectRefused("benchmark stability --steps 0", 1, "--steps");
  ExpectRefused("benchmark stability --nodes 3", 1, "--nodes");
  ExpectRefused("benchmark stability --threads 0", 1, "--threads");
}

}  // namespace
}  // namespace clothid
