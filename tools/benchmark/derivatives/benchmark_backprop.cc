#include "tools/benchmark/derivatives/benchmark_backprop.h"

#include <algorithm>
#include <iomanip>
#include <limits>
#include <sstream>
#include <utility>

#include "sim/base/error.h"
#include "tools/benchmark/base/timing.h"

namespace clothid {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::vector<std::string> MethodNames() {
  std::vector<std::string> names;
  for (const BackpropMethod& method : BackpropMethods()) names.push_back(method.name);
  return names;
}

std::vector<BackpropMethod> SelectMethods(const std::vector<std::string>& names) {
  std::vector<BackpropMethod> selected;
  for (const BackpropMethod& method : BackpropMethods()) {
    if (names.empty() || std::find(names.begin(), names.end(), method.name) != names.end()) selected.push_back(method);
  }
  return selected;
}

// The sweep counts its phases in wall time; other work on the machine stretches all of them alike.
BackpropSample MakeSample(const AdjointWork& work, double thread_seconds) {
  const double share = thread_seconds / work.total_seconds;
  BackpropSample sample;
  sample.total = thread_seconds;
  sample.linear_solve = share * (work.phases.factorization + work.phases.solution);
  sample.assembly = share * work.phases.assembly;
  sample.contact = share * work.phases.contact;
  sample.fallback = share * work.fallback_seconds;
  return sample;
}

void Measure(const BackpropMethod& method, const RolloutGradient& reference, BackpropCase* backprop,
             BackpropResult* result) {
  double start = ThreadSeconds();
  const RolloutGradient gradient = backprop->Differentiate(method.options);
  result->samples.push_back(MakeSample(gradient.work, ThreadSeconds() - start));
  result->iterations = static_cast<double>(gradient.work.iterations) / gradient.work.solves;
  result->failed_share = static_cast<double>(gradient.work.failed_solves) / gradient.work.solves;
  result->gradient_error = backprop->Compare(gradient, reference).Worst();
  if (!method.with_block) return;
  start = ThreadSeconds();
  backprop->Differentiate(method.options, kBlockColumns);
  result->block_seconds.push_back(ThreadSeconds() - start);
}

// All methods on one rollout.
std::vector<BackpropResult> RunCase(const BackpropOptions& options, BackpropCase* backprop) {
  const std::vector<BackpropMethod> methods = SelectMethods(options.methods);
  const RolloutGradient reference = backprop->Differentiate({AdjointMethod::kLu});
  std::vector<BackpropResult> results;
  for (const BackpropMethod& method : methods) {
    BackpropResult& result = results.emplace_back();
    result.name = backprop->name();
    result.method = method.name;
  }
  for (int repeat = 0; repeat < options.num_repeats; ++repeat) {
    const double start = ThreadSeconds();
    backprop->SimulateAgain();
    const double rollout_seconds = ThreadSeconds() - start;
    for (std::size_t i = 0; i < methods.size(); ++i) {
      results[i].rollout_seconds.push_back(rollout_seconds);
      Measure(methods[i], reference, backprop, &results[i]);
    }
  }
  return results;
}

template <typename Value>
double MedianOf(const BackpropResult& result, Value value) {
  std::vector<double> values;
  for (const BackpropSample& sample : result.samples) values.push_back(value(sample));
  return Median(std::move(values));
}

// Median over the repetitions of numerator/denominator.
double MedianRatio(const std::vector<double>& numerators, const std::vector<double>& denominators) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < numerators.size(); ++i) ratios.push_back(numerators[i] / denominators[i]);
  return Median(std::move(ratios));
}

std::vector<double> Totals(const BackpropResult& result) {
  std::vector<double> totals;
  for (const BackpropSample& sample : result.samples) totals.push_back(sample.total);
  return totals;
}

// NaN where `reference` did not take part.
double SpeedUp(const BackpropBenchmark& benchmark, const BackpropResult& result, const std::string& reference) {
  for (const BackpropResult& other : benchmark.results) {
    if (other.name == result.name && other.method == reference) return MedianRatio(Totals(other), Totals(result));
  }
  return kNaN;
}

