#include "tools/benchmark/derivatives/benchmark_jacobian.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iomanip>
#include <limits>
#include <optional>
#include <sstream>
#include <utility>

#include "datasets/synthetic/true_recording.h"
#include "identify/base/parallel_for.h"
#include "identify/fit/problem.h"
#include "sim/base/error.h"
#include "sim/base/json_document.h"
#include "sim/base/text_file.h"
#include "sim/scene/scene_json.h"
#include "tools/benchmark/base/timing.h"

namespace clothid {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

void Require(bool condition, const std::string& message) {
  if (!condition) throw Error(ErrorKind::kUsage, message);
}

// Start number i of n along one axis of the grid.
double StartValue(const TrueParameter& parameter, int i, int n) {
  const double share = static_cast<double>(i) / (n - 1);
  if (parameter.is_friction) return kFirstFriction + share * (kLastFriction - kFirstFriction);
  return parameter.value * kFirstFactor * std::pow(kLastFactor / kFirstFactor, share);
}

// The fits to one recording, not yet run.
std::vector<JacobianFit> PlanFits(const JacobianBenchmarkOptions& options, const std::vector<TrueParameter>& truth,
                                  double noise) {
  std::vector<JacobianFit> fits;
  const int n = options.starts_per_axis;
  for (int start = 0; start < n * n; ++start) {
    for (const std::string& method : options.methods) {
      JacobianFit fit;
      fit.noise = noise;
      fit.method = method;
      fit.start = {StartValue(truth[0], start / n, n), StartValue(truth[1], start % n, n)};
      fits.push_back(fit);
    }
  }
  return fits;
}

// "adjoint:gmres:1e-4" -> "adjoint", "gmres:1e-4".
struct MethodName {
  std::string jacobian, adjoint;
};

MethodName SplitMethodName(const std::string& method) {
  const std::size_t colon = method.find(':');
  if (colon == std::string::npos) return {method, ""};
  return {method.substr(0, colon), method.substr(colon + 1)};
}

void CheckMethod(const std::string& method) {
  const std::vector<std::string>& known = kJacobianBenchmarkMethods;
  const MethodName name = SplitMethodName(method);
  const bool has_sweep = name.jacobian == "adjoint";
  Require(std::find(known.begin(), known.end(), has_sweep ? name.jacobian : method) != known.end(),
          "--methods: '" + Printable(method) + "': expected adjoint, sensitivity or numeric");
  try {
    if (method.find(':') != std::string::npos) ParseAdjointOptions(name.adjoint);
  } catch (const Error& error) {
    throw Error(ErrorKind::kUsage, "--methods: '" + Printable(method) + "': " + error.what());
  }
}

FitOptions MakeFitOptions(const std::vector<TrueParameter>& truth, FitPrecision precision, const JacobianFit& fit) {
  FitOptions options;
  options.precision = precision;
  options.estimate_uncertainty = false;  // its sweep is the same for every method
  for (std::size_t i = 0; i < truth.size(); ++i) {
    options.parameters.push_back(truth[i].name);
    options.overrides.start[truth[i].name] = fit.start[i];
  }
  const MethodName name = SplitMethodName(fit.method);
  if (!name.adjoint.empty()) options.adjoint = ParseAdjointOptions(name.adjoint);
  options.jacobian = ParseJacobianMethod(name.jacobian);
  return options;
}

// Runs fits[i] against recordings[i / fits_per_recording]. Each fit has memory of its own.
void RunFits(const JacobianBenchmarkOptions& options, const std::vector<RecordedMotion>& recordings,
             const std::vector<TrueParameter>& truth, std::vector<JacobianFit>* fits) {
  const int num_fits = static_cast<int>(fits->size());
  const int fits_per_recording = num_fits / static_cast<int>(recordings.size());
  ParallelFor(
      num_fits, options.num_threads,
      [&](int i) { RunJacobianFit(recordings[i / fits_per_recording], truth, options.precision, &(*fits)[i]); },
      [&](int i, int num_done) {
        if (options.on_fit) options.on_fit((*fits)[i], num_done, num_fits);
      });
}

bool IsNear(const std::array<double, 2>& value, const std::array<double, 2>& expected, double tolerance) {
  for (std::size_t i = 0; i < value.size(); ++i) {
    if (!(std::abs(value[i] - expected[i]) <= tolerance * std::abs(expected[i]))) return false;
  }
  return true;
}

// The fits of one noise and method, in the order of the starts.
std::vector<JacobianFit> Select(const JacobianBenchmark& benchmark, double noise, const std::string& method) {
  std::vector<JacobianFit> selected;
  std::copy_if(benchmark.fits.begin(), benchmark.fits.end(), std::back_inserter(selected),
               [&](const JacobianFit& fit) { return fit.noise == noise && fit.method == method; });
  return selected;
}

template <typename Value>
double MedianOf(const std::vector<JacobianFit>& fits, Value JacobianFit::*member) {
  std::vector<double> values;
  for (const JacobianFit& fit : fits) values.push_back(static_cast<double>(fit.*member));
  return Median(std::move(values));
}

std::optional<double> MedianTimeRatio(const std::vector<JacobianFit>& fits, const std::vector<JacobianFit>& reference) {
  if (reference.empty()) return std::nullopt;
  std::vector<double> ratios;
  for (std::size_t i = 0; i < fits.size(); ++i) ratios.push_back(fits[i].seconds / reference[i].seconds);
  return Median(std::move(ratios));
}

void WriteTableRow(const JacobianBenchmark& benchmark, double noise, const std::string& method, int width,
                   std::ostream& out) {
  const std::vector<JacobianFit> fits = Select(benchmark, noise, method);
  int num_reached = 0, max_rollouts = 0, failed_steps = 0;
  for (const JacobianFit& fit : fits) {
    num_reached += fit.reached;
    max_rollouts = std::max(max_rollouts, fit.rollouts);
    failed_steps += fit.failed_steps;
  }
  const std::optional<double> ratio = MedianTimeRatio(fits, Select(benchmark, noise, "sensitivity"));
  std::ostringstream reached, relative;
  reached << num_reached << " of " << fits.size();
  relative << std::fixed << std::setprecision(2);
  if (ratio) relative << *ratio;
  out << std::left << std::setw(width) << method << std::right << std::setw(7) << noise << std::setw(11)
      << reached.str() << std::fixed << std::setprecision(1) << std::setw(10) << MedianOf(fits, &JacobianFit::rollouts)
      << std::setw(6) << max_rollouts << std::setw(8) << MedianOf(fits, &JacobianFit::sweeps) << std::setw(14)
      << failed_steps << std::setprecision(2) << std::setw(10) << MedianOf(fits, &JacobianFit::seconds) << std::setw(16)
      << (ratio ? relative.str() : "-") << std::defaultfloat << std::setprecision(6) << "\n";
}

}  // namespace

