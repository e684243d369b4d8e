#include "tools/benchmark/derivatives/benchmark_backprop.h"

#include <algorithm>
#include <utility>

#include "tools/benchmark/base/timing.h"

namespace clothid {
namespace {

std::vector<BackpropMethod> SelectBackpropMethods(const std::vector<std::string>& names) {
  std::vector<BackpropMethod> selected;
  for (const BackpropMethod& method : BackpropMethods()) {
    if (names.empty() || std::find(names.begin(), names.end(), method.name) != names.end()) selected.push_back(method);
  }
  return selected;
}

// The sweep counts its phases in wall time; other work on the machine stretches all of them alike.
BackpropSample MakeSample(const AdjointWork& work, double thread_seconds) {
  const double share = thread_seconds / work.total_seconds;
  return {thread_seconds, share * (work.phases.factorization + work.phases.solution), share * work.phases.assembly,
          share * work.phases.contact, share * work.fallback_seconds};
}

void MeasureBackprop(const BackpropMethod& method, const RolloutGradient& reference, BackpropCase* backprop,
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
std::vector<BackpropResult> RunBackpropCase(const BackpropOptions& options, BackpropCase* backprop) {
  const std::vector<BackpropMethod> methods = SelectBackpropMethods(options.methods);
  const RolloutGradient reference = backprop->Differentiate({AdjointMethod::kLu});
  std::vector<BackpropResult> results(methods.size());
  for (int repeat = 0; repeat < options.num_repeats; ++repeat) {
    const double start = ThreadSeconds();
    backprop->SimulateAgain();
    const double rollout_seconds = ThreadSeconds() - start;
    for (std::size_t i = 0; i < methods.size(); ++i) {
      results[i].name = backprop->name();
      results[i].method = methods[i].name;
      results[i].rollout_seconds.push_back(rollout_seconds);
      MeasureBackprop(methods[i], reference, backprop, &results[i]);
    }
  }
  return results;
}

template <typename Value>
std::vector<double> Collect(const BackpropResult& result, Value value) {
  std::vector<double> values;
  for (const BackpropSample& sample : result.samples) values.push_back(value(sample));
  return values;
}

std::vector<double> Totals(const BackpropResult& result) {
  return Collect(result, [](const BackpropSample& s) { return s.total; });
}

// Median over the repetitions of numerator/denominator, "-" where there are none.
std::string MedianRatio(const std::vector<double>& numerators, const std::vector<double>& denominators) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < numerators.size(); ++i) ratios.push_back(numerators[i] / denominators[i]);
  return ratios.empty() ? "-" : FixedNumber(MedianOfRuns(std::move(ratios)), 2);
}

// "-" where the reference did not take part.
std::string SpeedUp(const BackpropBenchmark& benchmark, const BackpropResult& result) {
  for (const BackpropResult& other : benchmark.results) {
    if (other.name.ToString() == result.name.ToString() && other.method == kReferenceDirect) {
      return MedianRatio(Totals(other), Totals(result));
    }
  }
  return "-";
}

std::string BackpropTableRow(const BackpropBenchmark& benchmark, const BackpropResult& result) {
  const auto milliseconds = [&result](auto value) {
    return 1e3 / result.name.num_steps * MedianOfRuns(Collect(result, value));
  };
  const double fallback = MedianOfRuns(
      Collect(result, [](const BackpropSample& s) { return 100.0 * s.fallback / (s.total - s.fallback); }));
  return Format("%-7s%-10s%5d  %-16s", result.name.scene.c_str(), result.name.setting.c_str(), result.name.nodes,
                result.method.c_str()) +
         Format("%9.2f%9.2f%7.2f%7.2f%7.2f", milliseconds([](const BackpropSample& s) { return s.total; }),
                milliseconds([](const BackpropSample& s) { return s.linear_solve; }),
                milliseconds([](const BackpropSample& s) { return s.assembly; }),
                milliseconds([](const BackpropSample& s) { return s.contact; }),
                milliseconds([](const BackpropSample& s) { return s.other(); })) +
         Format("%8.1f%8.1f%10.1f%9.1e%9s%7s%10s\n", result.iterations, 100.0 * result.failed_share, fallback,
                result.gradient_error, SpeedUp(benchmark, result).c_str(),
                MedianRatio(result.block_seconds, Totals(result)).c_str(),
                MedianRatio(Totals(result), result.rollout_seconds).c_str());
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
  std::vector<std::string> known;
  for (const BackpropMethod& method : BackpropMethods()) known.push_back(method.name);
  if (!methods.empty()) RequireKnown(methods, known, "--methods");
  ExpectUsage(num_repeats >= 1, "--repeats: expected a number >= 1");
}

BackpropBenchmark RunBackpropBenchmark(const BackpropOptions& options) {
  options.Validate();
  BackpropBenchmark benchmark;
  ForEachCase(options.cases, [&](BackpropCase* backprop) {
    for (BackpropResult& result : RunBackpropCase(options, backprop)) benchmark.results.push_back(std::move(result));
  });
  return benchmark;
}

std::string BackpropTable(const BackpropBenchmark& benchmark) {
  std::string table =
      "                                      ms per step                                       failed  fallback "
      "   worst   faster  8 rhs\n"
      "scene  setting   nodes  method              total   linear     dP     dR  other   iter.       %   % extra "
      "   error  umfpack   to 1 / rollout\n";
  for (const BackpropResult& result : benchmark.results) table += BackpropTableRow(benchmark, result);
  return table;
}

std::string BackpropCsv(const BackpropBenchmark& benchmark) {
  std::string csv =
      "scene,setting,nodes,steps,method,repeat,iterations_per_step,failed_share,gradient_error,"
      "total_s,linear_solve_s,dP_s,dR_s,other_s,fallback_s,block_s,rollout_s\n";
  for (const BackpropResult& result : benchmark.results) {
    const BackpropCaseName& name = result.name;
    for (std::size_t i = 0; i < result.samples.size(); ++i) {
      const BackpropSample& sample = result.samples[i];
      csv += CsvLine(name.scene, name.setting, name.nodes, name.num_steps, result.method, i + 1, result.iterations,
                     result.failed_share, result.gradient_error, sample.total, sample.linear_solve, sample.assembly,
                     sample.contact, sample.other(), sample.fallback,
                     i < result.block_seconds.size() ? GeneralNumber(result.block_seconds[i], 17) : "",
                     result.rollout_seconds[i]);
    }
  }
  return csv;
}

}  // namespace clothid
