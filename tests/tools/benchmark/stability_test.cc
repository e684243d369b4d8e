// `benchmark stability`: audits of rollouts that lie, every extreme at a reduced size, and the command itself.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "sim/rollout/simulator.h"
#include "tests/sim/energy_account.h"
#include "tests/tools/tool_test.h"
#include "tools/benchmark/steps/benchmark_stability.h"

namespace clothid::stability_test {
namespace {

constexpr int kNodes = 6;

Scene Cell(const std::string& scene, double stretch_stiffness, int step_rate, double mu,
           ContactMode mode = ContactMode::kGap) {
  return MakeStabilityScene({scene, mode, stretch_stiffness, 1.0 / step_rate, mu}, kNodes);
}

struct TestRun {
  Simulator simulator;
  Rollout rollout;
  explicit TestRun(const Scene& scene)
      : simulator(scene), rollout(Simulate(scene.nominal_parameters(), scene.num_steps(), &simulator)) {}

  RolloutAudit Audit() { return AuditRollout(rollout, simulator.scene().num_steps(), &simulator); }
};

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

// A cloth that falls on itself.
class SelfContactAuditTest : public testing::TestWithParam<Integrator> {
 protected:
  SelfContactAuditTest() : run_(Fold(GetParam())) {}

  static Scene Fold(Integrator integrator) {
    Scene scene = MakeStabilityScene({"fold", ContactMode::kGap, 100.0, 0.005, 0.3}, 10);
    scene.integrator = integrator;
    return scene;
  }

  // The first record with a pair in contact.
  StepRecord& Touching() {
    for (StepRecord& record : run_.rollout.records) {
      if (!record.contacts.pairs.empty()) return record;
    }
    throw std::logic_error("nothing touches");
  }

