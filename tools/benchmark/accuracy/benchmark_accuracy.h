// benchmark accuracy: error against run time, of trajectories (tools/benchmark/accuracy/accuracy_forward.h), gradients
// (tools/benchmark/accuracy/accuracy_gradient.h) and fits (tools/benchmark/accuracy/accuracy_fit.h).
#ifndef CLOTHID_TOOLS_BENCHMARK_ACCURACY_BENCHMARK_ACCURACY_H_
#define CLOTHID_TOOLS_BENCHMARK_ACCURACY_BENCHMARK_ACCURACY_H_

#include <functional>
#include <string>
#include <vector>

#include "tools/benchmark/accuracy/accuracy_point.h"
#include "tools/benchmark/base/integrators.h"
#include "tools/benchmark/derivatives/backprop_case.h"

namespace clothid {

struct AccuracyOptions {
  std::vector<std::string> scenes = kBenchmarkScenes;
  std::vector<std::string> settings = BackpropSettingNames();
  std::vector<std::string> quantities = kAccuracyQuantities;
  std::vector<std::string> integrators = kIntegratorNames;  // of the trajectories over the time step
  int nodes = 17;  // n, along both axes, 4 i + 1; the finest mesh has 2 n - 1, those of the fits (n + 1)/2
  int repeats = 3;
  // After each quantity of each scene and setting. May be empty.
  std::function<void(const std::string& what, int num_done, int num_items)> on_measured;

  // Throws `Error` (kUsage) naming the first flag out of range.
  void Validate() const;
};

struct AccuracyBenchmark {
  std::vector<AccuracyPoint> points;  // by scene, setting, quantity, method; comparable ones stand together
};

// Throws `Error` for options that cannot be used and where a rollout that others build on fails.
AccuracyBenchmark RunAccuracyBenchmark(const AccuracyOptions& options);

// Two tables: a line per curve; what is cheapest for an error of at most 1e-1, 1e-2, .., by scene, setting and
// quantity.
std::string AccuracyTable(const AccuracyBenchmark& benchmark);

// One row per point, which tools/plots/plot_accuracy draws; `pareto` is 1 for those of ParetoFront.
std::string AccuracyCsv(const AccuracyBenchmark& benchmark);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_ACCURACY_BENCHMARK_ACCURACY_H_
