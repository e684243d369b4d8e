// benchmark accuracy: error against run time, of trajectories and gradients
// (tools/benchmark/accuracy/accuracy_curves.h).
#ifndef CLOTHID_TOOLS_BENCHMARK_ACCURACY_BENCHMARK_ACCURACY_H_
#define CLOTHID_TOOLS_BENCHMARK_ACCURACY_BENCHMARK_ACCURACY_H_

#include <string>
#include <vector>

#include "tools/benchmark/accuracy/accuracy_curves.h"

namespace clothid {

struct AccuracyOptions {
  std::vector<std::string> scenes = kBenchmarkScenes;
  std::vector<std::string> settings = BackpropSettingNames();
  std::vector<std::string> quantities = kAccuracyQuantities;
  std::vector<std::string> integrators = kIntegratorNames;  // of the trajectories
  int nodes = 17;                                           // n, along both axes; the finest mesh has 2 n - 1
  int repeats = 3;
  BenchmarkProgress on_progress;  // after each quantity of each scene and setting

  // Throws `Error` (kUsage) naming the first flag out of range.
  void Validate() const;
};

struct AccuracyBenchmark {
  std::vector<AccuracyPoint> points;  // by scene, setting, quantity, method; comparable ones stand together
};

// Throws `Error` for options that cannot be used and where a rollout that others build on fails.
AccuracyBenchmark RunAccuracyBenchmark(const AccuracyOptions& options);

// A line per curve: trajectories at kMeshTolerance over the time step, gradients over the threshold.
std::string AccuracyTable(const AccuracyBenchmark& benchmark);
std::string AccuracyCsv(
    const AccuracyBenchmark& benchmark);  // one row per point, which tools/plots/plot_accuracy draws

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_ACCURACY_BENCHMARK_ACCURACY_H_