void JacobianBenchmarkOptions::Validate() const {
  Require(!scene_path.empty(), "--scene is missing; see benchmark --help");
  Require(truth.size() == 2, "--set: expected two parameters, as in mu=0.3,k_stretch=100");
  Require(std::isfinite(noise) && noise >= 0.0, "--noise: expected a number >= 0, relative to the cloth's size");
  Require(starts_per_axis >= 2 && starts_per_axis % 2 == 0, "--starts: expected an even number >= 2");
  Require(num_threads >= 1, "--threads: expected a number >= 1");
  Require(!methods.empty(), "--methods: expected at least one method");
  for (const std::string& method : methods) CheckMethod(method);
}

void RunJacobianFit(const RecordedMotion& motion, const std::vector<TrueParameter>& truth, FitPrecision precision,
                    JacobianFit* fit, const std::function<void(const FitIteration&)>& on_iteration) {
  const double start = ThreadSeconds();
  FitOptions options = MakeFitOptions(truth, precision, *fit);
  options.on_iteration = on_iteration;
  FitProblem problem({motion}, options);
  const FitSummary summary = Fit(options, &problem);
  fit->seconds = ThreadSeconds() - start;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    fit->value[i] = summary.has_estimate() ? summary.parameters[i].value : kNaN;
  }
  fit->cost = summary.has_estimate() ? summary.cost : kInfinity;
  fit->num_iterations = summary.num_iterations();
  fit->rollouts = summary.statistics.rollouts;
  fit->sweeps = summary.statistics.sweeps;
  fit->failed_steps = summary.statistics.counts.failed_steps;
  fit->status = summary.status;
  fit->message = summary.message;
}

