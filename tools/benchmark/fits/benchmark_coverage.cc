#include "tools/benchmark/fits/benchmark_coverage.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iomanip>
#include <limits>
#include <optional>
#include <sstream>

#include "identify/base/parallel_for.h"
#include "identify/fit/problem.h"
#include "identify/uncertainty/uncertainty.h"
#include "sim/base/error.h"
#include "sim/base/json_document.h"
#include "sim/base/text_file.h"
#include "sim/scene/scene_json.h"
#include "tools/benchmark/fits/sensor_case.h"

namespace clothid {
namespace {

constexpr char kTimeOffset[] = "time_offset";
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

void Require(bool condition, const std::string& message) {
  if (!condition) throw Error(ErrorKind::kUsage, message);
}

const std::vector<std::string>& KnownSettings(const CoverageOptions& options) {
  return options.sensor_path.empty() ? kCoverageSettings : kSensorSettings;
}

SyntheticOptions SensorOptions(const CoverageOptions& options, const CoverageFit& fit, const Scene& scene) {
  SyntheticOptions synthetic;
  synthetic.noise_sigma = options.noise * ClothSize(scene.mesh);
  synthetic.seed = fit.seed;
  if (fit.setting == "half") synthetic.drop_fraction = 0.5;
  if (fit.setting == "third") synthetic.frame_rate = 1.0 / (3.0 * scene.time_step);
  return synthetic;
}

// Makes the recording of a fit: of a rollout of the scene, with white noise, or of a finer one, by a sensor.
class Recorder {
 public:
  Recorder(const CoverageOptions& options, const std::vector<TrueParameter>& truth, const Scene& scene,
           const std::string& scene_text)
      : options_(options), scene_(scene), scene_text_(scene_text) {
    if (options.sensor_path.empty()) {
      rollout_ = SimulateTruth(truth, options.scene_path, scene);
    } else {
      sensor_case_ = ReadSensorCase(options.scene_path, options.sensor_path, truth);
    }
  }

  RecordedMotion Record(const CoverageFit& fit) const {
    if (sensor_case_) return RecordSensorCase(*sensor_case_, fit.setting, fit.seed);
    return MakeRecording(rollout_, scene_, scene_text_, SensorOptions(options_, fit, scene_));
  }

 private:
  const CoverageOptions& options_;
  const Scene& scene_;
  const std::string& scene_text_;
  Rollout rollout_;
  std::optional<SensorCase> sensor_case_;
};

void RunFit(const std::vector<TrueParameter>& truth, const RecordedMotion& recording, CoverageFit* fit) {
  FitOptions options;
  options.jacobian = JacobianMethod::kSensitivity;
  options.check_interval = false;
  options.loss = LossOfSetting(fit->setting);
  for (const TrueParameter& parameter : truth) {
    options.parameters.push_back(parameter.name);
    if (parameter.name != kTimeOffset) options.overrides.start[parameter.name] = kStartFactor * parameter.value;
  }
  FitProblem problem({recording}, options);
  const FitSummary summary = Fit(options, &problem);
  std::vector<ParameterUncertainty> uncertainty(truth.size());
  if (summary.uncertainty) uncertainty = summary.uncertainty->parameters;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    fit->value.push_back(summary.has_estimate() ? summary.parameters[i].value : kNaN);
    fit->std.push_back(uncertainty[i].std);
    fit->lower95.push_back(uncertainty[i].lower95);
    fit->upper95.push_back(uncertainty[i].upper95);
  }
  fit->rmse = summary.has_estimate() ? summary.error.rmse() : kNaN;
  fit->rollouts = summary.statistics.rollouts;
  fit->status = summary.status;
}

// Of parameter i over the fits of one setting.
CoverageSummary Summarize(const std::vector<CoverageFit>& fits, const TrueParameter& parameter, std::size_t i) {
  CoverageSummary summary;
  summary.setting = fits.front().setting;
  summary.name = parameter.name;
  summary.num_fits = static_cast<int>(fits.size());
  double mean = 0.0, squares = 0.0;
  const auto num_intervals = static_cast<double>(
      std::count_if(fits.begin(), fits.end(), [&](const CoverageFit& fit) { return !std::isnan(fit.std[i]); }));
  for (const CoverageFit& fit : fits) {
    mean += fit.value[i] / summary.num_fits;
    if (!std::isnan(fit.std[i])) summary.mean_std += fit.std[i] / num_intervals;
    if (!std::isnan(fit.std[i])) summary.mean_width += (fit.upper95[i] - fit.lower95[i]) / num_intervals;
    summary.num_covered += fit.lower95[i] <= parameter.value && parameter.value <= fit.upper95[i];
  }
  for (const CoverageFit& fit : fits) squares += std::pow(fit.value[i] - mean, 2);
  summary.empirical_std = std::sqrt(squares / (summary.num_fits - 1));
  summary.bias = mean - parameter.value;
  return summary;
}

}  // namespace

