#include "tools/benchmark/steps/benchmark_forward.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>

#include "sim/cloth/cloth_model.h"
#include "sim/matrix/cholesky.h"
#include "sim/rollout/simulator.h"
#include "sim/step/step_solver.h"
#include "tools/benchmark/base/benchmark_scene.h"
#include "tools/benchmark/base/timing.h"

namespace clothid {
namespace {

constexpr double kStepTolerance = 1e-8;

constexpr double PhaseSeconds::*kPhases[] = {&PhaseSeconds::evaluation, &PhaseSeconds::assembly, &PhaseSeconds::contact,
                                             &PhaseSeconds::factorization, &PhaseSeconds::solution};

Scene MakeForwardScene(const std::string& name, int nodes, const std::string& integrator) {
  const bool folds = name == "fold" || name == "fold_through";
  const double stretch_stiffness = name == "slope" ? 50.0 : folds ? 60.0 : 100.0;
  const double time_step = name == "wind" ? 1.0 / 90.0 : folds ? 0.005 : 0.01;
  Scene scene = MakeBenchmarkScene(name, nodes, stretch_stiffness, time_step);
  scene.solver.step_tolerance = kStepTolerance;
  scene.integrator = IntegratorNamed(integrator);
  return scene;
}

// One case, with its simulator and what its rollouts without a failed step took.
struct ForwardRun {
  ForwardRun(const std::string& scene, int nodes, const std::string& integrator)
      : simulator(MakeForwardScene(scene, nodes, integrator)) {
    result.scene = scene;
    result.nodes = nodes;
    result.integrator = integrator;
    const CholeskySolver cholesky(simulator.model().pattern());
    result.factor_flops = cholesky.num_flops();
    result.factor_entries = cholesky.num_entries();
  }

  void Repeat(int num_steps);
  void Summarize();

