// `benchmark accuracy`: the shape of its curves on small meshes, which points it prefers, and what it refuses.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "costs/prediction/rollout_cost_options.h"
#include "tests/tools/tool_test.h"
#include "tools/benchmark/accuracy/accuracy_fit.h"
#include "tools/benchmark/accuracy/accuracy_forward.h"
#include "tools/benchmark/accuracy/accuracy_gradient.h"
#include "tools/benchmark/accuracy/benchmark_accuracy.h"

namespace clothid {
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

TEST(AccuracyPointTest, TheParetoFrontHasWhatNoComparablePointBeats) {
  const std::vector<AccuracyPoint> points = {
      MadeUp("slow_and_exact", 1e-9, 8.0),
      MadeUp("beaten_in_both", 1e-4, 9.0),
      MadeUp("middle", 1e-4, 2.0),
      MadeUp("as_exact_but_slower", 1e-4, 3.0),
      MadeUp("as_fast_but_rougher", 1e-3, 2.0),
      MadeUp("fast", 1e-1, 1.0),
      MadeUp("the_same_again", 1e-1, 1.0),
      MadeUp("failed", kNaN, 0.1),
      MadeUp("of_another_reference", 0.5, 20.0, "tolerance_1e-12"),
  };
  EXPECT_EQ(ParetoFront(points), (std::vector<bool>{true, false, true, false, false, true, false, false, true}));
  EXPECT_TRUE(ParetoFront({}).empty());

  EXPECT_EQ(FindCheapest(points, 1e-4)->method, "middle");
  EXPECT_EQ(FindCheapest(points, 1e-5)->method, "slow_and_exact");
  EXPECT_EQ(FindCheapest(points, 0.2)->method, "fast");
  EXPECT_EQ(FindCheapest(points, 1e-10), nullptr);
}

TEST(AccuracyForwardTest, ErrorsFallWithTheStepTolerance) {
  for (const char* scene : {"wind", "slope", "sphere"}) {
    const std::vector<AccuracyPoint> curve = MeasureStepTolerances(SoftCase(scene), 9, 1);
    ASSERT_EQ(curve.size(), kStepTolerances.size());
    ExpectFalls(curve, 2.0, 6.0);
    for (const AccuracyPoint& point : curve) {
      EXPECT_LE(point.error, 20.0 * point.threshold) << scene;
      EXPECT_EQ(point.steps_failed, 0);
    }
  }
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

TEST(AccuracyForwardTest, ErrorsFallWithTheMesh) {
  const std::vector<AccuracyPoint> curve = MeasureMeshes(SoftCase("slope"), 9, 1);
  ASSERT_EQ(curve.size(), 3u);
  EXPECT_EQ(curve[0].nodes, 3);
  EXPECT_EQ(curve[1].nodes, 5);
  EXPECT_EQ(curve[2].nodes, 9);
  ExpectFalls(curve, 0.5, 1.0);
}

TEST(AccuracyGradientTest, ErrorsFallWithThresholdAndTolerance) {
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
  ExpectFalls(Curve(points, "step_tolerance"), 2.0, 6.0);
}

TEST(AccuracyFitTest, EveryMethodEndsAtTheTruth) {
  for (const char* scene : {"wind", "sphere"}) {
    const std::vector<AccuracyPoint> points = MeasureFits(SoftCase(scene), 9, 2);
    for (const char* method : {"adjoint", "sensitivity", "numeric"}) {
      const std::vector<AccuracyPoint> curve = Curve(points, method);
      ASSERT_GE(curve.size(), 3u) << method;
      EXPECT_NEAR(curve.front().error, 2.0, 1e-9) << scene << " " << method << ": starts at 3 times the stiffness";
      EXPECT_LE(curve.back().error, 1e-4) << scene << " " << method;
      for (std::size_t i = 1; i < curve.size(); ++i) EXPECT_GT(curve[i].iteration, curve[i - 1].iteration) << method;
    }
    EXPECT_EQ(Curve(points, "adjoint").front().threshold, kLooseStepTolerance);
    EXPECT_EQ(Curve(points, "numeric").front().threshold, 1e-8);
  }
}

class AccuracyTest : public ToolTest {};

TEST_F(AccuracyTest, AFailedRolloutIsNoNumber) {
  AccuracyBenchmark benchmark;
  benchmark.points = {MadeUp("gmres", 1e-2, 0.004), MadeUp("gmres", kNaN, kNaN)};
  benchmark.points.back().steps_failed = 1;
  const std::string csv = AccuracyCsv(benchmark);
  EXPECT_NE(csv.find("wind,gradient,gmres,nan,nan,nan,1,soft,direct,0,0,0,0\n"), std::string::npos) << csv;
  const std::string table = AccuracyTable(benchmark);
  char scene[8], setting[8], quantity[12], method[8], reference[8];
  int num_points = 0, num_failed = 0;
  double first = 0.0, last = 0.0;
  const std::string row = table.substr(table.find("wind "));
  ASSERT_EQ(std::sscanf(row.c_str(), "%7s %7s %11s %7s %7s %d %d %lf %lf", scene, setting, quantity, method, reference,
                        &num_points, &num_failed, &first, &last),
            9)
      << table;
  EXPECT_EQ(num_points, 2);
  EXPECT_EQ(num_failed, 1);
  EXPECT_EQ(first, 0.01);
  EXPECT_EQ(last, 0.01);
  EXPECT_NE(table.find("gmres  4"), std::string::npos) << table;
}

TEST_F(AccuracyTest, PrintsTablesAndWritesEveryPoint) {
  const ToolResult result =
      Run("benchmark accuracy --scene slope --settings soft --quantities fit --nodes 9 --repeats 1 --output out");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("cheapest with an error"), std::string::npos) << result.out;
  EXPECT_NE(result.err.find("part 1 of 1: slope, soft, fit"), std::string::npos) << result.err;
  const std::string csv = ReadBytes(folder() / "out" / "curve.csv");
  EXPECT_EQ(csv.rfind("scene,quantity,method,threshold,error,seconds,steps_failed,setting,reference,nodes,time_step,"
                      "iteration,pareto\nslope,fit,adjoint,",
                      0),
            0u)
      << csv;
  EXPECT_NE(csv.find("\nslope,fit,numeric,"), std::string::npos) << csv;
}

TEST_F(AccuracyTest, RefusesWhatItCannotRun) {
  const std::string command = "benchmark accuracy ";
  ExpectRefused(command + "--scene drape", 1, "--scene: 'drape'");
  ExpectRefused(command + "--settings hard", 1, "--settings: 'hard'");
  ExpectRefused(command + "--quantities all", 1, "--quantities: 'all'");
  ExpectRefused(command + "--integrator stages", 1, "--integrator: 'stages'");
  ExpectRefused(command + "--nodes 12", 1, "--nodes");
  ExpectRefused(command + "--nodes 1", 1, "--nodes");
  ExpectRefused(command + "--nodes 9,17", 1, "--nodes: '9,17'");
  ExpectRefused(command + "--nodes 60001", 1, "--nodes");
  ExpectRefused(command + "--repeats 0", 1, "--repeats");
}

}  // namespace
}  // namespace clothid
