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
    options.true_step_divisor = 16;
    return options;
  }
};

// Against the truth on its own grid a model errs by its time step alone, with stages far less; against the finer one
// its grid is left.
TEST_F(DiscretizationTest, ErrorsShrinkWithTheStepAndWithStages) {
  DiscretizationOptions options = Options(8);
  options.nodes = {8};
  options.step_divisors = {1, 2};
  const DiscretizationBenchmark benchmark = RunDiscretizationBenchmark(options);
  EXPECT_DOUBLE_EQ(benchmark.true_time_step, 0.01 / 16);
  ASSERT_EQ(benchmark.fits.size(), 8u);  // by truth, integrator, time step
  for (int i = 0; i < 8; ++i) {
    const DiscretizationFit& fit = benchmark.fits[i];
    SCOPED_TRACE(fit.integrator + ", " + std::to_string(fit.true_nodes[0]) + " nodes, " +
                 std::to_string(fit.time_step) + " s: " + fit.message);
    EXPECT_EQ(fit.true_nodes[0], i < 4 ? 8 : 15);
    EXPECT_EQ(fit.integrator, i % 4 < 2 ? "euler" : "sdirk2");
    EXPECT_EQ(fit.nodes, (std::array<int, 2>{8, 8}));
    EXPECT_DOUBLE_EQ(fit.time_step, 0.01 / (1 << i % 2));
    EXPECT_EQ(fit.status, FitStatus::kConverged);
    for (int k = 0; k < 2; ++k) {
      const double error = std::abs(fit.error[k]);
      EXPECT_NEAR(fit.value[k], benchmark.truth[k].value * (1.0 + fit.error[k]), 1e-9 * fit.value[k]);
      if (i < 4 && i % 2 == 1) {
        EXPECT_LT(error, std::abs(benchmark.fits[i - 1].error[k])) << "twice the step";
      }
      if (i == 2 || i == 3) {
        EXPECT_LT(3.0 * error, std::abs(benchmark.fits[i - 2].error[k])) << "backward Euler";
      }
      if (i >= 6) {
        EXPECT_GT(error, std::abs(benchmark.fits[i - 4].error[k])) << "without the error of the grid";
      }
    }
    EXPECT_GT(fit.rmse, 1e-5);  // another model leaves something unexplained
  }
}

TEST_F(DiscretizationTest, ResultsDoNotDependOnThreads) {
  DiscretizationOptions options = Options(4);
  options.step_divisors = {1, 2};
  options.true_step_divisor = 4;
  options.nodes = {4};
  options.integrators = {"sdirk2"};
  const std::string one = DiscretizationCsv(RunDiscretizationBenchmark(options));
  options.num_threads = 2;
  EXPECT_EQ(DiscretizationCsv(RunDiscretizationBenchmark(options)), one);
}

TEST_F(DiscretizationTest, PrintsATableAndWritesEveryFit) {
  WriteBytes(folder() / "scene.json", SmallDrape(4));
  const ToolResult result =
      Run("benchmark discretization --scene scene.json --set mu=0.24,k_stretch=70 --nodes 4,6 --steps 1 --output out");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.out.rfind("truths: sdirk2, steps of 0.15625 ms, seen at 100 Hz\n", 0), 0u) << result.out;
  EXPECT_NE(result.out.find("6 x 6"), std::string::npos) << result.out;
  const std::string csv = ReadBytes(folder() / "out" / "discretization.csv");
  EXPECT_EQ(csv.rfind("true_nodes_0,true_nodes_1,integrator,nodes_0,nodes_1,time_step,mu,error_mu,k_stretch,error_k_"
                      "stretch,rmse_m,rollouts,status\n",
                      0),
            0u)
      << csv;
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 7) << csv;
}

TEST_F(DiscretizationTest, RefusesWhatItCannotRun) {
  WriteBytes(folder() / "scene.json", SmallDrape(4));
  const std::string set = " --set mu=0.24,k_stretch=70", valid = "benchmark discretization --scene scene.json" + set;
  ExpectRefused("benchmark discretization" + set, 1, "--scene");
  ExpectRefused("benchmark discretization --scene scene.json", 1, "--set");
  ExpectRefused(valid + " --integrator eulr", 1, "--integrator: 'eulr'");
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
