// `benchmark forward`: what it counts, how it puts times together, and what the command refuses. No time is tested.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/tools/tool_test.h"
#include "tools/benchmark/base/timing.h"
#include "tools/benchmark/steps/benchmark_forward.h"

namespace clothid::forward_test {
namespace {

class ForwardTest : public ToolTest {};

TEST_F(ForwardTest, CountsStepsWorkAndMemory) {
  ForwardBenchmarkOptions options;
  options.scenes = {"wind", "slope", "sphere"};
  options.nodes = {6, 9};
  options.num_steps = 4;
  options.repeats = 2;
  int num_rollouts = 0;
  options.on_progress = [&](const std::string&, int num_done, int num_all) {
    EXPECT_EQ(num_done, ++num_rollouts);
    EXPECT_EQ(num_all, 24);
  };
  const ForwardBenchmark benchmark = RunForwardBenchmark(options);
  EXPECT_EQ(num_rollouts, 24);
  ASSERT_EQ(benchmark.cases.size(), 12u);
  EXPECT_GT(benchmark.dgemm_rate, 0.0);
  for (const ForwardCase& result : benchmark.cases) {
    EXPECT_EQ(result.counts.steps, 4);
    EXPECT_EQ(result.counts.failed_steps, 0);
    EXPECT_GT(result.newton_iterations(), 0.0);
    EXPECT_GT(result.seconds, 0.0);
    EXPECT_LE(result.phases.sum(), result.seconds);
    EXPECT_GT(result.factor_flops, result.factor_entries);
    EXPECT_GE(result.bytes, 48.0);  // position and velocity
  }
  EXPECT_EQ(benchmark.cases[0].scene, "wind");
  EXPECT_EQ(benchmark.cases[1].integrator, "sdirk2");
  EXPECT_EQ(benchmark.cases[2].nodes, 9);
  EXPECT_GT(benchmark.cases[6].factor_flops, benchmark.cases[4].factor_flops);
  // Every node of `slope` is in contact, and a step of two stages keeps both.
  EXPECT_GE(benchmark.cases[6].bytes, 48.0 + sizeof(ContactRecord));
  EXPECT_GE(benchmark.cases[7].bytes, 2.0 * (48.0 + sizeof(ContactRecord)));
}

// Until the layers have met.
TEST_F(ForwardTest, AFoldTouchesItselfUnlessItPassesThrough) {
  ForwardBenchmarkOptions options;
  options.scenes = {"fold", "fold_through"};
  options.nodes = {9};
  options.integrators = {"euler"};
  options.num_steps = 135;
  options.repeats = 1;
  const ForwardBenchmark benchmark = RunForwardBenchmark(options);
  ASSERT_EQ(benchmark.cases.size(), 2u);
  for (const ForwardCase& result : benchmark.cases) {
    EXPECT_EQ(result.counts.failed_steps, 0);
    EXPECT_GT(result.counts.contacts, 0);
    EXPECT_EQ(result.counts.self_contacts > 0, result.scene == "fold");
  }
}

TEST_F(ForwardTest, AnIterationDoesNotDependOnHowOftenItFactorises) {
  ForwardCase result;
  result.counts.steps = 10;
  result.counts.newton_iterations = 40;
  result.counts.factorizations = 20;
  result.phases.assembly = 2.0;
  result.phases.factorization = 6.0;
  result.phases.solution = 3.0;
  result.seconds = 12.0;
  EXPECT_DOUBLE_EQ(result.iteration_seconds(), 8.0 / 2.0 + 4.0 / 4.0);
}

TEST_F(ForwardTest, ARolloutThatFailedHasNoTimes) {
  ForwardBenchmark benchmark;
  benchmark.dgemm_rate = 1e10;
  for (const int nodes : {12, 24}) {
    ForwardCase result;
    result.scene = "wind";
    result.nodes = nodes;
    result.integrator = "euler";
    result.counts.failed_steps = 1;
    result.seconds = std::nan("");
    benchmark.cases.push_back(result);
  }
  const std::string table = ForwardTable(benchmark);
  EXPECT_EQ(table.find("nan"), std::string::npos) << table;
  EXPECT_EQ(table.find("inf"), std::string::npos) << table;
}

TEST_F(ForwardTest, ReferenceTimesAreThoseThatWereMeasured) {
  EXPECT_EQ(ReferenceStepSeconds("wind", 48), 0.435);
  EXPECT_EQ(ReferenceStepSeconds("slope", 12), 0.29e-3);
  EXPECT_FALSE(ReferenceStepSeconds("slope", 96).has_value());
  EXPECT_FALSE(ReferenceStepSeconds("sphere", 12).has_value());
}

TEST(TimingTest, MedianAndExponent) {
  EXPECT_EQ(MedianOfRuns({3.0, 1.0, 2.0}), 2.0);
  EXPECT_EQ(MedianOfRuns({4.0, 1.0, 2.0, 3.0}), 2.5);
  EXPECT_NEAR(FitExponent({1.0, 4.0, 9.0}, {2.0, 16.0, 54.0}), 1.5, 1e-14);
}

TEST_F(ForwardTest, PrintsTablesAndWritesEveryCase) {
  const ToolResult result = Run("benchmark forward --scene slope --nodes 4,6 --steps 2 --repeats 1 --output out");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("bytes/node"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("Gflop/s"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("exponent"), std::string::npos) << result.out;
  const std::string csv = ReadBytes(folder() / "out" / "forward.csv");
  EXPECT_EQ(csv.rfind("scene,nodes,integrator,steps,", 0), 0u) << csv;
  EXPECT_NE(csv.find("\nslope,4,euler,2,"), std::string::npos) << csv;
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 5) << csv;
}

TEST_F(ForwardTest, RefusesWhatItCannotRun) {
  ExpectRefused("benchmark forward --scene desert", 1, "'desert'");
  ExpectRefused("benchmark forward --integrator rk4", 1, "--integrator: 'rk4'");
  ExpectRefused("benchmark forward --nodes 1", 1, "--nodes");
  ExpectRefused("benchmark forward --nodes 10000", 1, "--nodes");
  ExpectRefused("benchmark forward --steps 0", 1, "--steps");
  ExpectRefused("benchmark forward --steps 1,2", 1, "--steps");
  ExpectRefused("benchmark forward --repeats 0", 1, "--repeats");
}

}  // namespace
}  // namespace clothid::forward_test