  TestRun run_;
};

TEST_P(SelfContactAuditTest, FindsNothingInAnHonestRollout) {
  ASSERT_TRUE(run_.rollout.ok());
  EXPECT_GT(run_.rollout.counts.self_contacts, 100);
  const RolloutAudit audit = run_.Audit();
  EXPECT_EQ(audit.violations(), 0);
  EXPECT_GT(audit.worst_residual, 0.0);
  EXPECT_LE(audit.worst_residual, 1.0);
  EXPECT_EQ(audit.self_contact.num_states, run_.rollout.num_steps() + 1);
  EXPECT_EQ(audit.self_contact.intersections, 0);
  EXPECT_GT(audit.self_contact.violation, 0.0);
}

TEST_P(SelfContactAuditTest, ItsEnergyCloses) {
  Scene scene = Fold(GetParam());
  scene.solver.step_tolerance = 1e-11;
  const EnergyAccount account(scene, scene.num_steps());
  EXPECT_GT(account.contact.friction, 0.01 * std::abs(account.change));
  EXPECT_NEAR(account.change, account.explained(), 1e-8 * std::abs(account.change));
}

TEST_P(SelfContactAuditTest, FindsForcesOfPairsThatAreNotThoseOfTheStep) {
  Touching().contacts.pairs.front().force *= 1.001;
  EXPECT_GE(run_.Audit().unsolved, 1);
}

TEST_P(SelfContactAuditTest, FindsPairsThatTheStepHasNot) {
  StepRecord& record = Touching();
  record.contacts.pairs.front().has_friction = false;
  EXPECT_EQ(run_.Audit().inconsistent, 1);
  record.contacts.pairs.erase(record.contacts.pairs.begin());
  EXPECT_GE(run_.Audit().unsolved, 1);
}

// A pair without friction is one that thinning had left out.
TEST_P(SelfContactAuditTest, CountsStepsWhosePairsDependOnEachOther) {
  const int before = AuditSelfContact(run_.rollout, &run_.simulator).dependent_steps;
  int first = 0;
  for (const int last : run_.rollout.last_record) {
    StepRecord& record = run_.rollout.records[static_cast<std::size_t>(last)];
    const auto is_left_out = [](const PairContactRecord& pair) { return !pair.has_friction; };
    bool is_dependent = false;
    for (int i = first; i <= last; ++i) {
      const std::vector<PairContactRecord>& pairs = run_.rollout.records[static_cast<std::size_t>(i)].contacts.pairs;
      is_dependent = is_dependent || std::any_of(pairs.begin(), pairs.end(), is_left_out);
    }
    first = last + 1;
    if (is_dependent || record.contacts.pairs.empty()) continue;
    record.contacts.pairs.front().has_friction = false;
    EXPECT_EQ(AuditSelfContact(run_.rollout, &run_.simulator).dependent_steps, before + 1);
    return;
  }
  FAIL() << "every step depends";
}

TEST_P(SelfContactAuditTest, MakesStatesAgainThatWereNotKept) {
  const Scene& scene = run_.simulator.scene();
  SelfContactAuditor seen(scene);
  RolloutOptions options;
  options.checkpoint_interval = 7;
  options.visitor = [&](int, const Eigen::VectorXd& positions) { seen.Add(positions); };
  const Rollout rollout = Simulate(scene.nominal_parameters(), scene.num_steps(), &run_.simulator, nullptr, options);
  const SelfContactAudit audit = AuditSelfContact(rollout, &run_.simulator);
  EXPECT_EQ(audit.num_states, scene.num_steps() + 1);
  EXPECT_EQ(audit.violation, seen.audit().violation);
  EXPECT_EQ(audit.deepest, seen.audit().deepest);
  EXPECT_GT(audit.push, 0.0);
}

TEST_P(SelfContactAuditTest, FindsWhereTheClothCutsItself) {
  StepRecord& record = run_.rollout.records.back();
  record.positions.segment<3>(3 * 49).z() -= 0.2;  // at the border of the upper layer
  const SelfContactAudit audit = run_.Audit().self_contact;
  EXPECT_GT(audit.intersections, 0);
  EXPECT_EQ(audit.num_cut, 1);
  EXPECT_EQ(audit.first_cut, run_.rollout.num_steps());
  EXPECT_EQ(audit.violation, run_.simulator.scene().self_contact->thickness);
}

INSTANTIATE_TEST_SUITE_P(Integrators, SelfContactAuditTest, testing::Values(Integrator::kEuler, Integrator::kSdirk2),
                         [](const auto& test) { return std::string(IntegratorName(test.param)); });

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
    if (record.contacts.nodes.empty()) continue;
    ContactBranch& branch = record.contacts.nodes.front().branch;
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
  ASSERT_FALSE(record.contacts.nodes.empty());
  const Eigen::Index row = 3 * static_cast<Eigen::Index>(record.contacts.nodes.front().node);
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

// Both contact modes, soft and realistic, coarse steps.
TEST(StabilityTest, AGridHasNoFailures) {
  StabilityOptions options;
  options.settings = {"grid"};
  options.scenes = {"drape", "push", "slope", "wind"};
  options.stretch_stiffness = {1.0, 1000.0};
  options.step_rates = {60, 30};
  options.friction_coefficients = {0.0, 0.35};
  options.nodes = kNodes;
  const StabilityBenchmark benchmark = RunStabilityBenchmark(options);
  ASSERT_EQ(benchmark.grid.size(), 2u * (3 * 2 * 2 * 2 * 2 + 4));
  EXPECT_TRUE(benchmark.extremes.empty());
  for (const StabilityRow& row : benchmark.grid) {
    SCOPED_TRACE(DescribeRow(row));
    EXPECT_TRUE(row.ok());
    EXPECT_EQ(row.audit.violations(), 0);
    EXPECT_EQ(row.counts.steps, row.num_steps);
    EXPECT_FALSE(row.gains_energy());
  }
}

TEST(StabilityTest, YarnsThatStiffenHaveNoFailures) {
  StabilityOptions options;
  options.settings = {"grid"};
  options.scenes = {"drape", "wind"};
  options.contacts = {"gap"};
  options.stretch_stiffness = {10.0, 1000.0};
  options.stiffening = 20.0;
  options.step_rates = {200, 30};
  options.friction_coefficients = {0.35};
  options.nodes = kNodes;
  const StabilityBenchmark benchmark = RunStabilityBenchmark(options);
  ASSERT_EQ(benchmark.grid.size(), 2u * 2 * 2 * 2);
  for (const StabilityRow& row : benchmark.grid) {
    SCOPED_TRACE(DescribeRow(row));
    EXPECT_TRUE(row.ok());
    EXPECT_EQ(row.audit.violations(), 0);
    EXPECT_GE(row.stretch_stiffness, 10.0);
  }
}

// A cloth that falls on itself, which cuts itself nowhere by backward Euler.
TEST(StabilityTest, AFoldHasNoFailures) {
  StabilityOptions options;
  options.settings = {"grid"};
  options.scenes = {"fold"};
  options.stretch_stiffness = {10.0, 1000.0};
  options.step_rates = {200, 60};
  options.friction_coefficients = {0.0, 0.35};
  options.nodes = 8;
  const StabilityBenchmark benchmark = RunStabilityBenchmark(options);
  ASSERT_EQ(benchmark.grid.size(), 2u * 2 * 2 * 2) << "contact by gap alone";
  for (const StabilityRow& row : benchmark.grid) {
    SCOPED_TRACE(DescribeRow(row));
    EXPECT_TRUE(row.ok());
    EXPECT_EQ(row.audit.violations(), 0);
    EXPECT_GT(row.counts.self_contacts, 0);
    EXPECT_FALSE(row.gains_energy());
    if (row.integrator == "euler") {
      EXPECT_EQ(row.audit.self_contact.intersections, 0);
    }
  }
}

// Whatever is given either ends with a balance or in an error.
TEST(StabilityTest, EveryExtremeBalancesOrSaysWhatIsWrong) {
  StabilityOptions options;
  options.settings = {"extremes"};
  options.nodes = kNodes;
  for (const StabilityRow& row : RunStabilityBenchmark(options).extremes) {
    SCOPED_TRACE(DescribeRow(row));
    EXPECT_EQ(row.audit.violations(), 0);
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
      "--mu 0.1 --steps 30 --nodes 4 --output ";
  const ToolResult one = Run(command + "one");
  EXPECT_EQ(one.exit_code, 0) << one.err;
  EXPECT_NE(one.out.find("\nsdirk2  slope   velocity  > 1e4"), std::string::npos) << one.out;
  EXPECT_NE(one.out.find("\nsdirk2  wind    gap       <= 1e4"), std::string::npos) << one.out;
  EXPECT_NE(one.out.find("\nfailed (1):\n  unconnected, gap, sdirk2, k 1000"), std::string::npos) << one.out;
  EXPECT_NE(one.err.find("6 of 6: "), std::string::npos) << one.err;
  const std::string grid = ReadBytes(folder() / "one" / "stability.csv");
  EXPECT_EQ(grid.rfind("name,contact,integrator,k_stretch,time_step,mu,steps,done,failed_steps,error,", 0), 0u) << grid;
  EXPECT_EQ(std::count(grid.begin(), grid.end(), '\n'), 1 + 4 + 2) << grid;
  EXPECT_EQ(Run(command + "two --threads 2").out, one.out);
  EXPECT_EQ(ReadBytes(folder() / "two" / "stability.csv"), grid);
}

TEST_F(StabilityToolTest, TellsHowAClothStaysOutOfItself) {
  const std::string command = "benchmark stability --settings grid --k_stretch 100 --mu 0.3 --steps 200 --nodes 8 ";
  const ToolResult fold = Run(command + "--scene fold --output fold");
  EXPECT_EQ(fold.exit_code, 0) << fold.err;
  EXPECT_NE(fold.out.find("\nmethod  scene   N/m      cells   steps contacts  repeated"), std::string::npos)
      << fold.out;
  EXPECT_NE(fold.out.find("\nsdirk2  fold    <= 1e4       1      60"), std::string::npos) << fold.out;
  EXPECT_NE(ReadBytes(folder() / "fold" / "stability.csv")
                .find("dependent_steps,intersections,cut_steps,violation_m,push_j\n"),
            std::string::npos);
  EXPECT_EQ(Run(command + "--scene wind").out.find("contacts"), std::string::npos);
}

TEST_F(StabilityToolTest, RefusesWhatItCannotRun) {
  ExpectRefused("benchmark stability --settings gird", 1, "--settings: 'gird'");
  ExpectRefused("benchmark stability --scene sphere", 1, "--scene: 'sphere'");
  ExpectRefused("benchmark stability --integrator both", 1, "--integrator: 'both': expected any of euler, sdirk2");
  ExpectRefused("benchmark stability --contact both", 1, "--contact: 'both'");
  ExpectRefused("benchmark stability --k_stretch 0", 1, "--k_stretch");
  ExpectRefused("benchmark stability --k_stretch soft", 1, "--k_stretch: 'soft'");
  ExpectRefused("benchmark stability --mu -1", 1, "--mu");
  ExpectRefused("benchmark stability --steps 0", 1, "--steps");
  ExpectRefused("benchmark stability --nodes 3", 1, "--nodes");
  ExpectRefused("benchmark stability --threads 0", 1, "--threads");
}

}  // namespace
}  // namespace clothid::stability_test
