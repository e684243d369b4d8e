// `benchmark accuracy`: the shape of its curves on small meshes, and what it refuses.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "tests/tools/tool_test.h"
#include "tools/benchmark/accuracy/accuracy_curves.h"
#include "tools/benchmark/accuracy/benchmark_accuracy.h"

namespace clothid::accuracy_test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

AccuracyCase SoftCase(const std::string& scene) { return {scene, FindBackpropSetting("soft")}; }

std::vector<AccuracyPoint> Curve(const std::vector<AccuracyPoint>& points, const std::string& method) {
  std::vector<AccuracyPoint> curve;
  for (const AccuracyPoint& point : points) {
    if (point.method == method) curve.push_back(point);
  }
  return curve;
}

// A curve may rise by `slack` from one point to the next, but not beyond the largest error before it.
void ExpectFalls(const std::vector<AccuracyPoint>& curve, double slack, double least_decades) {
  ASSERT_GE(curve.size(), 2u);
  for (std::size_t i = 1; i < curve.size(); ++i) {
    EXPECT_LE(curve[i].error, slack * curve[i - 1].error) << curve[i].method << " " << curve[i].threshold;
    EXPECT_LE(curve[i].error, curve.front().error) << curve[i].method << " " << curve[i].threshold;
  }
  EXPECT_LE(curve.back().error, curve.front().error * std::pow(10.0, -least_decades)) << curve.front().method;
}

AccuracyPoint MadeUp(const std::string& method, double error, double seconds, const std::string& reference = "direct") {
  AccuracyPoint point;
  point.scene = "wind";
  point.setting = "soft";
  point.quantity = "gradient";
  point.reference = reference;
  point.method = method;
  point.error = error;
  point.seconds = seconds;
  return point;
}

// Backward Euler is of first order: the error against SDIRK2 at h/64 goes with h/d.
TEST(AccuracyForwardTest, EulersErrorsAreOfFirstOrderInTheTimeStep) {
  const std::vector<AccuracyPoint> points = MeasureTimeSteps(SoftCase("wind"), {"euler"}, 9, 1);
  ASSERT_EQ(points.size(), kStepDivisors.size() * (kDivisorTolerances.size() + 1));
  std::vector<AccuracyPoint> tight, loose;
  for (const AccuracyPoint& point : points) {
    if (point.reference != "time_step/64") continue;
    if (point.threshold == kDivisorTolerances.back()) tight.push_back(point);
    if (point.threshold == kDivisorTolerances.front()) loose.push_back(point);
  }
  for (std::size_t i = 1; i < tight.size(); ++i) {
    const double expected = static_cast<double>(kStepDivisors[i]) / kStepDivisors[i - 1];
    EXPECT_NEAR(tight[i - 1].error / tight[i].error, expected, 0.05 * expected) << kStepDivisors[i];
    EXPECT_DOUBLE_EQ(tight[i].time_step, 0.005 / kStepDivisors[i]);
  }
  EXPECT_GT(tight.front().error, 0.01);
  EXPECT_LT(tight.front().error, 0.1);
  EXPECT_GT(loose.back().error, 100.0 * tight.back().error) << "short steps need tight tolerances";
}

// Of second order, and against a finer mesh as large as the error of the mesh.
TEST(AccuracyForwardTest, StagesErrorsAreOfSecondOrderInTheTimeStep) {
  std::vector<double> same_mesh, finest;
  for (const AccuracyPoint& point : MeasureTimeSteps(SoftCase("wind"), {"sdirk2"}, 9, 1)) {
    if (point.threshold != kMeshTolerance) continue;
    (point.reference == "finest/64" ? finest : same_mesh).push_back(point.error);
  }
  ASSERT_EQ(same_mesh.size(), kStepDivisors.size());
  ASSERT_EQ(finest.size(), kStepDivisors.size());
  for (std::size_t i = 1; i < 4; ++i) EXPECT_NEAR(same_mesh[i - 1] / same_mesh[i], 4.0, 0.6) << kStepDivisors[i];
  EXPECT_LT(same_mesh.front(), 0.1 * finest.back());
  EXPECT_NEAR(finest.front(), finest.back(), 0.1 * finest.back());
}

TEST(AccuracyGradientTest, ErrorsFallWithTheThreshold) {
  const std::vector<AccuracyPoint> points = MeasureGradients(SoftCase("sphere"), 9, 1);
  for (const char* method : {"fixed_point", "gmres", "reduced", "kept"}) {
    const std::vector<AccuracyPoint> curve = Curve(points, method);
    ASSERT_EQ(curve.size(), 9u) << method;
    ExpectFalls(curve, 1.0, 4.0);
    for (const AccuracyPoint& point : curve) EXPECT_LE(point.error, 1e3 * point.threshold) << method;
  }
  const std::vector<AccuracyPoint> direct = Curve(points, "umfpack");
  ASSERT_EQ(direct.size(), 1u);
  EXPECT_LE(direct[0].error, 1e-11);
  EXPECT_TRUE(std::isnan(direct[0].threshold));
}

class AccuracyTest : public ToolTest {};

TEST_F(AccuracyTest, AFailedRolloutIsNoNumber) {
  AccuracyBenchmark benchmark;
  benchmark.points = {MadeUp("gmres", 1e-2, 0.004), MadeUp("gmres", kNaN, kNaN)};
  benchmark.points.back().steps_failed = 1;
  const std::string csv = AccuracyCsv(benchmark);
  EXPECT_NE(csv.find("wind,gradient,gmres,nan,nan,nan,1,soft,direct,0,0\n"), std::string::npos) << csv;
  const std::string table = AccuracyTable(benchmark);
  EXPECT_NE(table.find("\nwind   soft      direct       gmres            0.01     4        -     -\n"),
            std::string::npos)
      << table;
}

TEST_F(AccuracyTest, PrintsTablesAndWritesEveryPoint) {
  const ToolResult result =
      Run("benchmark accuracy --scene slope --settings soft --quantities gradient --nodes 9 --repeats 1 --output out");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("over the threshold\n"), std::string::npos) << result.out;
  EXPECT_NE(result.err.find("1 of 1: slope, soft, gradient"), std::string::npos) << result.err;
  const std::string csv = ReadBytes(folder() / "out" / "accuracy.csv");
  EXPECT_EQ(csv.rfind("scene,quantity,method,threshold,error,seconds,steps_failed,setting,reference,nodes,time_step\n"
                      "slope,gradient,umfpack,",
                      0),
            0u)
      << csv;
  EXPECT_NE(csv.find("\nslope,gradient,kept,"), std::string::npos) << csv;
}

TEST_F(AccuracyTest, RefusesWhatItCannotRun) {
  const std::string command = "benchmark accuracy ";
  ExpectRefused(command + "--scene drape", 1, "--scene: 'drape'");
  ExpectRefused(command + "--settings hard", 1, "--settings: 'hard'");
  ExpectRefused(command + "--quantities all", 1, "--quantities: 'all'");
  ExpectRefused(command + "--integrator stages", 1, "--integrator: 'stages'");
  ExpectRefused(command + "--nodes 1", 1, "--nodes");
  ExpectRefused(command + "--nodes 9,17", 1, "--nodes: '9,17'");
  ExpectRefused(command + "--nodes 60001", 1, "--nodes");
  ExpectRefused(command + "--repeats 0", 1, "--repeats");
}

}  // namespace
}  // namespace clothid::accuracy_test
