// benchmark forward: what a step of the forward simulation costs, with either integrator, and where its time goes.
//
// The scenes of tools/benchmark/base/benchmark_scene.h at a relative residual of 1e-8: wind with k = 100 N/m and h =
// 1/90 s, slope with k = 50 N/m and h = 1/100 s, sphere with k = 100 N/m and h = 1/100 s, both folds with k = 60 N/m
// and h = 1/200 s. All scenes and sizes take turns, `repeats` times; times are medians over the repeats, in processor
// time of one thread.
//
// A phase has the share of the processor time of a step that it has, in the median, of the wall time. What a
// factorisation must cost at the least: its floating-point operations, without those on zeros that a supernodal factor
// adds, at the speed of dgemm measured in the same run; the floor of a step is one of them and one solve at that speed.
// The cost of an iteration is put together so that it does not depend on how many of them factorise: assembly and
// factorisation per factorisation, everything else per iteration.
#ifndef CLOTHID_TOOLS_BENCHMARK_STEPS_BENCHMARK_FORWARD_H_
#define CLOTHID_TOOLS_BENCHMARK_STEPS_BENCHMARK_FORWARD_H_

#include <optional>
#include <string>
#include <vector>

#include "sim/base/phase_seconds.h"
#include "sim/rollout/rollout.h"
#include "tools/benchmark/base/common.h"

namespace clothid {

// One scene at one size with one integrator. All but the seconds depends on the options alone.
struct ForwardCase {
  std::string scene;
  int nodes = 0;  // along each axis
  std::string integrator;
  RolloutCounts counts;       // of one rollout
  double seconds = 0.0;       // a step, processor time; NaN, as the phases, where a step failed
  PhaseSeconds phases;        // a step, processor time
  double bytes = 0.0;         // of the rollout, per node and step
  double factor_flops = 0.0;  // of one factorisation
  double factor_entries = 0.0;

  // Counts per step.
  double newton_iterations() const { return static_cast<double>(counts.newton_iterations) / counts.steps; }
  double linear_iterations() const { return static_cast<double>(counts.linear_iterations) / counts.steps; }
  double factorizations() const { return static_cast<double>(counts.factorizations) / counts.steps; }
  // Of one Newton iteration that factorises, s.
  double iteration_seconds() const;
};

struct ForwardBenchmarkOptions {
  std::vector<std::string> scenes = {"wind", "slope"};
  std::vector<int> nodes = {12, 24, 48};  // along each axis
  std::vector<std::string> integrators = kIntegratorNames;
  int num_steps = 100;
  int repeats = 3;
  BenchmarkProgress on_progress;  // after every rollout

  // Throws `Error` (kUsage) naming the first flag out of range.
  void Validate() const;
};

struct ForwardBenchmark {
  double dgemm_rate = 0.0;         // 1/s
  std::string blas_kernel;         // see BlasKernel
  std::vector<ForwardCase> cases;  // by scene, nodes, integrator
};

// The time of a step, s, of the DiffCloth code on such a machine at its own, looser thresholds, one thread; for the
// scenes and sizes at which it was measured.
std::optional<double> ReferenceStepSeconds(const std::string& scene, int nodes);

// Throws `Error` for options that cannot be used.
ForwardBenchmark RunForwardBenchmark(const ForwardBenchmarkOptions& options);

// The step and its phases, its time beside that of backward Euler where both were run; the factor beside dgemm; the
// growth with the number of nodes.
std::string ForwardTable(const ForwardBenchmark& benchmark);
std::string ForwardCsv(const ForwardBenchmark& benchmark);  // one row per case

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_STEPS_BENCHMARK_FORWARD_H_
