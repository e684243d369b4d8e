// `benchmark`: fits from a grid of starts recover the truth with exact Jacobians, and what the command refuses.
#include <gtest/gtest.h>

#include <cmath>
#include <regex>
#include <sstream>
#include <string>

#include "tests/tools/small_drape.h"
#include "tests/tools/tool_test.h"
#include "tools/benchmark/derivatives/benchmark_jacobian.h"

namespace clothid::benchmark_test {
namespace {

class BenchmarkTest : public ToolTest {
 protected:
  BenchmarkTest() { WriteBytes(folder() / "scene.json", SmallDrape(6)); }

  JacobianBenchmarkOptions SmallOptions() const {
    JacobianBenchmarkOptions options;
    options.scene_path = (folder() / "scene.json").string();
    options.truth = {{"mu", 0.24}, {"k_stretch", 70.0}};
    options.noise = 0.0;
    options.starts_per_axis = 2;
    options.methods = {"adjoint", "sensitivity"};
    return options;
  }
};

TEST_F(BenchmarkTest, EveryStartReachesTheTruth) {
  const JacobianBenchmark benchmark = RunJacobianBenchmark(SmallOptions());
  EXPECT_EQ(benchmark.names[0], "mu");
  EXPECT_EQ(benchmark.names[1], "k_stretch");
  ASSERT_EQ(benchmark.fits.size(), 8u);
  for (const JacobianFit& fit : benchmark.fits) {
    EXPECT_TRUE(fit.reached) << fit.method << " from " << fit.start[0] << " " << fit.start[1] << " ended at "
                             << fit.value[0] << " " << fit.value[1] << ": " << fit.message;
    EXPECT_NEAR(fit.value[0], 0.24, 0.24 * kTruthTolerance);
    EXPECT_NEAR(fit.value[1], 70.0, 70.0 * kTruthTolerance);
    EXPECT_EQ(fit.status, FitStatus::kConverged) << fit.message;
    EXPECT_EQ(fit.failed_steps, 0);
  }
}

TEST_F(BenchmarkTest, TheGridSpansTheRangeAndMethodsTakeTurns) {
  const JacobianBenchmark benchmark = RunJacobianBenchmark(SmallOptions());
  const double mu[] = {0.02, 0.02, 0.58, 0.58}, stiffness[] = {7.0, 700.0, 7.0, 700.0};
  for (std::size_t i = 0; i < benchmark.fits.size(); ++i) {
    EXPECT_DOUBLE_EQ(benchmark.fits[i].start[0], mu[i / 2]);
    EXPECT_DOUBLE_EQ(benchmark.fits[i].start[1], stiffness[i / 2]);
    EXPECT_EQ(benchmark.fits[i].method, i % 2 == 0 ? "adjoint" : "sensitivity");
  }
}

// All but the seconds, which come last in a row.
std::string WithoutSeconds(const std::string& csv) {
  std::istringstream rows(csv);
  std::string result;
  for (std::string row; std::getline(rows, row);) result += row.substr(0, row.rfind(',')) + "\n";
  return result;
}

TEST_F(BenchmarkTest, ResultsDoNotDependOnThreads) {
  JacobianBenchmarkOptions options = SmallOptions();
  const std::string one = WithoutSeconds(JacobianCsv(RunJacobianBenchmark(options)));
  options.num_threads = 2;
  EXPECT_EQ(WithoutSeconds(JacobianCsv(RunJacobianBenchmark(options))), one);
}

// Noise moves the minimum off the truth; all fits agree on where it is.
TEST_F(BenchmarkTest, EveryStartReachesTheSameMinimumUnderNoise) {
  JacobianBenchmarkOptions options = SmallOptions();
  options.noise = 0.01;
  const JacobianBenchmark benchmark = RunJacobianBenchmark(options);
  ASSERT_EQ(benchmark.fits.size(), 16u);
  for (std::size_t i = 8; i < benchmark.fits.size(); ++i) {
    const JacobianFit& fit = benchmark.fits[i];
    EXPECT_EQ(fit.noise, 0.01);
    EXPECT_TRUE(fit.reached) << fit.method << " from " << fit.start[0] << " " << fit.start[1] << " ended at "
                             << fit.value[0] << " " << fit.value[1] << " with cost " << fit.cost << ": " << fit.message;
    EXPECT_GT(std::abs(fit.value[0] - 0.24), 0.24 * kTruthTolerance);
  }
}

// Gradients with errors of up to some per cent still lead to the minimum.
TEST_F(BenchmarkTest, OtherLinearSolversOfTheSweepReachTheTruthToo) {
  JacobianBenchmarkOptions options = SmallOptions();
  options.methods = {"adjoint:gmres:1e-2", "adjoint:lu"};
  const JacobianBenchmark benchmark = RunJacobianBenchmark(options);
  ASSERT_EQ(benchmark.fits.size(), 8u);
  for (const JacobianFit& fit : benchmark.fits) {
    EXPECT_TRUE(fit.reached) << fit.method << " from " << fit.start[0] << " " << fit.start[1] << " ended at "
                             << fit.value[0] << " " << fit.value[1] << ": " << fit.message;
  }
}

TEST_F(BenchmarkTest, PrintsATableAndWritesEveryFit) {
  const ToolResult result =
      Run("benchmark jacobian --scene scene.json --set mu=0.24,k_stretch=70 --noise 0 --starts 2 --methods sensitivity "
          "--output out");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("4 of 4"), std::string::npos) << result.out;
  const std::string csv = ReadBytes(folder() / "out" / "jacobian.csv");
  EXPECT_EQ(csv.rfind("start_mu,start_k_stretch,method,noise,mu,k_stretch,cost,", 0), 0u) << csv;
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 5) << csv;
}

