#include "tools/benchmark/fits/coverage_table.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <limits>
#include <sstream>

namespace clothid {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

bool HasInterval(const CoverageFit& fit, std::size_t i) { return !std::isnan(fit.std[i]); }

// NaN where no start was estimated.
double KnownStartStd(const CoverageFit& fit, std::size_t i) {
  return i < fit.known_start_std.size() ? fit.known_start_std[i] : kNaN;
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
    summary.mean_width = summary.mean_std = summary.mean_error_ratio = summary.mean_start_ratio = kNaN;
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

// With so many digits behind the point; "-" for NaN.
std::string Fixed(double value, int digits) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(digits) << value;
  return std::isnan(value) ? "-" : text.str();
}

// With four digits; "-" for NaN.
std::string Number(double value) {
  std::ostringstream text;
  text << std::setprecision(4) << value;
  return std::isnan(value) ? "-" : text.str();
}

// `first`: that of the same parameter in the first setting.
void PrintLine(const CoverageSummary& summary, const CoverageSummary& first, std::ostream& out) {
  const std::string covered = std::to_string(summary.num_covered) + " of " + std::to_string(summary.num_fits);
  out << std::left << std::setw(9) << summary.setting << std::setw(12) << summary.name << std::right << std::setw(10)
      << covered << std::setw(7) << Fixed(summary.mean_width / first.mean_width, 2) << std::setw(15)
      << Number(summary.mean_std) << std::setw(15) << Number(summary.empirical_std) << std::setw(7)
      << Fixed(summary.std_ratio(), 2) << std::setw(11) << Fixed(summary.bias / summary.empirical_std, 2);
}

// The column of intervals that count with the discretisation.
void PrintNoise(const CoverageSummary& summary, std::ostream& out) {
  const std::string covered = std::to_string(summary.num_covered_by_noise) + " of " + std::to_string(summary.num_fits);
  out << std::setw(16) << covered;
}

// The columns of a start that is not the scene's.
void PrintStart(const CoverageSummary& summary, std::ostream& out) {
  out << std::setw(9) << summary.num_refused << std::setw(20) << Fixed(summary.mean_error_ratio, 2) << std::setw(24)
      << Fixed(summary.mean_start_ratio, 2) << std::setw(10) << Fixed(summary.mean_rollouts, 1);
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

std::string CoverageTable(const CoverageBenchmark& benchmark) {
  const bool has_start_columns = benchmark.start != StartSource::kScene;
  std::ostringstream out;
  out << "setting  parameter      covered  width   reported std  empirical std  ratio  bias, std";
  if (benchmark.discretization.any()) out << "  by noise alone";
  if (has_start_columns) out << "  refused  bias, reported std  width over known start  rollouts";
  out << "\n";
  const std::vector<CoverageSummary> summaries = SummarizeCoverage(benchmark);
  for (std::size_t i = 0; i < summaries.size(); ++i) {
    PrintLine(summaries[i], summaries[i % benchmark.truth.size()], out);
    if (benchmark.discretization.any()) PrintNoise(summaries[i], out);
    if (has_start_columns) PrintStart(summaries[i], out);
    out << "\n";
  }
  return out.str();
}

std::string CoverageCsv(const CoverageBenchmark& benchmark) {
  const bool has_start_columns = benchmark.start != StartSource::kScene;
  std::ostringstream out;
  out << std::setprecision(std::numeric_limits<double>::max_digits10) << "setting,seed";
  for (const TrueParameter& parameter : benchmark.truth) {
    const std::string& name = parameter.name;
    out << "," << name << ",std_" << name << ",lower95_" << name << ",upper95_" << name;
    if (has_start_columns) out << ",known_start_std_" << name << ",error_over_std_" << name;
  }
  out << ",rmse_m,rollouts,status\n";
  for (const CoverageFit& fit : benchmark.fits) {
    out << fit.setting << "," << fit.seed;
    for (std::size_t i = 0; i < fit.value.size(); ++i) {
      out << "," << fit.value[i] << "," << fit.std[i] << "," << fit.lower95[i] << "," << fit.upper95[i];
      if (!has_start_columns) continue;
      out << "," << KnownStartStd(fit, i) << "," << ErrorOverStd(fit, benchmark.truth[i], i);
    }
    out << "," << fit.rmse << "," << fit.rollouts << "," << FitStatusName(fit.status) << "\n";
  }
  return out.str();
}

}  // namespace clothid
