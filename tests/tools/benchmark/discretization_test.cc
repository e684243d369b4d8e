// `benchmark discretization`: a truth that no fitted model can reproduce is recovered within the discretisation error.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/tools/small_drape.h"
#include "tests/tools/tool_test.h"
#include "tools/benchmark/fits/benchmark_discretization.h"

namespace clothid {
namespace {

class DiscretizationTest : public ToolTest {
 protected:
  DiscretizationOptions Options(int nodes) const {
    WriteBytes(folder() / "scene.json", SmallDrape(nodes));
    DiscretizationOptions options;
    options.scene_path = (folder() / "scene.json").string();
    options.truth = {{"mu", 0.24}, {"k_stretch", 70.0}};
    return options;
  }
};

// The discretisation error of the small drape: relative errors of mu and k_stretch on 8 x 8 and 15 x 15 nodes at 10, 5
// and 2.5 ms against a truth of 15 x 15 nodes at 2.5 ms, rounded up. The last model is the truth itself.
constexpr double kStatedError[6][2] = {{0.17, 0.66}, {0.07, 0.39}, {0.02, 0.23},
                                       {0.14, 0.31}, {0.05, 0.14}, {1e-4, 1e-4}};

TEST_F(DiscretizationTest, ErrorsAreAsStatedAndShrinkWithStepAndMesh) {
  const DiscretizationBenchmark benchmark = RunDiscretizationBenchmark(Options(8));
  EXPECT_EQ(benchmark.true_nodes, (std::array<int, 2>{15, 15}));
  EXPECT_DOUBLE_EQ(benchmark.true_time_step, 0.0025);
  ASSERT_EQ(benchmark.fits.size(), 6u);
  for (int i = 0; i < 6; ++i) {
    const DiscretizationFit& fit = benchmark.fits[i];
    SCOPED_TRACE(std::to_string(fit.nodes[0]) + " nodes, " + std::to_string(fit.time_step) + " s: " + fit.message);
    EXPECT_EQ(fit.nodes[0], i < 3 ? 8 : 15);
    EXPECT_DOUBLE_EQ(fit.time_step, 0.01 / (1 << i % 3));
    EXPECT_EQ(fit.status, FitStatus::kConverged);
    for (int k = 0; k < 2; ++k) {
      EXPECT_NEAR(fit.value[k], benchmark.truth[k].value * (1.0 + fit.error[k]), 1e-9 * fit.value[k]);
      EXPECT_LE(std::abs(fit.error[k]), kStatedError[i][k]) << benchmark.truth[k].name;
      if (i % 3 > 0) {
        EXPECT_LT(std::abs(fit.error[k]), std::abs(benchmark.fits[i - 1].error[k]));  // twice the step
      }
      if (i >= 3) {
        EXPECT_LT(std::abs(fit.error[k]), std::abs(benchmark.fits[i - 3].error[k]));  // half the density
      }
    }
    if (i < 5) {
      EXPECT_GT(fit.rmse, 1e-3);  // another model leaves something unexplained
    }
  }
}

TEST_F(DiscretizationTest, ResultsDoNotDependOnThreads) {
  DiscretizationOptions options = Options(4);
  options.step_divisors = {1, 2};
  const std::string one = DiscretizationCsv(RunDiscretizationBenchmark(options));
  options.num_threads = 2;
  EXPECT_EQ(DiscretizationCsv(RunDiscretizationBenchmark(options)), one);
}

TEST_F(DiscretizationTest, PrintsATableAndWritesEveryFit) {
  WriteBytes(folder() / "scene.json", SmallDrape(4));
  const ToolResult result =
      Run("benchmark discretization --scene scene.json --set mu=0.24,k_stretch=70 --nodes 4,6 --steps 1 --output out");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.out.rfind("truth: 7 x 7 nodes, steps of 2.5 ms, seen at 100 Hz\n", 0), 0u) << result.out;
  EXPECT_NE(result.out.find("6 x 6"), std::string::npos) << result.out;
  const std::string csv = ReadBytes(folder() / "out" / "discretization.csv");
  EXPECT_EQ(csv.rfind("nodes_0,nodes_1,time_step,mu,error_mu,k_stretch,error_k_stretch,rmse_m,rollouts,status\n", 0),
            0u)
      << csv;
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 3) << csv;
}

TEST_F(DiscretizationTest, RefusesWhatItCannotRun) {
  WriteBytes(folder() / "scene.json", SmallDrape(4));
  const std::string set = " --set mu=0.24,k_stretch=70", valid = "benchmark discretization --scene scene.json" + set;
  ExpectRefused("benchmark discretization" + set, 1, "--scene");
  ExpectRefused("benchmark discretization --scene scene.json", 1, "--set");
  ExpectRefused(valid + " --nodes 1", 1, "--nodes");
  ExpectRefused(valid + " --nodes 2000000000", 1, "--nodes: 2000000000");
  ExpectRefused(valid + " --nodes four", 1, "--nodes: 'four'");
  ExpectRefused(valid + " --steps 0", 1, "--steps");
  ExpectRefused(valid + " --steps 1.5", 1, "--steps: '1.5'");
  ExpectRefused(valid + " --threads 0", 1, "--threads");
  nlohmann::ordered_json wide = BareScene();
  wide["mesh"]["grid"]["nodes"] = {4, 6};
  WriteScene(wide, "wide.json");
  ExpectRefused("benchmark discretization --scene wide.json --set k_stretch=70 --nodes 3", 1, "--nodes: 3");
  nlohmann::ordered_json other = BareScene();
  other["mesh"] = {{"obj", "cloth.obj"}};
  other["handles"] = {0};
  WriteBytes(folder() / "cloth.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  WriteScene(other, "other.json");
  ExpectRefused("benchmark discretization --scene other.json --set k_stretch=70", 2, "expected a grid");
}

}  // namespace
}  // namespace clothid
