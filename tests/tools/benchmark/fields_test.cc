// `benchmark fields`: a small one ends where it should, and says what it did.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/tools/small_drape.h"
#include "tests/tools/tool_test.h"
#include "tools/benchmark/fits/benchmark_fields.h"

namespace clothid::fields_test {
namespace {

class FieldsTest : public ToolTest {};

TEST_F(FieldsTest, RecoversWhatIsDetermined) {
  WriteBytes(folder() / "scene.json", SmallDrape(8));
  FieldsOptions options;
  options.scene_path = (folder() / "scene.json").string();
  options.nodes = 8;
  options.sides = {6};
  options.noise = 5e-4;
  options.num_differences = 1;
  const FieldsBenchmark benchmark = RunFieldsBenchmark(options);
  ASSERT_EQ(benchmark.fits.size(), 1u);
  const FieldsFit& fit = benchmark.fits[0];
  EXPECT_TRUE(fit.has_converged);
  EXPECT_GT(fit.determined_share, 0.3);
  EXPECT_LE(fit.determined_error, 0.08);
  EXPECT_LE(fit.rollouts, 20);
}

// The weight of the prior, and so the work, are those of the field, not of the control grid.
TEST_F(FieldsTest, FineControlGridsTakeNoMoreWork) {
  WriteBytes(folder() / "scene.json", SmallDrape(8));
  FieldsOptions options;
  options.scene_path = (folder() / "scene.json").string();
  options.nodes = 8;
  options.sides = {6, 12};
  options.num_differences = 0;
  const FieldsBenchmark benchmark = RunFieldsBenchmark(options);
  ASSERT_EQ(benchmark.fits.size(), 2u);
  for (const FieldsFit& fit : benchmark.fits) {
    EXPECT_TRUE(fit.has_converged) << fit.side;
    EXPECT_LE(fit.determined_error, 0.1) << fit.side;
    EXPECT_LE(fit.rollouts, 16) << fit.side;
    EXPECT_LE(fit.sweeps, 60) << fit.side;
  }
  EXPECT_NEAR(std::log(benchmark.fits[1].weight / benchmark.fits[0].weight), 0.0, std::log(2.0));
  EXPECT_GT(benchmark.fits[1].determined_share, 0.5 * benchmark.fits[0].determined_share);
}

TEST_F(FieldsTest, PrintsATableAndWritesEveryFit) {
  WriteBytes(folder() / "scene.json", SmallDrape(6));
  const ToolResult result =
      Run("benchmark fields --scene scene.json --nodes 6 --settings 2,3 --sigma 0.002 --output out");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  const std::string csv = ReadBytes(folder() / "out" / "fields.csv");
  EXPECT_EQ(csv.rfind("unknowns,converged,weight,", 0), 0u) << csv;
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 3) << csv;
}

TEST_F(FieldsTest, RefusesWhatItCannotRun) {
  WriteBytes(folder() / "scene.json", SmallDrape(4));
  const std::string valid = "benchmark fields --scene scene.json";
  ExpectRefused("benchmark fields", 1, "--scene");
  ExpectRefused(valid + " --set mu=1", 1, "--set");
  ExpectRefused(valid + " --nodes 2", 1, "--nodes");
  ExpectRefused(valid + " --settings 1", 1, "--settings");
  ExpectRefused(valid + " --sigma 0", 1, "--sigma");
}

}  // namespace
}  // namespace clothid::fields_test
