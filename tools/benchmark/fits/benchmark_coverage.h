// benchmark coverage: do the intervals of a fit contain the truth as often as they say?
//
// A rollout with known parameters is seen again and again with noise of its own, each time fitted from start values
// that are off by a factor, and the intervals at the solution (identify/uncertainty/uncertainty.h) are held against the
// truth and against the scatter of the estimates; all that under several settings of the sensor. With a sensor.json the
// truth is finer than the model, and recordings have the faults of a laboratory's (tools/benchmark/fits/sensor_case.h).
// Or the fit is not told the scene's start and takes it from the recording, or estimates it
// (tools/benchmark/fits/imported_recording.h). Or the truth has finer steps and a finer mesh than the model, and the
// intervals count with what that does to the estimates (identify/checks/discretization_check.h).
// tools/benchmark/fits/coverage_table.h sums fits up.
#ifndef CLOTHID_TOOLS_BENCHMARK_FITS_BENCHMARK_COVERAGE_H_
#define CLOTHID_TOOLS_BENCHMARK_FITS_BENCHMARK_COVERAGE_H_

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "datasets/synthetic/true_recording.h"
#include "identify/fit/fit.h"
#include "tools/benchmark/fits/imported_recording.h"
#include "tools/benchmark/fits/sampled_truth.h"

namespace clothid {

// Every point in every frame, one frame per step; every point missing from a frame with a chance of one half; every
// third frame.
inline const std::vector<std::string> kCoverageSettings = {"full", "half", "third"};

// Start over truth where nothing else is said: many standard deviations off, and near enough for three rollouts a fit.
inline constexpr double kStartFactor = 1.05;

// One fit. Depends on the options alone.
struct CoverageFit {
  std::string setting;
  std::uint64_t seed = 0;
  std::vector<double> value, std, lower95, upper95;  // per parameter; NaN where there are none
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
  double start_factor = kStartFactor;  // start over truth of the parameters
  int num_seeds = 40;                  // recordings per setting
  std::uint64_t seed = 1;              // the first
  int num_threads = 1;                 // fits side by side; results do not depend on it
  // After every fit, in the order in which they end; never two at a time. May be empty.
  std::function<void(const CoverageFit& fit, int num_done, int num_fits)> on_fit;

  // Throws `Error` (kUsage) naming the first flag out of range.
  void Validate() const;
};

struct CoverageBenchmark {
  DiscretizationParts discretization;       // what the intervals count with
  StartSource start = StartSource::kScene;  // of the fits
  std::vector<TrueParameter> truth;
  std::vector<CoverageFit> fits;  // by setting, then seed
};

// Throws `Error` for options and scenes that cannot be used and where the rollout with the true parameters fails.
CoverageBenchmark RunCoverageBenchmark(const CoverageOptions& options);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_FITS_BENCHMARK_COVERAGE_H_
