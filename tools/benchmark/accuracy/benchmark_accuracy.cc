#include "tools/benchmark/accuracy/benchmark_accuracy.h"

#include "sim/mesh/mesh.h"

namespace clothid {
namespace {

// A line per curve, of the points of one quantity: error times `unit`, and ms.
std::string CurveLines(const AccuracyBenchmark& benchmark, const std::string& quantity, double unit) {
  std::string lines, last;
  for (const AccuracyPoint& point : benchmark.points) {
    if (point.quantity != quantity || (quantity == "forward" && point.threshold != kMeshTolerance)) continue;
    const std::string curve = Format("%-7s%-10s%-13s%-12s", point.scene.c_str(), point.setting.c_str(),
                                     point.reference.c_str(), point.method.c_str());
    if (curve != last) lines += (last.empty() ? "" : "\n") + curve;
    last = curve;
    lines +=
        Format("%9s%6s", GeneralNumber(unit * point.error, 2).c_str(), GeneralNumber(1e3 * point.seconds, 3).c_str());
  }
  return lines.empty() ? "" : lines + "\n";
}

}  // namespace

void AccuracyOptions::Validate() const {
  RequireKnown(scenes, kBenchmarkScenes, "--scene");
  RequireKnown(settings, BackpropSettingNames(), "--settings");
  RequireKnown(integrators, kIntegratorNames, "--integrator");
  RequireKnown(quantities, kAccuracyQuantities, "--quantities");
  ExpectUsage(nodes >= 2 && nodes <= kMaxNodes / nodes / 4, "--nodes: expected one number >= 2, not too large");
  ExpectUsage(repeats >= 1, "--repeats: expected a number >= 1");
}

AccuracyBenchmark RunAccuracyBenchmark(const AccuracyOptions& options) {
  options.Validate();
  AccuracyBenchmark benchmark;
  const int num_items = static_cast<int>(options.scenes.size() * options.settings.size() * options.quantities.size());
  int num_done = 0;
  for (const std::string& scene : options.scenes) {
    for (const std::string& setting : options.settings) {
      const AccuracyCase accuracy_case{scene, FindBackpropSetting(setting)};
      for (const std::string& quantity : options.quantities) {
        const std::vector<AccuracyPoint> points =
            quantity == "forward" ? MeasureTimeSteps(accuracy_case, options.integrators, options.nodes, options.repeats)
                                  : MeasureGradients(accuracy_case, options.nodes, options.repeats);
        benchmark.points.insert(benchmark.points.end(), points.begin(), points.end());
        if (options.on_progress) options.on_progress(scene + ", " + setting + ", " + quantity, ++num_done, num_items);
      }
    }
  }
  return benchmark;
}

std::string AccuracyTable(const AccuracyBenchmark& benchmark) {
  const std::string title = "scene  setting   against      method      ";
  std::string forward = "error, % of the motion, and ms of a rollout, over the time step\n" + title;
  for (const int divisor : kStepDivisors) {
    forward += Format("%15s", divisor == 1 ? "h" : ("h/" + std::to_string(divisor)).c_str());
  }
  std::string gradient = "error of the gradient, and ms of the sweep, over the threshold\n" + title;
  for (const double threshold : kGradientThresholds) gradient += Format("%15g", threshold);
  const std::string of_forward = CurveLines(benchmark, "forward", 100.0),
                    of_gradient = CurveLines(benchmark, "gradient", 1.0);
  return (of_forward.empty() ? "" : forward + "\n" + of_forward) +
         (of_gradient.empty() ? "" : gradient + "\n" + of_gradient);
}

std::string AccuracyCsv(const AccuracyBenchmark& benchmark) {
  std::string csv = "scene,quantity,method,threshold,error,seconds,steps_failed,setting,reference,nodes,time_step\n";
  for (const AccuracyPoint& point : benchmark.points) {
    csv += CsvLine(point.scene, point.quantity, point.method, point.threshold, point.error, point.seconds,
                   point.steps_failed, point.setting, point.reference, point.nodes, point.time_step);
  }
  return csv;
}

}  // namespace clothid