void CoverageOptions::Validate() const {
  Require(!scene_path.empty(), "--scene is missing; see benchmark --help");
  Require(!truth.empty(), "--set: expected at least one parameter, as in mu=0.3,k_stretch=100");
  Require(std::isfinite(noise) && noise > 0.0, "--noise: expected a number > 0, relative to the cloth's size");
  Require(num_seeds >= 2, "--seeds: expected a number >= 2");
  Require(num_threads >= 1, "--threads: expected a number >= 1");
  const std::vector<std::string>& known = KnownSettings(*this);
  for (const std::string& setting : settings) {
    Require(std::find(known.begin(), known.end(), setting) != known.end(),
            "--settings: '" + Printable(setting) + "': expected " +
                (sensor_path.empty() ? "full, half or third" : "clean, faults, huber, outliers or markers"));
  }
}

CoverageBenchmark RunCoverageBenchmark(const CoverageOptions& options) {
  options.Validate();
  const std::string scene_text = ReadFile(options.scene_path, kMaxJsonBytes);
  const std::string folder = std::filesystem::path(options.scene_path).parent_path().string();
  const Scene scene = ParseScene(scene_text, options.scene_path, folder);
  CoverageBenchmark benchmark;
  benchmark.truth = MakeTrueParameters(options.truth, scene);
  const Recorder recorder(options, benchmark.truth, scene, scene_text);
  if (!options.sensor_path.empty()) benchmark.truth.push_back({kTimeOffset, kClockError, false});
  for (const std::string& setting : options.settings.empty() ? KnownSettings(options) : options.settings) {
    for (int i = 0; i < options.num_seeds; ++i) {
      CoverageFit fit;
      fit.setting = setting;
      fit.seed = options.seed + static_cast<std::uint64_t>(i);
      benchmark.fits.push_back(fit);
    }
  }
  const int num_fits = static_cast<int>(benchmark.fits.size());
  ParallelFor(
      num_fits, options.num_threads,
      [&](int i) {
        CoverageFit* fit = &benchmark.fits[i];
        RunFit(benchmark.truth, recorder.Record(*fit), fit);
      },
      [&](int i, int num_done) {
        if (options.on_fit) options.on_fit(benchmark.fits[i], num_done, num_fits);
      });
  return benchmark;
}

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
  std::ostringstream out;
  out << "setting  parameter      covered  width   reported std  empirical std  ratio  bias, std\n";
  const std::vector<CoverageSummary> summaries = SummarizeCoverage(benchmark);
  for (std::size_t i = 0; i < summaries.size(); ++i) {
    const CoverageSummary &summary = summaries[i], &first = summaries[i % benchmark.truth.size()];
    std::ostringstream covered;
    covered << summary.num_covered << " of " << summary.num_fits;
    out << std::left << std::setw(9) << summary.setting << std::setw(12) << summary.name << std::right << std::setw(10)
        << covered.str() << std::fixed << std::setprecision(2) << std::setw(7) << summary.mean_width / first.mean_width
        << std::defaultfloat << std::setprecision(4) << std::setw(15) << summary.mean_std << std::setw(15)
        << summary.empirical_std << std::fixed << std::setprecision(2) << std::setw(7) << summary.std_ratio()
        << std::setw(11) << summary.bias / summary.empirical_std << std::defaultfloat << "\n";
  }
  return out.str();
}

std::string CoverageCsv(const CoverageBenchmark& benchmark) {
  std::ostringstream out;
  out << std::setprecision(std::numeric_limits<double>::max_digits10) << "setting,seed";
  for (const TrueParameter& parameter : benchmark.truth) {
    const std::string& name = parameter.name;
    out << "," << name << ",std_" << name << ",lower95_" << name << ",upper95_" << name;
  }
  out << ",rmse_m,rollouts,status\n";
  for (const CoverageFit& fit : benchmark.fits) {
    out << fit.setting << "," << fit.seed;
    for (std::size_t i = 0; i < fit.value.size(); ++i) {
      out << "," << fit.value[i] << "," << fit.std[i] << "," << fit.lower95[i] << "," << fit.upper95[i];
    }
    out << "," << fit.rmse << "," << fit.rollouts << "," << FitStatusName(fit.status) << "\n";
  }
  return out.str();
}

}  // namespace clothid
