#include "tools/benchmark/derivatives/benchmark_jacobian.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <utility>

#include "datasets/synthetic/true_recording.h"
#include "identify/base/parallel_for.h"
#include "identify/problem/problem.h"
#include "sim/base/error.h"
#include "sim/base/json_document.h"
#include "sim/base/text_file.h"
#include "sim/scene/scene_json.h"
#include "tools/benchmark/base/timing.h"

namespace clothid {
namespace {

using Fits = std::vector<JacobianFit>;

// Start number i of n along one axis of the grid.
double GridStart(const TrueParameter& parameter, int i, int n) {
  const double share = static_cast<double>(i) / (n - 1);
  if (parameter.is_friction) return kFirstFriction + share * (kLastFriction - kFirstFriction);
  return parameter.value * kFirstFactor * std::pow(kLastFactor / kFirstFactor, share);
}

// The fits to one recording, not yet run.
Fits PlanJacobianFits(const JacobianBenchmarkOptions& options, const std::vector<TrueParameter>& truth, double noise) {
  Fits fits;
  const int n = options.starts_per_axis;
  for (int start = 0; start < n * n; ++start) {
    for (const std::string& method : options.methods) {
      JacobianFit& fit = fits.emplace_back();
      fit.noise = noise;
      fit.method = method;
      fit.start = {GridStart(truth[0], start / n, n), GridStart(truth[1], start % n, n)};
    }
  }
  return fits;
}

// "adjoint:gmres:1e-4": the Jacobian, and the linear solver of its sweeps. Throws `Error` (kUsage).
void SetMethod(const std::string& method, FitOptions* options) {
  const std::string jacobian = method.substr(0, method.find(':'));
  const bool has_solver = jacobian != method;
  const std::string where = "--methods: '" + Printable(method) + "': ";
  ExpectUsage(std::count(kJacobianBenchmarkMethods.begin(), kJacobianBenchmarkMethods.end(), jacobian) > 0 &&
                  (!has_solver || jacobian == "adjoint"),
              where + "expected adjoint, sensitivity or numeric");
  options->jacobian = ParseJacobianMethod(jacobian);
  try {
    if (has_solver) options->adjoint = ParseAdjointOptions(method.substr(jacobian.size() + 1));
  } catch (const Error& error) {
    throw Error(ErrorKind::kUsage, where + error.what());
  }
}

// The fit that start and method of `fit` describe; fills in the rest, but for `reached`.
void RunJacobianFit(const RecordedMotion& motion, const std::vector<TrueParameter>& truth, FitPrecision precision,
                    JacobianFit* fit) {
  const double start = ThreadSeconds();
  FitOptions options;
  options.precision = precision;
  options.estimate_uncertainty = false;  // its sweep is the same for every method
  SetMethod(fit->method, &options);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    options.parameters.push_back(truth[i].name);
    options.overrides.start[truth[i].name] = fit->start[i];
  }
  FitProblem problem({motion}, options);
  const FitSummary summary = Fit(options, &problem);
  fit->seconds = ThreadSeconds() - start;
  const bool has_estimate = summary.has_estimate();
  for (std::size_t i = 0; i < truth.size(); ++i) {
    fit->value[i] = has_estimate ? summary.parameters[i].value : kNoNumber;
  }
  fit->cost = has_estimate ? summary.cost : std::numeric_limits<double>::infinity();
  fit->num_iterations = summary.num_iterations();
  fit->rollouts = summary.statistics.rollouts;
  fit->sweeps = summary.statistics.sweeps;
  fit->failed_steps = summary.statistics.counts.failed_steps;
  fit->status = summary.status;
  fit->message = summary.message;
}

std::string DescribeJacobianFit(const JacobianFit& fit) {
  return Format("%s, noise %g, start %g %g: %s, %d rollouts", fit.method.c_str(), fit.noise, fit.start[0], fit.start[1],
                FitStatusName(fit.status).c_str(), fit.rollouts);
}

bool IsNear(const std::array<double, 2>& value, const std::array<double, 2>& expected, double tolerance) {
  for (std::size_t i = 0; i < value.size(); ++i) {
    if (!(std::abs(value[i] - expected[i]) <= tolerance * std::abs(expected[i]))) return false;
  }
  return true;
}

// Sets `reached` of [begin, end), all the fits to one recording.
void JudgeFits(const std::vector<TrueParameter>& truth, Fits::iterator begin, Fits::iterator end) {
  const JacobianFit best =
      *std::min_element(begin, end, [](const JacobianFit& a, const JacobianFit& b) { return a.cost < b.cost; });
  for (auto fit = begin; fit != end; ++fit) {
    fit->reached = fit->noise == 0.0 ? IsNear(fit->value, {truth[0].value, truth[1].value}, kTruthTolerance)
                                     : fit->cost - best.cost <= kCostTolerance * best.cost &&
                                           IsNear(fit->value, best.value, kParameterTolerance);
  }
}

// The fits of one noise and method, in the order of the starts.
Fits SelectFits(const JacobianBenchmark& benchmark, double noise, const std::string& method) {
  Fits selected;
  std::copy_if(benchmark.fits.begin(), benchmark.fits.end(), std::back_inserter(selected),
               [&](const JacobianFit& fit) { return fit.noise == noise && fit.method == method; });
  return selected;
}

template <typename Value>
double MedianOfFits(const Fits& fits, Value JacobianFit::*member) {
  std::vector<double> values;
  for (const JacobianFit& fit : fits) values.push_back(static_cast<double>(fit.*member));
  return MedianOfRuns(std::move(values));
}

std::string JacobianTableRow(const JacobianBenchmark& benchmark, double noise, const std::string& method, int width) {
  const Fits fits = SelectFits(benchmark, noise, method), reference = SelectFits(benchmark, noise, "sensitivity");
  int num_reached = 0, max_rollouts = 0, failed_steps = 0;
  std::vector<double> ratios;
  for (std::size_t i = 0; i < fits.size(); ++i) {
    num_reached += fits[i].reached;
    max_rollouts = std::max(max_rollouts, fits[i].rollouts);
    failed_steps += fits[i].failed_steps;
    if (!reference.empty()) ratios.push_back(fits[i].seconds / reference[i].seconds);
  }
  const double ratio = ratios.empty() ? kNoNumber : MedianOfRuns(std::move(ratios));
  const std::string reached = std::to_string(num_reached) + " of " + std::to_string(fits.size());
  return Format("%-*s%7g%11s%10.1f%6d%8.1f%14d%10.2f%16s\n", width, method.c_str(), noise, reached.c_str(),
                MedianOfFits(fits, &JacobianFit::rollouts), max_rollouts, MedianOfFits(fits, &JacobianFit::sweeps),
                failed_steps, MedianOfFits(fits, &JacobianFit::seconds), FixedNumber(ratio, 2).c_str());
}

}  // namespace

