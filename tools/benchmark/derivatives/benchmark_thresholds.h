// benchmark thresholds: how exact a gradient is when the linear systems of the reverse sweep are solved loosely.
//
// Section 5.4 of the DiffCloth paper varies the threshold of its iteration from 1e-1 to 1e-9 until the gradients agree
// with those of the direct solver. Here the same for each iterative method, and for each parameter by itself.
#ifndef CLOTHID_TOOLS_BENCHMARK_DERIVATIVES_BENCHMARK_THRESHOLDS_H_
#define CLOTHID_TOOLS_BENCHMARK_DERIVATIVES_BENCHMARK_THRESHOLDS_H_

#include <string>
#include <vector>

#include "sim/derivative/adjoint.h"
#include "tools/benchmark/derivatives/backprop_case.h"

namespace clothid {

struct ThresholdMethod {
  std::string name;
  AdjointMethod method;
  bool use_kept_factors = true;  // see AdjointOptions
};

inline const std::vector<ThresholdMethod> kThresholdMethods = {
    {"fixed_point", AdjointMethod::kFixedPoint},
    {"gmres", AdjointMethod::kSystemGmres},
    {"reduced", AdjointMethod::kReduced},
};

// Thresholds of every method.
inline const std::vector<double> kThresholds = {1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9};

// One gradient.
struct ThresholdResult {
  BackpropCaseName name;
  std::string method;
  double threshold = 0.0;
  GradientErrors errors;      // against UMFPACK
  double iterations = 0.0;    // per linear system; there is one per step, and more where substeps were taken
  int failed_solves = 0;      // systems in which LU stepped in, which makes them exact
  double failed_share = 0.0;  // of all systems
  double seconds = 0.0;       // processor time of the sweep
};

struct ThresholdOptions {
  BackpropCaseOptions cases;
  std::vector<std::string> methods;  // names; empty: all

  // Throws `Error` (kUsage) naming the first flag out of range.
  void Validate() const;
};

struct ThresholdBenchmark {
  std::vector<ThresholdResult> results;  // by case, then method, then threshold
};

// One sweep over the rollout of `backprop`. The threshold means nothing to a direct method.
ThresholdResult MeasureThreshold(const ThresholdMethod& method, double threshold, const RolloutGradient& reference,
                                 BackpropCase* backprop);

// Throws `Error` for options that cannot be used and where a rollout fails.
ThresholdBenchmark RunThresholdBenchmark(const ThresholdOptions& options);

// One line per result.
std::string ThresholdTable(const ThresholdBenchmark& benchmark);

// One row per result, which tools/plots/plot_thresholds draws.
std::string ThresholdCsv(const ThresholdBenchmark& benchmark);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_DERIVATIVES_BENCHMARK_THRESHOLDS_H_
