// benchmark fields: fits of a stiffness that varies over the cloth (identify/fit/joint_stage.h), with more and more
// unknowns, beside numeric differences.
//
// The truth is a field of k_stretch of the given level, exp(0.4 z) times it, z a sum of nine cosines with seeded
// amplitudes and a mean square of 1 over the cloth; the fit starts from the scene's nominal value everywhere. Of
// differences a whole gradient would take a rollout per unknown: some are made and timed.
#ifndef CLOTHID_TOOLS_BENCHMARK_FITS_BENCHMARK_FIELDS_H_
#define CLOTHID_TOOLS_BENCHMARK_FITS_BENCHMARK_FIELDS_H_

#include <cstdint>
#include <string>
#include <vector>

#include "tools/benchmark/base/common.h"

namespace clothid {

struct FieldsFit {
  int side = 0;  // of the control grid: side^2 unknowns
  bool has_converged = false;
  double weight = 0.0;  // lambda
  double rmse = 0.0;    // m, of the prediction
  // Root mean square error of log k over the control nodes: all, and those that are determined; NaN where none is.
  double error = 0.0, determined_error = 0.0, determined_share = 0.0;
  int iterations = 0, rollouts = 0, sweeps = 0;
  double seconds = 0.0;             // of processor time, of the fit, standard deviations included
  double difference_seconds = 0.0;  // of a Jacobian by numeric differences, as some of its columns took
  double iteration_seconds = 0.0;   // of processor time, to the last iteration
  double seconds_per_iteration() const { return iterations > 0 ? iteration_seconds / iterations : iteration_seconds; }
};

struct FieldsOptions {
  std::string scene_path;
  int nodes = 24;  // along the first axis of the grid
  std::vector<int> sides = {4, 8, 16, 32};
  double level = 70.0;            // N/m, of the truth
  double noise = 0.001;           // m
  std::uint64_t seed = 1;         // of truth and noise
  int num_differences = 4;        // that are timed
  BenchmarkProgress on_progress;  // after every fit

  // Throws `Error` (kUsage) naming the first flag out of range.
  void Validate() const;
};

struct FieldsBenchmark {
  std::vector<FieldsFit> fits;
};

// Throws `Error` for options and scenes that cannot be used and where the rollout of the truth fails.
FieldsBenchmark RunFieldsBenchmark(const FieldsOptions& options);
std::string FieldsTable(const FieldsBenchmark& benchmark);  // one line per fit
std::string FieldsCsv(const FieldsBenchmark& benchmark);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_FITS_BENCHMARK_FIELDS_H_
