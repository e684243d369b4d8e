// The text of `benchmark coverage`.
#include <algorithm>
#include <cmath>

#include "tools/benchmark/fits/benchmark_coverage.h"

namespace clothid {
namespace {

bool HasInterval(const CoverageFit& fit, std::size_t i) { return !std::isnan(fit.std[i]); }

// NaN where no start was estimated.
double KnownStartStd(const CoverageFit& fit, std::size_t i) {
  return i < fit.known_start_std.size() ? fit.known_start_std[i] : kNoNumber;
}

bool IsCoveredByNoise(const CoverageFit& fit, std::size_t i, double truth) {
  return i < fit.noise_lower95.size() && fit.noise_lower95[i] <= truth && truth <= fit.noise_upper95[i];
}

double ErrorOverStd(const CoverageFit& fit, const TrueParameter& parameter, std::size_t i) {
  return (fit.value[i] - parameter.value) / fit.std[i];
}

// Of parameter i over the fits of one setting.
CoverageSummary Summarize(const std::vector<CoverageFit>& fits, const TrueParameter& parameter, std::size_t i) {
  CoverageSummary summary;
  summary.setting = fits.front().setting;
  summary.name = parameter.name;
  summary.num_fits = static_cast<int>(fits.size());
  double mean = 0.0, squares = 0.0;
  const auto num_intervals = static_cast<double>(
      std::count_if(fits.begin(), fits.end(), [&](const CoverageFit& fit) { return HasInterval(fit, i); }));
  summary.num_refused = summary.num_fits - static_cast<int>(num_intervals);
  if (num_intervals == 0) {
    summary.mean_width = summary.mean_std = summary.mean_error_ratio = summary.mean_start_ratio = kNoNumber;
  }
  for (const CoverageFit& fit : fits) {
    mean += fit.value[i] / summary.num_fits;
    summary.mean_rollouts += static_cast<double>(fit.rollouts) / summary.num_fits;
    if (!HasInterval(fit, i)) continue;
    summary.mean_std += fit.std[i] / num_intervals;
    summary.mean_width += (fit.upper95[i] - fit.lower95[i]) / num_intervals;
    summary.mean_error_ratio += ErrorOverStd(fit, parameter, i) / num_intervals;
    summary.mean_start_ratio += fit.std[i] / KnownStartStd(fit, i) / num_intervals;
    summary.num_covered_by_noise += IsCoveredByNoise(fit, i, parameter.value);
    summary.num_covered += fit.lower95[i] <= parameter.value && parameter.value <= fit.upper95[i];
  }
  for (const CoverageFit& fit : fits) squares += std::pow(fit.value[i] - mean, 2);
  summary.empirical_std = std::sqrt(squares / (summary.num_fits - 1));
  summary.bias = mean - parameter.value;
  return summary;
}

// Adds one more of a group.
void AddToGroup(const CoverageSummary& summary, CoverageSummary* group) {
  const double share = static_cast<double>(summary.num_fits) / (group->num_fits + summary.num_fits);
  const auto mean = [share](double other, double* value) { *value += share * (other - *value); };
  mean(summary.mean_width, &group->mean_width);
  mean(summary.mean_std, &group->mean_std);
  mean(summary.bias, &group->bias);
  mean(summary.mean_error_ratio, &group->mean_error_ratio);
  mean(summary.mean_start_ratio, &group->mean_start_ratio);
  mean(summary.mean_rollouts, &group->mean_rollouts);
  double variance = std::pow(group->empirical_std, 2);
  mean(std::pow(summary.empirical_std, 2), &variance);
  group->empirical_std = std::sqrt(variance);
  group->num_fits += summary.num_fits;
  group->num_covered += summary.num_covered;
  group->num_covered_by_noise += summary.num_covered_by_noise;
  group->num_refused += summary.num_refused;
}

std::string OfFits(int count, const CoverageSummary& summary) {
  return std::to_string(count) + " of " + std::to_string(summary.num_fits);
}

// `first`: that of the same parameter in the first setting.
std::string CoverageLine(const CoverageSummary& summary, const CoverageSummary& first) {
  return Format("%-9s%-12s%10s%7s%15s%15s%7s%11s", summary.setting.c_str(), summary.name.c_str(),
                OfFits(summary.num_covered, summary).c_str(),
                FixedNumber(summary.mean_width / first.mean_width, 2).c_str(), GeneralNumber(summary.mean_std).c_str(),
                GeneralNumber(summary.empirical_std).c_str(), FixedNumber(summary.std_ratio(), 2).c_str(),
                FixedNumber(summary.bias / summary.empirical_std, 2).c_str());
}

// The columns of a start that is not the scene's.
std::string StartColumns(const CoverageSummary& summary) {
  return Format("%9d%20s%24s%10s", summary.num_refused, FixedNumber(summary.mean_error_ratio, 2).c_str(),
                FixedNumber(summary.mean_start_ratio, 2).c_str(), FixedNumber(summary.mean_rollouts, 1).c_str());
}

}  // namespace

std::vector<CoverageSummary> SummarizeCoverage(const CoverageBenchmark& benchmark) {
  std::vector<CoverageSummary> summaries;
  for (auto begin = benchmark.fits.begin(); begin != benchmark.fits.end();) {
    const auto end = std::find_if(begin, benchmark.fits.end(),
                                  [&](const CoverageFit& fit) { return fit.setting != begin->setting; });
    for (std::size_t i = 0; i < benchmark.truth.size(); ++i) {
      summaries.push_back(Summarize({begin, end}, benchmark.truth[i], i));
    }
    begin = end;
  }
  return summaries;
}

std::vector<CoverageSummary> GroupCoverage(const std::vector<CoverageSummary>& summaries) {
  std::vector<CoverageSummary> groups;
  for (const CoverageSummary& summary : summaries) {
    const std::string name = UnknownsOf(summary.name);
    if (!groups.empty() && groups.back().name == name && groups.back().setting == summary.setting) {
      AddToGroup(summary, &groups.back());
      continue;
    }
    groups.push_back(summary);
    groups.back().name = name;
  }
  return groups;
}

std::string CoverageTable(const CoverageBenchmark& benchmark) {
  const bool has_start_columns = benchmark.start != StartSource::kScene;
  std::string table = "setting  parameter      covered  width   reported std  empirical std  ratio  bias, std";
  if (benchmark.discretization.any()) table += "  by noise alone";
  if (has_start_columns) table += "  refused  bias, reported std  width over known start  rollouts";
  table += "\n";
  const std::vector<CoverageSummary> summaries = GroupCoverage(SummarizeCoverage(benchmark));
  for (const CoverageSummary& summary : summaries) {
    const auto first = std::find_if(summaries.begin(), summaries.end(),
                                    [&](const CoverageSummary& each) { return each.name == summary.name; });
    table += CoverageLine(summary, *first);
    if (benchmark.discretization.any()) {
      table += Format("%16s", OfFits(summary.num_covered_by_noise, summary).c_str());
    }
    if (has_start_columns) table += StartColumns(summary);
    table += "\n";
  }
  return table;
}

std::string CoverageCsv(const CoverageBenchmark& benchmark) {
  const bool has_start_columns = benchmark.start != StartSource::kScene;
  std::string csv = "setting,seed";
  for (const TrueParameter& parameter : benchmark.truth) {
    const std::string& name = parameter.name;
    csv += "," + name + ",std_" + name + ",lower95_" + name + ",upper95_" + name;
    if (has_start_columns) csv += ",known_start_std_" + name + ",error_over_std_" + name;
  }
  csv += ",rmse_m,rollouts,status\n";
  for (const CoverageFit& fit : benchmark.fits) {
    std::string values;
    for (std::size_t i = 0; i < fit.value.size(); ++i) {
      std::string value = CsvLine(fit.value[i], fit.std[i], fit.lower95[i], fit.upper95[i]);
      if (has_start_columns) {
        value.back() = ',';
        value += CsvLine(KnownStartStd(fit, i), ErrorOverStd(fit, benchmark.truth[i], i));
      }
      value.back() = ',';
      values += value;
    }
    csv += CsvLine(fit.setting, fit.seed, values.substr(0, values.size() - 1), fit.rmse, fit.rollouts,
                   FitStatusName(fit.status));
  }
  return csv;
}

}  // namespace clothid
