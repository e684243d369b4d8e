// What the fits of `benchmark coverage` say together: per setting and parameter how many intervals contain the truth,
// and the standard deviations beside the scatter and the errors of the estimates. As a table and as CSV.
#ifndef CLOTHID_TOOLS_BENCHMARK_FITS_COVERAGE_TABLE_H_
#define CLOTHID_TOOLS_BENCHMARK_FITS_COVERAGE_TABLE_H_

#include <string>
#include <vector>

#include "tools/benchmark/fits/benchmark_coverage.h"

namespace clothid {

// Of one setting and parameter.
struct CoverageSummary {
  std::string setting, name;
  int num_fits = 0;
  int num_covered = 0;           // intervals that contain the truth; a fit without one is not among them
  int num_covered_by_noise = 0;  // likewise by the intervals of the noise alone, where others were looked at
  int num_refused = 0;           // fits without an interval
  double mean_width = 0.0;       // of the 95 % intervals
  double mean_std = 0.0;         // reported
  double empirical_std = 0.0;    // of the estimates about their mean
  double bias = 0.0;             // mean estimate - truth
  // Means over the fits with an interval, as width and reported std are; NaN where there are none.
  double mean_error_ratio = 0.0;  // of (estimate - truth)/std, each fit with the std that it reports
  double mean_start_ratio = 0.0;  // of std/known_start_std: what not knowing the start costs
  double mean_rollouts = 0.0;     // per fit, of all

  double coverage() const { return static_cast<double>(num_covered) / num_fits; }
  double std_ratio() const { return mean_std / empirical_std; }
};

// By setting, then parameter. A value that a fit does not have is NaN, and so is what depends on it.
std::vector<CoverageSummary> SummarizeCoverage(const CoverageBenchmark& benchmark);

// One line per setting and parameter; widths relative to the first setting, biases in empirical standard deviations.
// Where intervals count with the discretisation it goes on with how many of the noise alone contain the truth; where
// the scene's start was not used, with refused intervals, biases in reported standard deviations, these
// over those of a known start, and rollouts per fit.
std::string CoverageTable(const CoverageBenchmark& benchmark);

// One row per fit. Where the scene's start was not used with two more columns per parameter: its std if the start were
// known, and (estimate - truth)/std.
std::string CoverageCsv(const CoverageBenchmark& benchmark);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_FITS_COVERAGE_TABLE_H_
