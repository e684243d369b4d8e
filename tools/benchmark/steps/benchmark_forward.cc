#include "tools/benchmark/steps/benchmark_forward.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <iterator>
#include <limits>
#include <sstream>

#include "sim/base/error.h"
#include "sim/base/text_file.h"
#include "sim/cloth/cloth_model.h"
#include "sim/matrix/cholesky.h"
#include "sim/rollout/simulator.h"
#include "sim/step/step_solver.h"
#include "tools/benchmark/base/benchmark_scene.h"
#include "tools/benchmark/base/timing.h"

namespace clothid {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kStepTolerance = 1e-8;

constexpr double PhaseSeconds::*kPhases[] = {&PhaseSeconds::evaluation, &PhaseSeconds::assembly, &PhaseSeconds::contact,
                                             &PhaseSeconds::factorization, &PhaseSeconds::solution};

void Require(bool condition, const std::string& message) {
  if (!condition) throw Error(ErrorKind::kUsage, message);
}

// "patches:3.5e-3".
void SetBending(const std::string& text, Scene* scene) {
  const std::size_t colon = text.find(':');
  const std::string law = text.substr(0, colon);
  const double bending_stiffness =
      colon == std::string::npos ? kNaN : ParseNumber(text.substr(colon + 1)).value_or(kNaN);
  Require((law == "edges" || law == "patches") && bending_stiffness >= 0.0,
          "--bending: '" + Printable(text) + "': expected edges:K_BEND or patches:K_BEND, K_BEND >= 0 in N m");
  scene->bending.law = law == "edges" ? BendingLaw::kEdges : BendingLaw::kPatches;
  scene->material.bending_stiffness = bending_stiffness;
}

Scene MakeScene(const std::string& name, int nodes, const std::string& bending, const std::string& integrator) {
  const double stretch_stiffness = name == "slope" ? 50.0 : 100.0, time_step = name == "wind" ? 1.0 / 90.0 : 0.01;
  Scene scene = MakeBenchmarkScene(name, nodes, stretch_stiffness, time_step);
  scene.solver.step_tolerance = kStepTolerance;
  scene.integrator = IntegratorNamed(integrator);
  if (!bending.empty()) SetBending(bending, &scene);
  return scene;
}

// One case, with its simulator and what its rollouts without a failed step took.
struct Run {
  Run(const std::string& scene, int nodes, const std::string& bending, const std::string& integrator)
      : simulator(MakeScene(scene, nodes, bending, integrator)) {
    result.scene = scene;
    result.nodes = nodes;
    result.integrator = integrator;
    result.bending = bending;
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

void Run::Repeat(int num_steps) {
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

void Run::Summarize() {
  const auto median = [](const std::vector<double>& values) { return values.empty() ? kNaN : Median(values); };
  result.seconds = median(step_seconds);
  double sum = 0.0;  // medians do not add up to one of themselves
  for (const std::vector<double>& values : shares) sum += median(values);
  for (std::size_t i = 0; i < std::size(kPhases); ++i) {
    result.phases.*kPhases[i] = result.seconds * median(shares[i]) / sum;
  }
}

// `value` to `precision` decimals, right-aligned; a dash where there is none.
void Put(double value, int width, int precision, std::ostream& out) {
  if (std::isfinite(value)) {
    out << std::fixed << std::setw(width) << std::setprecision(precision) << value << std::defaultfloat;
  } else {
    out << std::setw(width) << "-";
  }
}

void PutCase(const ForwardCase& result, std::ostream& out) {
  out << std::left << std::setw(8) << result.scene << std::right << std::setw(3) << result.nodes << " x "
      << std::setw(3) << result.nodes << "  " << std::left << std::setw(7) << result.integrator << std::right;
}

// Of a step, relative to backward Euler; NaN where that was not run.
double TimesEuler(const ForwardBenchmark& benchmark, const ForwardCase& result) {
  for (const ForwardCase& euler : benchmark.cases) {
    const bool same = euler.scene == result.scene && euler.nodes == result.nodes;
    if (same && euler.bending == result.bending && IntegratorNamed(euler.integrator) == Integrator::kEuler)
      return result.seconds / euler.seconds;
  }
  return kNaN;
}

// Of a step, relative to the first law of bending.
double TimesFirstBending(const ForwardBenchmark& benchmark, const ForwardCase& result) {
  for (const ForwardCase& first : benchmark.cases) {
    const bool same = first.scene == result.scene && first.nodes == result.nodes;
    if (same && first.integrator == result.integrator) return result.seconds / first.seconds;
  }
  return kNaN;
}

void WriteBendingTable(const ForwardBenchmark& benchmark, std::ostream& out) {
  const bool is_given = std::any_of(benchmark.cases.begin(), benchmark.cases.end(),
                                    [](const ForwardCase& result) { return !result.bending.empty(); });
  if (!is_given) return;
  out << "\nms per step by the law of bending, and relative to the first of them\n"
         "scene      nodes  method  bending               step  x first  Newton  linear  factors\n";
  for (const ForwardCase& result : benchmark.cases) {
    PutCase(result, out);
    out << " " << std::left << std::setw(18) << result.bending << std::right;
    Put(1e3 * result.seconds, 8, 2, out);
    Put(TimesFirstBending(benchmark, result), 9, 2, out);
    Put(result.newton_iterations(), 8, 2, out);
    Put(result.linear_iterations(), 8, 2, out);
    Put(result.factorizations(), 9, 2, out);
    out << "\n";
  }
}

void WriteStepTable(const ForwardBenchmark& benchmark, std::ostream& out) {
  out << "ms per step\n"
         "scene      nodes  method     step  x euler  Newton  linear  factors  evaluation  assembly  contact  factor   "
         "solve   other"
         "  reference  ratio  failed  bytes/node\n";
  for (const ForwardCase& result : benchmark.cases) {
    const double reference = ReferenceStepSeconds(result.scene, result.nodes).value_or(kNaN);
    PutCase(result, out);
    Put(1e3 * result.seconds, 8, 2, out);
    Put(TimesEuler(benchmark, result), 9, 2, out);
    Put(result.newton_iterations(), 8, 2, out);
    Put(result.linear_iterations(), 8, 2, out);
    Put(result.factorizations(), 9, 2, out);
    Put(1e3 * result.phases.evaluation, 12, 2, out);
    Put(1e3 * result.phases.assembly, 10, 2, out);
    Put(1e3 * result.phases.contact, 9, 2, out);
    Put(1e3 * result.phases.factorization, 8, 2, out);
    Put(1e3 * result.phases.solution, 8, 2, out);
    Put(1e3 * (result.seconds - result.phases.sum()), 8, 2, out);
    Put(1e3 * reference, 11, 2, out);
    Put(result.seconds / reference, 7, 2, out);
    out << std::setw(8) << result.counts.failed_steps;
    Put(result.bytes, 12, 1, out);
    out << "\n";
  }
}

void WriteFactorTable(const ForwardBenchmark& benchmark, std::ostream& out) {
  out << "\none factorisation; dgemm: " << std::fixed << std::setprecision(1) << 1e-9 * benchmark.dgemm_rate
      << std::defaultfloat << " Gflop/s";
  if (!benchmark.blas_kernel.empty()) out << ", OpenBLAS for " << benchmark.blas_kernel;
  out << "\n"
         "scene      nodes  method    Mflop  10^6 entries  at dgemm speed, ms  measured, ms  ratio  with a solve, ms  "
         "ratio  floor, ms  step/floor\n";
  for (const ForwardCase& result : benchmark.cases) {
    const double least = result.factor_flops / benchmark.dgemm_rate;
    const double factor = result.phases.factorization / result.factorizations();
    // A solution with the factor of the point itself is one application of a factor, an iteration another.
    const double applications = result.factorizations() + result.linear_iterations();
    const double with_solve = factor + result.phases.solution / applications;
    PutCase(result, out);
    Put(1e-6 * result.factor_flops, 9, 2, out);
    Put(1e-6 * result.factor_entries, 14, 3, out);
    Put(1e3 * least, 20, 3, out);
    Put(1e3 * factor, 14, 3, out);
    Put(factor / least, 7, 2, out);
    Put(1e3 * with_solve, 18, 3, out);
    Put(with_solve / least, 7, 2, out);
    // The least that a step could take: one factor and one solve, which reads every entry of L twice.
    const double floor = (result.factor_flops + 4.0 * result.factor_entries) / benchmark.dgemm_rate;
    Put(1e3 * floor, 11, 3, out);
    Put(result.seconds / floor, 12, 2, out);
    out << "\n";
  }
}

// The exponent over the cases with the scene and integrator of `of`; NaN with fewer than two.
double GrowthExponent(const ForwardBenchmark& benchmark, const ForwardCase& of) {
  std::vector<double> nodes, seconds;
  for (const ForwardCase& result : benchmark.cases) {
    const bool same = result.scene == of.scene && result.integrator == of.integrator && result.bending == of.bending;
    if (!same || !(result.iteration_seconds() > 0.0)) continue;
    nodes.push_back(std::pow(result.nodes, 2));
    seconds.push_back(result.iteration_seconds());
  }
  return nodes.size() < 2 ? kNaN : FitExponent(nodes, seconds);
}

void WriteGrowthTable(const ForwardBenchmark& benchmark, std::ostream& out) {
  out << "\none Newton iteration that factorises; its time grows with the number of nodes to the power of the "
         "exponent\n"
         "scene      nodes  method   iterations per step  ms per iteration  exponent\n";
  for (std::size_t i = 0; i < benchmark.cases.size(); ++i) {
    const ForwardCase& result = benchmark.cases[i];
    const bool last =
        std::none_of(benchmark.cases.begin() + i + 1, benchmark.cases.end(), [&](const ForwardCase& other) {
          return other.scene == result.scene && other.integrator == result.integrator &&
                 other.bending == result.bending;
        });
    PutCase(result, out);
    Put(result.newton_iterations(), 21, 2, out);
    Put(1e3 * result.iteration_seconds(), 18, 2, out);
    if (last) Put(GrowthExponent(benchmark, result), 10, 2, out);
    out << "\n";
  }
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
  Require(!scenes.empty(), "--scene: expected at least one scene");
  for (const std::string& scene : scenes) {
    Require(std::find(kBenchmarkScenes.begin(), kBenchmarkScenes.end(), scene) != kBenchmarkScenes.end(),
            "--scene: '" + Printable(scene) + "': expected wind, slope or sphere");
  }
  Require(!nodes.empty(), "--nodes: expected at least one number");
  for (const int n : nodes) Require(n >= 2 && n <= kMaxNodes / n, "--nodes: expected numbers >= 2, not too large");
  ValidateIntegrators(integrators);
  Require(num_steps >= 1, "--steps: expected a number >= 1");
  Require(repeats >= 1, "--repeats: expected a number >= 1");
}

ForwardBenchmark RunForwardBenchmark(const ForwardBenchmarkOptions& options) {
  options.Validate();
  std::vector<Run> runs;
  for (const std::string& scene : options.scenes) {
    for (const int nodes : options.nodes) {
      for (const std::string& bending : options.bending) {
        for (const std::string& integrator : options.integrators) runs.emplace_back(scene, nodes, bending, integrator);
      }
    }
  }
  const int num_rollouts = options.repeats * static_cast<int>(runs.size());
  int num_done = 0;
  std::vector<double> dgemm_rates;
  for (int repeat = 0; repeat < options.repeats; ++repeat) {
    for (Run& run : runs) {
      dgemm_rates.push_back(MeasureDgemmRate());
      run.Repeat(options.num_steps);
      if (options.on_rollout) options.on_rollout(run.result, ++num_done, num_rollouts);
    }
  }
  ForwardBenchmark benchmark;
  benchmark.blas_kernel = BlasKernel();
  benchmark.dgemm_rate = Median(std::move(dgemm_rates));
  for (Run& run : runs) {
    run.Summarize();
    benchmark.cases.push_back(run.result);
  }
  return benchmark;
}

std::string ForwardTable(const ForwardBenchmark& benchmark) {
  std::ostringstream out;
  WriteStepTable(benchmark, out);
  WriteFactorTable(benchmark, out);
  WriteGrowthTable(benchmark, out);
  WriteBendingTable(benchmark, out);
  return out.str();
}

std::string ForwardCsv(const ForwardBenchmark& benchmark) {
  std::ostringstream out;
  out << std::setprecision(std::numeric_limits<double>::max_digits10)
      << "scene,nodes,integrator,bending,steps,newton_iterations,linear_iterations,factorizations,fallbacks,substeps,"
         "failed_"
         "steps,bytes_"
         "per_node_and_step,"
         "factor_flops,factor_entries,dgemm_flops_per_second,step_seconds,evaluation_seconds,assembly_seconds,"
         "contact_seconds,factorization_seconds,solution_seconds,reference_step_seconds\n";
  for (const ForwardCase& result : benchmark.cases) {
    const RolloutCounts& counts = result.counts;
    out << result.scene << "," << result.nodes << "," << result.integrator << "," << result.bending << ","
        << counts.steps << "," << counts.newton_iterations << "," << counts.linear_iterations << ","
        << counts.factorizations << "," << counts.fallbacks << "," << counts.substeps << "," << counts.failed_steps
        << "," << result.bytes << "," << result.factor_flops << "," << result.factor_entries << ","
        << benchmark.dgemm_rate << "," << result.seconds;
    for (const auto phase : kPhases) out << "," << result.phases.*phase;
    out << "," << ReferenceStepSeconds(result.scene, result.nodes).value_or(kNaN) << "\n";
  }
  return out.str();
}

}  // namespace clothid