// What a command does not take would be ignored, and whoever gave it would not know.
TEST_F(BenchmarkTest, RefusesFlagsOfOtherCommands) {
  ExpectRefused("benchmark forward --seeds 30", 1, "--seeds: is a flag of coverage, not of forward");
  ExpectRefused("benchmark forward --seeds 40", 1, "--seeds: is a flag of coverage");  // also where it is the default
  ExpectRefused("benchmark coverage --precision full --threads 2", 1,
                "--precision: is a flag of jacobian, not of coverage");
  ExpectRefused("benchmark backprop --threads 2", 1, "--threads: is a flag of jacobian, coverage and stability");
  ExpectRefused("benchmark accuracy --mu 1", 1, "--mu: is a flag of stability, not of accuracy");
  for (const char* command : {"jacobian", "coverage", "fields", "forward", "backprop", "stability"}) {
    ExpectRefused(std::string("benchmark ") + command + " --quantities forward", 1,
                  std::string("--quantities: is a flag of accuracy, not of ") + command);
  }
}

// Nothing runs, because results cannot be written there.
TEST_F(BenchmarkTest, TakesTheFlagsOfItsHelp) {
  int num_flags = 0;
  for (const std::string command : {"jacobian", "coverage", "fields", "forward", "backprop", "accuracy", "stability"}) {
    const std::string help = Run("benchmark " + command + " --help").out;
    const std::size_t begin = help.find("benchmark " + command + ": ");
    ASSERT_NE(begin, std::string::npos) << command;
    const std::string own = help.substr(begin, help.find("\nbenchmark ", begin) - begin);
    const std::regex flag(R"((?:\n  |; |, )--(\w+) )");
    for (std::sregex_iterator it(own.begin(), own.end(), flag), end; it != end; ++it) {
      const std::string name = (*it)[1];
      if (name == "output") continue;
      const ToolResult result = Run("benchmark " + command + " --" + name + " 1 --output /proc/absent");
      EXPECT_EQ(result.exit_code, 1);
      EXPECT_EQ(result.err.find("is a flag of"), std::string::npos) << command << " --" << name << "\n" << result.err;
      ++num_flags;
    }
  }
  EXPECT_GT(num_flags, 45);
}

TEST_F(BenchmarkTest, RefusesWhatItCannotRun) {
  const std::string valid = "benchmark jacobian --scene scene.json --set mu=0.24,k_stretch=70 ";
  ExpectRefused("benchmark", 1, "there is: jacobian");
  ExpectRefused("benchmark juggle", 1, "'juggle': unknown command; there is: jacobian");
  ExpectRefused("benchmark jacobian forward", 1, "'forward'");
  ExpectRefused("benchmark jacobian --set mu=0.24,k_stretch=70", 1, "--scene");
  ExpectRefused("benchmark jacobian --scene missing.json --set mu=0.24,k_stretch=70", 1, "missing.json");
  ExpectRefused("benchmark jacobian --scene scene.json --set mu=0.24", 1, "--set");
  ExpectRefused("benchmark jacobian --scene scene.json --set mu=0.24,k_stretch=-1", 1, "'k_stretch'");
  ExpectRefused("benchmark jacobian --scene scene.json --set mu=0.24,colour=1", 1, "colour");
  ExpectRefused(valid + "--starts 3", 1, "--starts");
  ExpectRefused(valid + "--noise -1", 1, "--noise");
  ExpectRefused(valid + "--methods guess", 1, "'guess'");
  ExpectRefused(valid + "--methods adjoint:guess", 1, "'adjoint:guess'");
  ExpectRefused(valid + "--methods adjoint:", 1, "'adjoint:'");
  ExpectRefused(valid + "--methods numeric:lu", 1, "'numeric:lu'");
  ExpectRefused(valid + "--threads 0", 1, "--threads");
  ExpectRefused(valid + "--output scene.json", 1, "scene.json");
}

}  // namespace
}  // namespace clothid::benchmark_test