void JacobianBenchmarkOptions::Validate() const {
  ExpectUsage(!scene_path.empty(), "--scene is missing; see benchmark --help");
  ExpectUsage(truth.size() == 2, "--set: expected two parameters, as in mu=0.3,k_stretch=100");
  ExpectUsage(std::isfinite(noise) && noise >= 0.0, "--noise: expected a number >= 0, relative to the cloth's size");
  ExpectUsage(starts_per_axis >= 2 && starts_per_axis % 2 == 0, "--starts: expected an even number >= 2");
  ExpectUsage(num_threads >= 1, "--threads: expected a number >= 1");
  ExpectUsage(!methods.empty(), "--methods: expected at least one method");
  FitOptions options;
  for (const std::string& method : methods) SetMethod(method, &options);
}

JacobianBenchmark RunJacobianBenchmark(const JacobianBenchmarkOptions& options) {
  options.Validate();
  const std::string scene_text = ReadFile(options.scene_path, kMaxJsonBytes);
  const std::string folder = std::filesystem::path(options.scene_path).parent_path().string();
  const Scene scene = ParseScene(scene_text, options.scene_path, folder);
  const std::vector<TrueParameter> truth = MakeTrueParameters(options.truth, scene);
  const Rollout rollout = SimulateTruth(truth, options.scene_path, scene);

  JacobianBenchmark benchmark;
  benchmark.names = {truth[0].name, truth[1].name};
  benchmark.methods = options.methods;
  benchmark.noises = {0.0};
  if (options.noise > 0.0) benchmark.noises.push_back(options.noise);
  std::vector<RecordedMotion> recordings;
  for (const double noise : benchmark.noises) {
    SyntheticOptions synthetic;
    synthetic.noise_sigma = noise * ClothSize(scene.mesh);
    synthetic.seed = options.seed;
    recordings.push_back(MakeRecording(rollout, scene, scene_text, synthetic));
    const Fits planned = PlanJacobianFits(options, truth, noise);
    benchmark.fits.insert(benchmark.fits.end(), planned.begin(), planned.end());
  }
  Fits& fits = benchmark.fits;
  const int num_fits = static_cast<int>(fits.size()), num_each = num_fits / static_cast<int>(recordings.size());
  ParallelFor(
      num_fits, options.num_threads,
      [&](int i) { RunJacobianFit(recordings[i / num_each], truth, options.precision, &fits[i]); },
      [&](int i, int num_done) {
        if (options.on_progress) options.on_progress(DescribeJacobianFit(fits[i]), num_done, num_fits);
      });
  for (auto begin = fits.begin(); begin != fits.end(); begin += num_each) JudgeFits(truth, begin, begin + num_each);
  return benchmark;
}

std::string JacobianTable(const JacobianBenchmark& benchmark) {
  std::size_t longest = 11;
  for (const std::string& method : benchmark.methods) longest = std::max(longest, method.size());
  const int width = static_cast<int>(longest) + 2;
  std::string table = Format("%-*s  noise    reached  rollouts   max  sweeps  failed steps   seconds  to sensitivity\n",
                             width, "method");
  for (const double noise : benchmark.noises) {
    for (const std::string& method : benchmark.methods) table += JacobianTableRow(benchmark, noise, method, width);
  }
  return table;
}

std::string JacobianCsv(const JacobianBenchmark& benchmark) {
  const auto& [first, second] = benchmark.names;
  std::string csv = CsvLine("start_" + first, "start_" + second, "method,noise", first, second,
                            "cost,reached,iterations,rollouts,sweeps,failed_steps,status,seconds");
  for (const JacobianFit& fit : benchmark.fits) {
    csv +=
        CsvLine(fit.start[0], fit.start[1], fit.method, fit.noise, fit.value[0], fit.value[1], fit.cost, fit.reached,
                fit.num_iterations, fit.rollouts, fit.sweeps, fit.failed_steps, FitStatusName(fit.status), fit.seconds);
  }
  return csv;
}

}  // namespace clothid