void WriteTableRow(const BackpropBenchmark& benchmark, const BackpropResult& result, std::ostream& out) {
  const auto milliseconds = [&result](auto value) {
    return FixedNumber(1e3 / result.name.num_steps * MedianOf(result, value), 2);
  };
  const double fallback =
      MedianOf(result, [](const BackpropSample& s) { return 100.0 * s.fallback / (s.total - s.fallback); });
  const double block = result.block_seconds.empty() ? kNaN : MedianRatio(result.block_seconds, Totals(result));
  out << std::left << std::setw(7) << result.name.scene << std::setw(10) << result.name.setting << std::right
      << std::setw(5) << result.name.nodes << "  " << std::left << std::setw(16) << result.method << std::right
      << std::setw(9) << milliseconds([](const BackpropSample& s) { return s.total; }) << std::setw(9)
      << milliseconds([](const BackpropSample& s) { return s.linear_solve; }) << std::setw(7)
      << milliseconds([](const BackpropSample& s) { return s.assembly; }) << std::setw(7)
      << milliseconds([](const BackpropSample& s) { return s.contact; }) << std::setw(7)
      << milliseconds([](const BackpropSample& s) { return s.other(); }) << std::setw(8)
      << FixedNumber(result.iterations, 1) << std::setw(8) << FixedNumber(100.0 * result.failed_share, 1)
      << std::setw(10) << FixedNumber(fallback, 1) << std::setw(9) << std::scientific << std::setprecision(1)
      << result.gradient_error << std::setw(9) << FixedNumber(SpeedUp(benchmark, result, kReferenceDirect), 2)
      << std::setw(7) << FixedNumber(block, 2) << std::setw(10)
      << FixedNumber(MedianRatio(Totals(result), result.rollout_seconds), 2) << "\n";
}

}  // namespace

const std::vector<BackpropMethod>& BackpropMethods() {
  static const std::vector<BackpropMethod> methods = {
      {kReferenceDirect, {AdjointMethod::kLu}},
      {"fixed_point:1e-4", {AdjointMethod::kFixedPoint, 1e-4}},
      {"fixed_point:1e-6", {AdjointMethod::kFixedPoint, 1e-6}},
      {"gmres:1e-4", {AdjointMethod::kSystemGmres, 1e-4}},
      {"gmres:1e-6", {AdjointMethod::kSystemGmres, 1e-6}},
      {"reduced", {AdjointMethod::kReduced, {}, /*use_kept_factors=*/false}, /*with_block=*/true},
      {"kept", {AdjointMethod::kReduced}, /*with_block=*/true},
  };
  return methods;
}

void BackpropOptions::Validate() const {
  cases.Validate();
  if (!methods.empty()) RequireKnown(methods, MethodNames(), "--methods");
  if (num_repeats < 1) throw Error(ErrorKind::kUsage, "--repeats: expected a number >= 1");
}

BackpropBenchmark RunBackpropBenchmark(const BackpropOptions& options) {
  options.Validate();
  BackpropBenchmark benchmark;
  ForEachCase(options.cases, [&](BackpropCase* backprop) {
    const std::vector<BackpropResult> results = RunCase(options, backprop);
    benchmark.results.insert(benchmark.results.end(), results.begin(), results.end());
  });
  return benchmark;
}

std::string BackpropTable(const BackpropBenchmark& benchmark) {
  std::ostringstream out;
  out << "                                      ms per step                                       failed  fallback "
         "   worst   faster  8 rhs\n"
         "scene  setting   nodes  method              total   linear     dP     dR  other   iter.       %   % extra "
         "   error  umfpack   to 1 / rollout\n";
  for (const BackpropResult& result : benchmark.results) WriteTableRow(benchmark, result, out);
  return out.str();
}

std::string BackpropCsv(const BackpropBenchmark& benchmark) {
  std::ostringstream out;
  out << std::setprecision(std::numeric_limits<double>::max_digits10)
      << "scene,setting,nodes,steps,method,repeat,iterations_per_step,failed_share,gradient_error,"
         "total_s,linear_solve_s,dP_s,dR_s,other_s,fallback_s,block_s,rollout_s\n";
  for (const BackpropResult& result : benchmark.results) {
    for (std::size_t i = 0; i < result.samples.size(); ++i) {
      const BackpropSample& sample = result.samples[i];
      out << result.name.scene << "," << result.name.setting << "," << result.name.nodes << "," << result.name.num_steps
          << "," << result.method << "," << i + 1 << "," << result.iterations << "," << result.failed_share << ","
          << result.gradient_error << "," << sample.total << "," << sample.linear_solve << "," << sample.assembly << ","
          << sample.contact << "," << sample.other() << "," << sample.fallback << ",";
      if (!result.block_seconds.empty()) out << result.block_seconds[i];
      out << "," << result.rollout_seconds[i] << "\n";
    }
  }
  return out.str();
}

}  // namespace clothid
