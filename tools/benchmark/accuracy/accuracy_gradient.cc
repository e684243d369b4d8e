#include "tools/benchmark/accuracy/accuracy_gradient.h"

#include <limits>
#include <utility>

#include "tools/benchmark/accuracy/accuracy_forward.h"
#include "tools/benchmark/base/timing.h"
#include "tools/benchmark/derivatives/backprop_case.h"
#include "tools/benchmark/derivatives/benchmark_thresholds.h"

namespace clothid {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

const std::vector<ThresholdMethod>& GradientMethods() {
  static const std::vector<ThresholdMethod> methods = {
      {"sparse_lu", AdjointMethod::kSparseLu}, {"fixed_point", AdjointMethod::kFixedPoint},
      {"gmres", AdjointMethod::kSystemGmres},  {"reduced", AdjointMethod::kReduced, /*use_kept_factors=*/false},
      {"kept", AdjointMethod::kReduced},
  };
  return methods;
}

AccuracyPoint MeasureSweep(const AccuracyCase& accuracy_case, const ThresholdMethod& method, double threshold,
                           const RolloutGradient& reference, int repeats, BackpropCase* backprop) {
  ThresholdResult result;
  std::vector<double> seconds;
  for (int repeat = 0; repeat < repeats; ++repeat) {
    result = MeasureThreshold(method, threshold, reference, backprop);
    seconds.push_back(result.seconds);
  }
  AccuracyPoint point = accuracy_case.MakePoint("gradient", "direct", method.name, backprop->name().nodes);
  point.threshold = threshold;
  point.error = result.errors.Worst();
  point.seconds = Median(std::move(seconds));
  point.steps_failed = result.failed_solves;
  return point;
}

AccuracyPoint MeasureStepTolerance(const AccuracyCase& accuracy_case, double tolerance,
                                   const RolloutGradient& reference, int repeats, BackpropCase* backprop) {
  AccuracyPoint point =
      accuracy_case.MakePoint("gradient", "tolerance_1e-12", "step_tolerance", backprop->name().nodes);
  point.threshold = tolerance;
  std::vector<double> seconds;
  for (int repeat = 0; repeat < repeats; ++repeat) {
    const double start = ThreadSeconds();
    backprop->SetStepTolerance(tolerance);
    const RolloutGradient gradient = backprop->Differentiate({});
    seconds.push_back(ThreadSeconds() - start);
    point.error = backprop->Compare(gradient, reference).Worst();
    point.steps_failed = gradient.work.failed_solves;
  }
  point.seconds = Median(std::move(seconds));
  return point;
}

}  // namespace

std::vector<AccuracyPoint> MeasureGradients(const AccuracyCase& accuracy_case, int nodes, int repeats) {
  BackpropCase backprop({accuracy_case.scene, accuracy_case.setting.name, nodes, kGradientSteps});
  backprop.SetStepTolerance(kTightTolerance);
  const RolloutGradient reference = backprop.Differentiate({AdjointMethod::kLu});
  std::vector<AccuracyPoint> points;
  for (const ThresholdMethod& method : GradientMethods()) {
    const bool is_direct = method.method == AdjointMethod::kSparseLu;
    for (const double threshold : is_direct ? std::vector<double>{kNaN} : kThresholds) {
      points.push_back(MeasureSweep(accuracy_case, method, threshold, reference, repeats, &backprop));
    }
  }
  for (const double tolerance : kStepTolerances) {
    points.push_back(MeasureStepTolerance(accuracy_case, tolerance, reference, repeats, &backprop));
  }
  return points;
}

}  // namespace clothid
