#include "tools/benchmark/derivatives/benchmark_thresholds.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <limits>
#include <sstream>

#include "tools/benchmark/base/timing.h"

namespace clothid {
namespace {

std::string Scientific(double value) {
  if (std::isnan(value)) return "-";
  std::ostringstream text;
  text << std::scientific << std::setprecision(1) << value;
  return text.str();
}

}  // namespace

void ThresholdOptions::Validate() const {
  cases.Validate();
  std::vector<std::string> known;
  for (const ThresholdMethod& method : kThresholdMethods) known.push_back(method.name);
  if (!methods.empty()) RequireKnown(methods, known, "--methods");
}

ThresholdResult MeasureThreshold(const ThresholdMethod& method, double threshold, const RolloutGradient& reference,
                                 BackpropCase* backprop) {
  const double start = ThreadSeconds();
  const RolloutGradient gradient = backprop->Differentiate({method.method, threshold, method.use_kept_factors});
  ThresholdResult result;
  result.seconds = ThreadSeconds() - start;
  result.name = backprop->name();
  result.method = method.name;
  result.threshold = threshold;
  result.errors = backprop->Compare(gradient, reference);
  result.iterations = static_cast<double>(gradient.work.iterations) / gradient.work.solves;
  result.failed_solves = gradient.work.failed_solves;
  result.failed_share = static_cast<double>(gradient.work.failed_solves) / gradient.work.solves;
  return result;
}

ThresholdBenchmark RunThresholdBenchmark(const ThresholdOptions& options) {
  options.Validate();
  ThresholdBenchmark benchmark;
  ForEachCase(options.cases, [&](BackpropCase* backprop) {
    const RolloutGradient reference = backprop->Differentiate({AdjointMethod::kLu});
    for (const ThresholdMethod& method : kThresholdMethods) {
      const std::vector<std::string>& wanted = options.methods;
      if (!wanted.empty() && std::find(wanted.begin(), wanted.end(), method.name) == wanted.end()) continue;
      for (const double threshold : kThresholds) {
        benchmark.results.push_back(MeasureThreshold(method, threshold, reference, backprop));
      }
    }
  });
  return benchmark;
}

std::string ThresholdTable(const ThresholdBenchmark& benchmark) {
  std::ostringstream out;
  out << "                                                      relative error                           failed      "
         "ms\n"
         "scene  setting   nodes  method       threshold  k_stretch   density        mu       x_0   iter.       %  "
         "/ step\n";
  for (const ThresholdResult& result : benchmark.results) {
    const GradientErrors& errors = result.errors;
    out << std::left << std::setw(7) << result.name.scene << std::setw(10) << result.name.setting << std::right
        << std::setw(5) << result.name.nodes << "  " << std::left << std::setw(13) << result.method << std::right
        << std::setw(9) << Scientific(result.threshold) << std::setw(11) << Scientific(errors.k_stretch)
        << std::setw(10) << Scientific(errors.density) << std::setw(10) << Scientific(errors.mu) << std::setw(10)
        << Scientific(errors.x_0) << std::setw(8) << FixedNumber(result.iterations, 1) << std::setw(8)
        << FixedNumber(100.0 * result.failed_share, 1) << std::setw(8)
        << FixedNumber(1e3 * result.seconds / result.name.num_steps, 2) << "\n";
  }
  return out.str();
}

std::string ThresholdCsv(const ThresholdBenchmark& benchmark) {
  std::ostringstream out;
  out << std::setprecision(std::numeric_limits<double>::max_digits10)
      << "scene,setting,nodes,steps,method,threshold,error_k_stretch,error_density,error_mu,error_x_0,"
         "iterations_per_step,failed_share,seconds\n";
  for (const ThresholdResult& result : benchmark.results) {
    const GradientErrors& errors = result.errors;
    out << result.name.scene << "," << result.name.setting << "," << result.name.nodes << "," << result.name.num_steps
        << "," << result.method << "," << result.threshold << "," << errors.k_stretch << "," << errors.density << ","
        << errors.mu << "," << errors.x_0 << "," << result.iterations << "," << result.failed_share << ","
        << result.seconds << "\n";
  }
  return out.str();
}

}  // namespace clothid