void JudgeFits(const std::vector<TrueParameter>& truth, std::vector<JacobianFit>::iterator begin,
               std::vector<JacobianFit>::iterator end) {
  const JacobianFit best =
      *std::min_element(begin, end, [](const JacobianFit& a, const JacobianFit& b) { return a.cost < b.cost; });
  for (auto fit = begin; fit != end; ++fit) {
    if (fit->noise == 0.0) {
      fit->reached = IsNear(fit->value, {truth[0].value, truth[1].value}, kTruthTolerance);
    } else {
      fit->reached =
          fit->cost - best.cost <= kCostTolerance * best.cost && IsNear(fit->value, best.value, kParameterTolerance);
    }
  }
}

JacobianBenchmark RunJacobianBenchmark(const JacobianBenchmarkOptions& options) {
  options.Validate();
  const std::string scene_text = ReadFile(options.scene_path, kMaxJsonBytes);
  const std::string folder = std::filesystem::path(options.scene_path).parent_path().string();
  const Scene scene = ParseScene(scene_text, options.scene_path, folder);
  const std::vector<TrueParameter> truth = MakeTrueParameters(options.truth, scene);
  const Rollout rollout = SimulateTruth(truth, options.scene_path, scene);

  std::vector<double> noises = {0.0};
  if (options.noise > 0.0) noises.push_back(options.noise);
  JacobianBenchmark benchmark;
  benchmark.names = {truth[0].name, truth[1].name};
  benchmark.methods = options.methods;
  std::vector<RecordedMotion> recordings;
  for (const double noise : noises) {
    SyntheticOptions synthetic;
    synthetic.noise_sigma = noise * ClothSize(scene.mesh);
    synthetic.seed = options.seed;
    recordings.push_back(MakeRecording(rollout, scene, scene_text, synthetic));
    const std::vector<JacobianFit> fits = PlanFits(options, truth, noise);
    benchmark.fits.insert(benchmark.fits.end(), fits.begin(), fits.end());
  }
  RunFits(options, recordings, truth, &benchmark.fits);
  const auto fits_per_recording = static_cast<std::ptrdiff_t>(benchmark.fits.size() / recordings.size());
  for (auto begin = benchmark.fits.begin(); begin != benchmark.fits.end(); begin += fits_per_recording) {
    JudgeFits(truth, begin, begin + fits_per_recording);
  }
  return benchmark;
}

std::string JacobianTable(const JacobianBenchmark& benchmark) {
  std::ostringstream out;
  std::size_t longest = 11;
  for (const std::string& method : benchmark.methods) longest = std::max(longest, method.size());
  const int width = static_cast<int>(longest) + 2;
  out << std::left << std::setw(width) << "method" << std::right
      << "  noise    reached  rollouts   max  sweeps  failed steps   seconds  to sensitivity\n";
  std::vector<double> noises;
  for (const JacobianFit& fit : benchmark.fits) {
    if (noises.empty() || noises.back() != fit.noise) noises.push_back(fit.noise);
  }
  for (const double noise : noises) {
    for (const std::string& method : benchmark.methods) WriteTableRow(benchmark, noise, method, width, out);
  }
  return out.str();
}

std::string JacobianCsv(const JacobianBenchmark& benchmark) {
  std::ostringstream out;
  out << std::setprecision(std::numeric_limits<double>::max_digits10);
  const auto& [first, second] = benchmark.names;
  out << "start_" << first << ",start_" << second << ",method,noise," << first << "," << second
      << ",cost,reached,iterations,rollouts,sweeps,failed_steps,status,seconds\n";
  for (const JacobianFit& fit : benchmark.fits) {
    out << fit.start[0] << "," << fit.start[1] << "," << fit.method << "," << fit.noise << "," << fit.value[0] << ","
        << fit.value[1] << "," << fit.cost << "," << fit.reached << "," << fit.num_iterations << "," << fit.rollouts
        << "," << fit.sweeps << "," << fit.failed_steps << "," << FitStatusName(fit.status) << "," << fit.seconds
        << "\n";
  }
  return out.str();
}

}  // namespace clothid
