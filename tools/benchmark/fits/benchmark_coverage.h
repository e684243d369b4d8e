// benchmark coverage: do the intervals of a fit contain the truth as often as they say?
//
// A rollout with known parameters is seen again and again with noise of its own, each time fitted from start values
// that are off by a factor, and the intervals at the solution (identify/uncertainty/uncertainty.h) are held against the
// truth and against the scatter of the estimates; all that under several settings of the sensor. With a sensor.json the
// truth is finer than the model, and recordings have the faults of a laboratory's (tools/benchmark/fits/sensor_case.h).
// Or the fit is not told the scene's start and takes it from the recording, or estimates it
// (tools/benchmark/fits/imported_recording.h). Or the truth has finer steps and a finer mesh than the model, and the
// intervals count with what that does to the estimates (identify/checks/discretization_check.h). Or the fit has more
// unknowns: fields, and a wind that changes (tools/benchmark/fits/coverage_truth.h).
#ifndef CLOTHID_TOOLS_BENCHMARK_FITS_BENCHMARK_COVERAGE_H_
#define CLOTHID_TOOLS_BENCHMARK_FITS_BENCHMARK_COVERAGE_H_

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "datasets/synthetic/true_recording.h"
#include "identify/fit/fit.h"
#include "tools/benchmark/base/common.h"
#include "tools/benchmark/fits/coverage_truth.h"
#include "tools/benchmark/fits/imported_recording.h"

namespace clothid {

// Every point in every frame, one frame per step; every point missing from a frame with a chance of one half; every
// third frame. The last frame of `third` may be another one: not with a wind, whose knots lie between first and last.
inline const std::vector<std::string> kCoverageSettings = {"full", "half", "third"}, kWindSettings = {"full", "half"};

// Start over truth where nothing else is said: many standard deviations off, and near enough for three rollouts a fit.
inline constexpr double kStartFactor = 1.05;

// One fit. Depends on the options alone.
struct CoverageFit {
  std::string setting;
  std::uint64_t seed = 0;
  std::vector<double> value, std, lower95, upper95;  // as `CoverageBenchmark::truth`; NaN where there are none
  std::vector<double> noise_lower95, noise_upper95;  // the interval of the noise alone; see `discretization`
  std::vector<double> known_start_std;               // the std if the start were known; NaN where none was estimated
  double rmse = 0.0;                                 // m
  int rollouts = 0;
  FitStatus status = FitStatus::kFailed;
};

struct CoverageOptions {
  std::string scene_path;
  std::map<std::string, double> truth;  // the parameters to be fitted; all others have the scene's nominal value
  // sensor.json; empty: none. With one the clock is fitted, too (`time_offset`, from 0), and `noise` is not used.
  std::string sensor_path;
  std::vector<std::string> settings;  // empty: all, `kCoverageSettings` or with a sensor `kSensorSettings`
  double noise = 0.01;                // standard deviation on every coordinate, relative to the cloth's size
  // Of the recordings; with a sensor, which has its own, none of these four.
  std::optional<double> sigma;         // m, in place of `noise`
  std::optional<double> frame_rate;    // Hz; absent: one frame per step
  int num_markers = 0;                 // free nodes seen, other ones with every seed; 0: all nodes
  ImportOfRollout import;              // where the fit takes the start from, and how much of the motion went before it
  TruthResolution resolution;          // of the truth; without a sensor, from the scene's own start
  DiscretizationParts discretization;  // what the intervals count with besides the noise
  // Without a sensor. What the fits have for unknowns besides: the truth is in the scene, and they are not told.
  HiddenUnknowns unknowns;
  std::optional<double> force_sigma;   // N: of a gauge that holds all handles, read in every frame; absent: none
  double start_factor = kStartFactor;  // start over truth of the parameters
  int num_seeds = 40;                  // recordings per setting
  std::uint64_t seed = 1;              // the first
  int num_threads = 1;                 // fits side by side; results do not depend on it
  BenchmarkProgress on_progress;       // after every fit

  // Throws `Error` (kUsage) naming the first flag out of range.
  void Validate() const;
};

struct CoverageBenchmark {
  DiscretizationParts discretization;       // what the intervals count with
  StartSource start = StartSource::kScene;  // of the fits
  std::vector<TrueParameter> truth;         // parameters, then knots of a wind and control nodes of fields
  std::vector<CoverageFit> fits;            // by setting, then seed
};

// Throws `Error` for options and scenes that cannot be used and where the rollout with the true parameters fails.
CoverageBenchmark RunCoverageBenchmark(const CoverageOptions& options);

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

// The same with all knots of a component of the wind as one, and all control nodes of a field: the sums of their
// counts, the means of all else, of empirical standard deviations the root of the mean square.
std::vector<CoverageSummary> GroupCoverage(const std::vector<CoverageSummary>& summaries);

// One line per setting and parameter; widths relative to the first setting, biases in empirical standard deviations.
// Where intervals count with the discretisation it goes on with how many of the noise alone contain the truth; where
// the scene's start was not used, with refused intervals, biases in reported standard deviations, these
// over those of a known start, and rollouts per fit.
std::string CoverageTable(const CoverageBenchmark& benchmark);

// One row per fit. Where the scene's start was not used with two more columns per parameter: its std if the start were
// known, and (estimate - truth)/std.
std::string CoverageCsv(const CoverageBenchmark& benchmark);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_FITS_BENCHMARK_COVERAGE_H_
