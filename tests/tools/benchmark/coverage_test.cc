// `benchmark coverage`: the 95 % intervals of a fit contain the truth as often as they say, and the reported standard
// deviations are those of the estimates.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/tools/small_drape.h"
#include "tests/tools/tool_test.h"
#include "tools/benchmark/fits/benchmark_coverage.h"

namespace clothid {
namespace {

class CoverageTest : public ToolTest {
 protected:
  // Forty noisy recordings of a small `drape`. The whole one takes ten times as long: `benchmark coverage --seeds 40`.
  void ExpectIntervalsAreRight(const std::string& setting) const {
    CoverageOptions options = SmallOptions(9);
    options.settings = {setting};
    options.num_seeds = 40;
    const CoverageBenchmark benchmark = RunCoverageBenchmark(options);
    ASSERT_EQ(benchmark.fits.size(), 40u);
    for (const CoverageFit& fit : benchmark.fits) {
      EXPECT_EQ(fit.status, FitStatus::kConverged) << "seed " << fit.seed;
    }
    const std::vector<CoverageSummary> summaries = SummarizeCoverage(benchmark);
    ASSERT_EQ(summaries.size(), 2u);
    for (const CoverageSummary& summary : summaries) {
      EXPECT_GE(summary.coverage(), 0.85) << summary.name;
      EXPECT_GE(summary.std_ratio(), 0.75) << summary.name;
      EXPECT_LE(summary.std_ratio(), 1.35) << summary.name;
      // Three standard errors of the mean of forty.
      EXPECT_LE(std::abs(summary.bias), 3.0 * summary.empirical_std / std::sqrt(40.0)) << summary.name;
    }
  }

  CoverageOptions SmallOptions(int n = 6) const {
    WriteBytes(folder() / "scene.json", SmallDrape(n));
    CoverageOptions options;
    options.scene_path = (folder() / "scene.json").string();
    options.truth = {{"mu", 0.24}, {"k_stretch", 70.0}};
    options.num_seeds = 2;
    return options;
  }
};

TEST_F(CoverageTest, EveryPointInEveryFrame) { ExpectIntervalsAreRight("full"); }
TEST_F(CoverageTest, HalfThePointsMissing) { ExpectIntervalsAreRight("half"); }
TEST_F(CoverageTest, AThirdOfTheFrameRate) { ExpectIntervalsAreRight("third"); }

TEST_F(CoverageTest, LessDataAreLessCertain) {
  const std::vector<CoverageSummary> summaries = SummarizeCoverage(RunCoverageBenchmark(SmallOptions()));
  ASSERT_EQ(summaries.size(), 6u);  // full, half, third: mu, k_stretch each
  for (int k = 0; k < 2; ++k) {
    // Standard deviations go with one over the square root of the number of measurements, roughly.
    EXPECT_NEAR(summaries[2 + k].mean_std / summaries[k].mean_std, std::sqrt(2.0), 0.3) << summaries[k].name;
    EXPECT_NEAR(summaries[4 + k].mean_std / summaries[k].mean_std, std::sqrt(3.0), 0.5) << summaries[k].name;
  }
}

TEST_F(CoverageTest, SummarizesWhatTheFitsSay) {
  CoverageBenchmark benchmark;
  benchmark.truth = {{"k_stretch", 10.0, false}};
  const double kNaN = std::nan("");
  const double rows[4][4] = {{9, 1, 7, 11}, {11, 1, 9, 13}, {13, 1, 11, 15}, {11, 3, kNaN, kNaN}};
  for (const auto& [value, std, lower, upper] : rows) {
    CoverageFit fit;
    fit.setting = "full";
    fit.value = {value};
    fit.std = {std};
    fit.lower95 = {lower};
    fit.upper95 = {upper};
    benchmark.fits.push_back(fit);
  }
  const std::vector<CoverageSummary> summaries = SummarizeCoverage(benchmark);
  ASSERT_EQ(summaries.size(), 1u);
  EXPECT_EQ(summaries[0].num_covered, 2);
  EXPECT_DOUBLE_EQ(summaries[0].coverage(), 0.5);
  EXPECT_DOUBLE_EQ(summaries[0].mean_std, 1.5);
  EXPECT_DOUBLE_EQ(summaries[0].empirical_std, std::sqrt(8.0 / 3.0));
  EXPECT_DOUBLE_EQ(summaries[0].bias, 1.0);
}

TEST_F(CoverageTest, ResultsDoNotDependOnThreads) {
  CoverageOptions options = SmallOptions();
  const std::string one = CoverageCsv(RunCoverageBenchmark(options));
  options.num_threads = 2;
  EXPECT_EQ(CoverageCsv(RunCoverageBenchmark(options)), one);
}

TEST_F(CoverageTest, PrintsATableAndWritesEveryFit) {
  WriteBytes(folder() / "scene.json", SmallDrape(6));
  const ToolResult result =
      Run("benchmark coverage --scene scene.json --set mu=0.24,k_stretch=70 --seeds 2 --settings half --output out");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(std::count(result.out.begin(), result.out.end(), '\n'), 3) << result.out;
  const std::string csv = ReadBytes(folder() / "out" / "coverage.csv");
  EXPECT_EQ(csv.rfind("setting,seed,mu,std_mu,lower95_mu,upper95_mu,k_stretch,", 0), 0u) << csv;
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 3) << csv;
}

// A sensor in place of white noise: the clock is fitted, too.
TEST_F(CoverageTest, RecordingsOfASensor) {
  CoverageOptions options = SmallOptions();
  WriteBytes(folder() / "sensor.json",
             R"({"clothid_sensor": 1, "interval": [0.03, 0.03], "noise": [1e-3, 1e-3, 1e-3]})");
  options.sensor_path = (folder() / "sensor.json").string();
  options.settings = {"faults"};
  const CoverageBenchmark benchmark = RunCoverageBenchmark(options);
  ASSERT_EQ(benchmark.truth.size(), 3u);
  EXPECT_EQ(benchmark.truth[2].name, "time_offset");
  for (const CoverageFit& fit : benchmark.fits) {
    EXPECT_EQ(fit.status, FitStatus::kConverged);
    EXPECT_LT(fit.lower95[2], fit.upper95[2]);
  }
  options.num_threads = 2;
  EXPECT_EQ(CoverageCsv(RunCoverageBenchmark(options)), CoverageCsv(benchmark));
}

TEST_F(CoverageTest, RefusesWhatItCannotRun) {
  WriteBytes(folder() / "scene.json", SmallDrape(6));
  const std::string valid = "benchmark coverage --scene scene.json --set mu=0.24,k_stretch=70 ";
  ExpectRefused("benchmark coverage --set mu=0.24", 1, "--scene");
  ExpectRefused("benchmark coverage --scene scene.json", 1, "--set");
  ExpectRefused(valid + "--seeds 1", 1, "--seeds");
  ExpectRefused(valid + "--noise 0", 1, "--noise");
  ExpectRefused(valid + "--settings none", 1, "'none'");
  ExpectRefused(valid + "--threads 0", 1, "--threads");
  ExpectRefused(valid + "--sensor absent.json", 1, "absent.json");
  ExpectRefused(valid + "--sensor absent.json --settings full", 1, "'full'");
}

}  // namespace
}  // namespace clothid