  Simulator simulator;
  ForwardCase result;
  std::vector<double> step_seconds;  // per rollout, processor time
  // Of its wall time, per phase and rollout; last, what lies outside of all phases.
  std::array<std::vector<double>, std::size(kPhases) + 1> shares;
};

void ForwardRun::Repeat(int num_steps) {
  const Parameters parameters = simulator.scene().nominal_parameters();
  const PhaseSeconds before = simulator.step_solver().seconds();
  double wall_seconds = 0.0;
  Rollout rollout;
  const double start = ThreadSeconds();
  {
    const ScopedTimer timer(&wall_seconds);
    rollout = Simulate(parameters, num_steps, &simulator);
  }
  const double seconds = ThreadSeconds() - start;
  result.counts = rollout.counts;
  if (!rollout.ok()) return;
  result.bytes = static_cast<double>(rollout.bytes()) / (simulator.model().num_nodes() * num_steps);
  step_seconds.push_back(seconds / num_steps);
  const PhaseSeconds& after = simulator.step_solver().seconds();
  shares.back().push_back(1.0 - (after.sum() - before.sum()) / wall_seconds);
  for (std::size_t i = 0; i < std::size(kPhases); ++i) {
    shares[i].push_back((after.*kPhases[i] - before.*kPhases[i]) / wall_seconds);
  }
}

void ForwardRun::Summarize() {
  const auto median = [](const std::vector<double>& values) {
    return values.empty() ? kNoNumber : MedianOfRuns(values);
  };
  result.seconds = median(step_seconds);
  double sum = 0.0;  // medians do not add up to one of themselves
  for (const std::vector<double>& values : shares) sum += median(values);
  for (std::size_t i = 0; i < std::size(kPhases); ++i) {
    result.phases.*kPhases[i] = result.seconds * median(shares[i]) / sum;
  }
}

// A cell so many characters wide; a dash where there is no number.
std::string Cell(double value, int width, int digits) {
  return Format("%*s", width, FixedNumber(value, digits).c_str());
}

std::string ForwardCaseColumns(const ForwardCase& result) {
  return Format("%-13s%3d x %3d  %-7s", result.scene.c_str(), result.nodes, result.nodes, result.integrator.c_str());
}

// Of a step, relative to backward Euler; NaN where that was not run.
double TimesEuler(const ForwardBenchmark& benchmark, const ForwardCase& result) {
  for (const ForwardCase& euler : benchmark.cases) {
    const bool same = euler.scene == result.scene && euler.nodes == result.nodes;
    if (same && euler.integrator == "euler") return result.seconds / euler.seconds;
  }
  return kNoNumber;
}

std::string StepTable(const ForwardBenchmark& benchmark) {
  std::string table =
      "ms per step\n"
      "scene           nodes  method     step  x euler  Newton  linear  factors  evaluation  assembly  contact  factor "
      "  "
      "solve   other  reference  ratio  failed  bytes/node\n";
  for (const ForwardCase& result : benchmark.cases) {
    const double reference = ReferenceStepSeconds(result.scene, result.nodes).value_or(kNoNumber);
    const PhaseSeconds& phases = result.phases;
    table += ForwardCaseColumns(result) + Cell(1e3 * result.seconds, 8, 2) + Cell(TimesEuler(benchmark, result), 9, 2) +
             Cell(result.newton_iterations(), 8, 2) + Cell(result.linear_iterations(), 8, 2) +
             Cell(result.factorizations(), 9, 2) + Cell(1e3 * phases.evaluation, 12, 2) +
             Cell(1e3 * phases.assembly, 10, 2) + Cell(1e3 * phases.contact, 9, 2) +
             Cell(1e3 * phases.factorization, 8, 2) + Cell(1e3 * phases.solution, 8, 2) +
             Cell(1e3 * (result.seconds - phases.sum()), 8, 2) + Cell(1e3 * reference, 11, 2) +
             Cell(result.seconds / reference, 7, 2) + Format("%8d", result.counts.failed_steps) +
             Cell(result.bytes, 12, 1) + "\n";
  }
  return table;
}

std::string FactorTable(const ForwardBenchmark& benchmark) {
  std::string table = "\none factorisation; dgemm: " + FixedNumber(1e-9 * benchmark.dgemm_rate, 1) + " Gflop/s";
  if (!benchmark.blas_kernel.empty()) table += ", OpenBLAS for " + benchmark.blas_kernel;
  table +=
      "\nscene           nodes  method    Mflop  10^6 entries  at dgemm speed, ms  measured, ms  ratio  with a solve, "
      "ms  "
      "ratio  floor, ms  step/floor\n";
  for (const ForwardCase& result : benchmark.cases) {
    const double least = result.factor_flops / benchmark.dgemm_rate;
    const double factor = result.phases.factorization / result.factorizations();
    // A solution with the factor of the point itself is one application of a factor, an iteration another.
    const double applications = result.factorizations() + result.linear_iterations();
    const double with_solve = factor + result.phases.solution / applications;
    // The least that a step could take: one factor and one solve, which reads every entry of L twice.
    const double floor = (result.factor_flops + 4.0 * result.factor_entries) / benchmark.dgemm_rate;
    table += ForwardCaseColumns(result) + Cell(1e-6 * result.factor_flops, 9, 2) +
             Cell(1e-6 * result.factor_entries, 14, 3) + Cell(1e3 * least, 20, 3) + Cell(1e3 * factor, 14, 3) +
             Cell(factor / least, 7, 2) + Cell(1e3 * with_solve, 18, 3) + Cell(with_solve / least, 7, 2) +
             Cell(1e3 * floor, 11, 3) + Cell(result.seconds / floor, 12, 2) + "\n";
  }
  return table;
}

// The exponent over the cases with the scene and integrator of `of`, told in the last of them alone; NaN
// before, and with fewer than two.
double GrowthExponent(const ForwardBenchmark& benchmark, const ForwardCase& of) {
  std::vector<double> nodes, seconds;
  const ForwardCase* last = nullptr;
  for (const ForwardCase& result : benchmark.cases) {
    if (result.scene != of.scene || result.integrator != of.integrator) continue;
    last = &result;
    if (!(result.iteration_seconds() > 0.0)) continue;
    nodes.push_back(std::pow(result.nodes, 2));
    seconds.push_back(result.iteration_seconds());
  }
  return last != &of || nodes.size() < 2 ? kNoNumber : FitExponent(nodes, seconds);
}

std::string GrowthTable(const ForwardBenchmark& benchmark) {
  std::string table =
      "\none Newton iteration that factorises; its time grows with the number of nodes to the power of the exponent\n"
      "scene           nodes  method   iterations per step  ms per iteration  exponent\n";
  for (const ForwardCase& result : benchmark.cases) {
    table += ForwardCaseColumns(result) + Cell(result.newton_iterations(), 21, 2) +
             Cell(1e3 * result.iteration_seconds(), 18, 2);
    const double exponent = GrowthExponent(benchmark, result);
    table += (std::isnan(exponent) ? "" : Cell(exponent, 10, 2)) + "\n";
  }
  return table;
}

}  // namespace

double ForwardCase::iteration_seconds() const {
  const double linearization = phases.assembly + phases.factorization;
  return linearization / factorizations() + (seconds - linearization) / newton_iterations();
}

std::optional<double> ReferenceStepSeconds(const std::string& scene, int nodes) {
  struct Reference {
    const char* scene;
    int nodes;
    double seconds;
  };
  static constexpr Reference kReferences[] = {{"wind", 12, 3.8e-3},   {"wind", 24, 51e-3},   {"wind", 48, 435e-3},
                                              {"slope", 12, 0.29e-3}, {"slope", 24, 2.8e-3}, {"slope", 48, 27e-3}};
  for (const Reference& reference : kReferences) {
    if (scene == reference.scene && nodes == reference.nodes) return reference.seconds;
  }
  return std::nullopt;
}

void ForwardBenchmarkOptions::Validate() const {
  RequireKnown(scenes, kForwardScenes, "--scene");
  ExpectUsage(!nodes.empty(), "--nodes: expected at least one number");
  for (const int n : nodes) ExpectUsage(n >= 2 && n <= kMaxNodes / n, "--nodes: expected numbers >= 2, not too large");
  RequireKnown(integrators, kIntegratorNames, "--integrator");
  ExpectUsage(num_steps >= 1, "--steps: expected a number >= 1");
  ExpectUsage(repeats >= 1, "--repeats: expected a number >= 1");
}

ForwardBenchmark RunForwardBenchmark(const ForwardBenchmarkOptions& options) {
  options.Validate();
  std::vector<ForwardRun> runs;
  for (const std::string& scene : options.scenes) {
    for (const int nodes : options.nodes) {
      for (const std::string& integrator : options.integrators) runs.emplace_back(scene, nodes, integrator);
    }
  }
  const int num_rollouts = options.repeats * static_cast<int>(runs.size());
  int num_done = 0;
  std::vector<double> dgemm_rates;
  for (int repeat = 0; repeat < options.repeats; ++repeat) {
    for (ForwardRun& run : runs) {
      dgemm_rates.push_back(MeasureDgemmRate());
      run.Repeat(options.num_steps);
      if (!options.on_progress) continue;
      const ForwardCase& last = run.result;
      options.on_progress(Format("%s, %d x %d nodes", last.scene.c_str(), last.nodes, last.nodes), ++num_done,
                          num_rollouts);
    }
  }
  ForwardBenchmark benchmark;
  benchmark.blas_kernel = BlasKernel();
  benchmark.dgemm_rate = MedianOfRuns(std::move(dgemm_rates));
  for (ForwardRun& run : runs) {
    run.Summarize();
    benchmark.cases.push_back(run.result);
  }
  return benchmark;
}

std::string ForwardTable(const ForwardBenchmark& benchmark) {
  return StepTable(benchmark) + FactorTable(benchmark) + GrowthTable(benchmark);
}

std::string ForwardCsv(const ForwardBenchmark& benchmark) {
  std::string csv =
      "scene,nodes,integrator,steps,newton_iterations,linear_iterations,factorizations,fallbacks,substeps,"
      "failed_steps,bytes_per_node_and_step,factor_flops,factor_entries,dgemm_flops_per_second,step_seconds,"
      "evaluation_seconds,assembly_seconds,contact_seconds,factorization_seconds,solution_seconds,"
      "reference_step_seconds\n";
  for (const ForwardCase& result : benchmark.cases) {
    const RolloutCounts& counts = result.counts;
    const PhaseSeconds& phases = result.phases;
    csv += CsvLine(result.scene, result.nodes, result.integrator, counts.steps, counts.newton_iterations,
                   counts.linear_iterations, counts.factorizations, counts.fallbacks, counts.substeps,
                   counts.failed_steps, result.bytes, result.factor_flops, result.factor_entries, benchmark.dgemm_rate,
                   result.seconds, phases.evaluation, phases.assembly, phases.contact, phases.factorization,
                   phases.solution, ReferenceStepSeconds(result.scene, result.nodes).value_or(kNoNumber));
  }
  return csv;
}

}  // namespace clothid
