#include "tools/benchmark/accuracy/accuracy_gradient.h"

#include <limits>
#include <utility>

#include "tools/benchmark/accuracy/accuracy_forward.h"
#include "tools/benchmark/base/timing.h"
#include "tools/benchmark/derivatives/backprop_case.h"

namespace clothid {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

struct GradientMethod {
  const char* name;
  AdjointMethod method;
  bool use_kept_factors = true;  // see AdjointOptions
};

constexpr GradientMethod kGradientMethods[] = {
    {"umfpack", AdjointMethod::kLu},        {"fixed_point", AdjointMethod::kFixedPoint},
    {"gmres", AdjointMethod::kSystemGmres}, {"reduced", AdjointMethod::kReduced, /*use_kept_factors=*/false},
    {"kept", AdjointMethod::kReduced},
};

AccuracyPoint MeasureSweep(const AccuracyCase& accuracy_case, const GradientMethod& method, double threshold,
                           const RolloutGradient& reference, int repeats, BackpropCase* backprop) {
  AccuracyPoint point = accuracy_case.MakePoint("gradient", "direct", method.name, backprop->name().nodes);
  point.threshold = threshold;
  std::vector<double> seconds;
  for (int repeat = 0; repeat < repeats; ++repeat) {
    const double start = ThreadSeconds();
    const RolloutGradient gradient = backprop->Differentiate({method.method, threshold, method.use_kept_factors});
    seconds.push_back(ThreadSeconds() - start);
    point.error = backprop->Compare(gradient, reference).Worst();
    point.steps_failed = gradient.work.failed_solves;
  }
  point.seconds = Median(std::move(seconds));
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
  for (const GradientMethod& method : kGradientMethods) {
    const bool is_direct = method.method == AdjointMethod::kLu;
    for (const double threshold : is_direct ? std::vector<double>{kNaN} : kGradientThresholds) {
      points.push_back(MeasureSweep(accuracy_case, method, threshold, reference, repeats, &backprop));
    }
  }
  for (const double tolerance : kStepTolerances) {
    points.push_back(MeasureStepTolerance(accuracy_case, tolerance, reference, repeats, &backprop));
  }
  return points;
}

}  // namespace clothid
