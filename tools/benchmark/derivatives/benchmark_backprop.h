// benchmark backprop: the reverse sweep by each of its methods, as in Table 1 (section 5.4) of the DiffCloth paper.
//
// In every case (scene, setting, size of the mesh) one run measures all methods on the same rollout. They take turns,
// as often as there are repetitions, so that their times compare; times are processor times of one thread, of which the
// table gives medians.
#ifndef CLOTHID_TOOLS_BENCHMARK_DERIVATIVES_BENCHMARK_BACKPROP_H_
#define CLOTHID_TOOLS_BENCHMARK_DERIVATIVES_BENCHMARK_BACKPROP_H_

#include <string>
#include <vector>

#include "sim/derivative/adjoint.h"
#include "tools/benchmark/derivatives/backprop_case.h"

namespace clothid {

struct BackpropMethod {
  std::string name;
  AdjointOptions options;
  bool with_block = false;  // also timed with kBlockColumns right-hand sides
};

// All that `--methods` knows, in the order of the table.
const std::vector<BackpropMethod>& BackpropMethods();

// What others are compared with: the direct solver.
inline constexpr char kReferenceDirect[] = "umfpack";

inline constexpr int kBlockColumns = 8;

// One sweep; processor time, s.
struct BackpropSample {
  double total = 0.0;
  double linear_solve = 0.0;  // factorisation and solution
  double assembly = 0.0;      // dP
  double contact = 0.0;       // dR
  double fallback = 0.0;      // of LU where it stepped in; part of those above

  double other() const { return total - linear_solve - assembly - contact; }
};

// One method in one case.
struct BackpropResult {
  BackpropCaseName name;
  std::string method;
  double iterations = 0.0;              // per linear system; there is one per step, and more where substeps were taken
  double failed_share = 0.0;            // of the systems: LU stepped in
  double gradient_error = 0.0;          // against kReferenceDirect, relative, of the worst parameter
  std::vector<BackpropSample> samples;  // by repetition
  std::vector<double> block_seconds;    // with kBlockColumns columns, by repetition; empty: not measured
  std::vector<double> rollout_seconds;  // of the rollout, by repetition: the same for all methods
};

struct BackpropOptions {
  BackpropCaseOptions cases;
  std::vector<std::string> methods;  // names; empty: all
  int num_repeats = 3;

  // Throws `Error` (kUsage) naming the first flag out of range.
  void Validate() const;
};

struct BackpropBenchmark {
  std::vector<BackpropResult> results;  // by case, then method
};

// Throws `Error` for options that cannot be used and where a rollout fails.
BackpropBenchmark RunBackpropBenchmark(const BackpropOptions& options);

// One line per result: times per step, medians; speed-ups and the ratios to the block and to the rollout are medians
// of the ratios within a repetition.
std::string BackpropTable(const BackpropBenchmark& benchmark);
std::string BackpropCsv(const BackpropBenchmark& benchmark);  // one row per result and repetition

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_DERIVATIVES_BENCHMARK_BACKPROP_H_
