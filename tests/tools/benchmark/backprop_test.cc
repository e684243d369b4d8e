// `benchmark backprop`: what it measures on small meshes, and what it refuses.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/tools/tool_test.h"
#include "tools/benchmark/derivatives/benchmark_backprop.h"

namespace clothid::backprop_test {
namespace {

BackpropCaseOptions SmallCases(const std::string& scene, const std::string& setting) {
  BackpropCaseOptions options;
  options.scenes = {scene};
  options.settings = {setting};
  options.nodes = {8};
  options.num_steps = 5;
  return options;
}

class BackpropTest : public ToolTest {};

TEST_F(BackpropTest, EveryMethodIsMeasuredOnEveryCase) {
  BackpropOptions options;
  options.cases = SmallCases("slope", "soft");
  options.cases.scenes = {"wind", "slope"};
  options.num_repeats = 2;
  const BackpropBenchmark benchmark = RunBackpropBenchmark(options);
  ASSERT_EQ(benchmark.results.size(), 2 * BackpropMethods().size());
  for (std::size_t i = 0; i < benchmark.results.size(); ++i) {
    const BackpropResult& result = benchmark.results[i];
    const BackpropMethod& method = BackpropMethods()[i % BackpropMethods().size()];
    EXPECT_EQ(result.method, method.name);
    EXPECT_EQ(result.name.scene, i < BackpropMethods().size() ? "wind" : "slope");
    EXPECT_EQ(result.samples.size(), 2u);
    EXPECT_EQ(result.rollout_seconds.size(), 2u);
    EXPECT_EQ(result.block_seconds.size(), method.with_block ? 2u : 0u);
    EXPECT_EQ(result.failed_share, 0.0) << result.method;
    EXPECT_LE(result.gradient_error, 1e3 * method.options.threshold.value_or(1e-12)) << result.method;
    for (const BackpropSample& sample : result.samples) EXPECT_GE(sample.other(), 0.0) << result.method;
  }
}

TEST_F(BackpropTest, FailedStepsAreCounted) {
  BackpropOptions options;
  options.cases = SmallCases("wind", "realistic");
  options.cases.nodes = {12};
  options.methods = {"fixed_point:1e-6"};
  options.num_repeats = 1;
  const BackpropBenchmark benchmark = RunBackpropBenchmark(options);
  ASSERT_EQ(benchmark.results.size(), 1u);
  EXPECT_EQ(benchmark.results[0].failed_share, 1.0);
  EXPECT_EQ(benchmark.results[0].iterations, 400.0);
  EXPECT_GT(benchmark.results[0].samples[0].fallback, 0.0);
}

TEST_F(BackpropTest, TheTableGivesMediansAndRatiosWithinARepetition) {
  BackpropBenchmark benchmark;
  BackpropResult result;
  result.name = {"wind", "soft", 12, 10};
  result.method = kReferenceDirect;
  result.samples = {{0.40, 0.30, 0.04, 0.02, 0.0}, {0.60, 0.50, 0.04, 0.02, 0.0}, {4.0, 3.0, 0.4, 0.2, 0.0}};
  result.rollout_seconds = {0.8, 1.2, 8.0};
  benchmark.results.push_back(result);
  result.method = "fixed_point:1e-4";
  result.iterations = 7.25;
  result.failed_share = 0.5;
  result.samples = {{0.10, 0.06, 0.01, 0.01, 0.02}, {0.15, 0.08, 0.01, 0.01, 0.05}, {1.0, 0.6, 0.1, 0.1, 0.2}};
  result.block_seconds = {0.15, 0.30, 1.5};
  benchmark.results.push_back(result);
  const std::string table = BackpropTable(benchmark);
  const std::string row = table.substr(table.find("fixed_point"));
  double total, linear, assembly, contact, other, iterations, failed, fallback, error, umfpack, block, rollout;
  ASSERT_EQ(
      std::sscanf(row.c_str(), "fixed_point:1e-4 %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf", &total, &linear,
                  &assembly, &contact, &other, &iterations, &failed, &fallback, &error, &umfpack, &block, &rollout),
      12)
      << table;
  EXPECT_EQ(total, 15.0);
  EXPECT_EQ(linear, 8.0);
  EXPECT_EQ(assembly, 1.0);
  EXPECT_EQ(contact, 1.0);
  EXPECT_EQ(other, 5.0);
  EXPECT_NEAR(iterations, 7.25, 0.051);
  EXPECT_EQ(failed, 50.0);
  EXPECT_EQ(fallback, 25.0);
  EXPECT_EQ(umfpack, 4.0);
  EXPECT_EQ(block, 1.5);
  EXPECT_NEAR(rollout, 0.125, 0.006);
}

TEST_F(BackpropTest, AParameterWithoutInfluenceHasNoError) {
  // Sliding without strain, neither stiffness nor density matter; without an obstacle there is no friction.
  BackpropCase slope({"slope", "soft", 8, 5}), wind({"wind", "soft", 8, 5});
  const RolloutGradient of_slope = slope.Differentiate({AdjointMethod::kLu});
  EXPECT_TRUE(std::isnan(slope.Compare(of_slope, of_slope).k_stretch));
  EXPECT_TRUE(std::isnan(slope.Compare(of_slope, of_slope).density));
  EXPECT_EQ(slope.Compare(of_slope, of_slope).mu, 0.0);
  const RolloutGradient of_wind = wind.Differentiate({AdjointMethod::kLu});
  EXPECT_EQ(wind.Compare(of_wind, of_wind).k_stretch, 0.0);
  EXPECT_TRUE(std::isnan(wind.Compare(of_wind, of_wind).mu));
  EXPECT_EQ(wind.Compare(of_wind, of_wind).Worst(), 0.0);
}

TEST_F(BackpropTest, PrintTablesAndWriteCsv) {
  const std::string cases = "--scene sphere --settings soft --nodes 6 --steps 3 ";
  const ToolResult result = Run("benchmark backprop --methods umfpack,reduced --repeats 2 " + cases + "--output out");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(std::count(result.out.begin(), result.out.end(), '\n'), 4) << result.out;
  EXPECT_NE(result.err.find("1 of 1: sphere, soft, 6 x 6 nodes"), std::string::npos) << result.err;
  const std::string backprop = ReadBytes(folder() / "out" / "backprop.csv");
  EXPECT_EQ(backprop.rfind("scene,setting,nodes,steps,method,repeat,", 0), 0u) << backprop;
  EXPECT_EQ(std::count(backprop.begin(), backprop.end(), '\n'), 5) << backprop;
}

TEST_F(BackpropTest, RefusesWhatItCannotRun) {
  const std::string command = "benchmark backprop ";
  ExpectRefused(command + "--scene drape", 1, "--scene: 'drape'");
  ExpectRefused(command + "--settings hard", 1, "--settings: 'hard'");
  ExpectRefused(command + "--nodes 1", 1, "--nodes");
  ExpectRefused(command + "--nodes many", 1, "--nodes");
  ExpectRefused(command + "--steps 0", 1, "--steps");
  ExpectRefused(command + "--steps 1,2", 1, "--steps");
  ExpectRefused(command + "--methods numeric", 1, "--methods: 'numeric'");
  ExpectRefused(command + "--repeats 0", 1, "--repeats");
}

}  // namespace
}  // namespace clothid::backprop_test
