#include "tools/benchmark/fits/benchmark_coverage.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "identify/base/parallel_for.h"
#include "identify/checks/discretization_check.h"
#include "identify/fit/problem.h"
#include "identify/uncertainty/uncertainty.h"
#include "sim/base/json_document.h"
#include "sim/base/text_file.h"
#include "sim/scene/scene_json.h"
#include "tools/benchmark/fits/sensor_case.h"

namespace clothid {
namespace {

constexpr char kTimeOffset[] = "time_offset";

const std::vector<std::string>& KnownSettings(const CoverageOptions& options) {
  return options.sensor_path.empty() ? kCoverageSettings : kSensorSettings;
}

SyntheticOptions SensorOptions(const CoverageOptions& options, const CoverageFit& fit, const Scene& scene) {
  SyntheticOptions synthetic;
  synthetic.noise_sigma = options.sigma ? *options.sigma : options.noise * ClothSize(scene.mesh);
  synthetic.num_markers = options.num_markers;
  synthetic.seed = fit.seed;
  if (options.frame_rate) synthetic.frame_rate = *options.frame_rate;
  if (fit.setting == "half") synthetic.drop_fraction = 0.5;
  if (fit.setting == "third") {
    synthetic.frame_rate = options.frame_rate ? *options.frame_rate / 3.0 : 1.0 / (3.0 * scene.time_step);
  }
  return synthetic;
}

// The fits to come, by setting, then seed.
std::vector<CoverageFit> PlanCoverageFits(const CoverageOptions& options) {
  std::vector<CoverageFit> fits;
  for (const std::string& setting : options.settings.empty() ? KnownSettings(options) : options.settings) {
    for (int i = 0; i < options.num_seeds; ++i) {
      CoverageFit fit;
      fit.setting = setting;
      fit.seed = options.seed + static_cast<std::uint64_t>(i);
      fits.push_back(fit);
    }
  }
  return fits;
}

// Makes the recording of a fit: of a rollout of the scene, with white noise, or of a finer one, by a sensor.
class Recorder {
 public:
  Recorder(const CoverageOptions& options, const std::vector<TrueParameter>& truth, const Scene& scene,
           const std::string& scene_text)
      : options_(options), scene_(scene), scene_text_(scene_text) {
    if (options.sensor_path.empty()) {
      rollout_ = SampleTruth(truth, options.scene_path, scene, options.resolution);
    } else {
      sensor_case_ = ReadSensorCase(options.scene_path, options.sensor_path, truth);
    }
  }

  RecordedMotion Record(const CoverageFit& fit) const {
    if (sensor_case_) return RecordSensorCase(*sensor_case_, fit.setting, fit.seed);
    const SyntheticOptions synthetic = SensorOptions(options_, fit, scene_);
    const bool is_exact = options_.import.start == StartSource::kScene && options_.num_markers == 0;
    return is_exact ? MakeRecording(rollout_, scene_, scene_text_, synthetic)
                    : ImportRollout(options_.import, rollout_, scene_, scene_text_, synthetic);
  }

 private:
  const CoverageOptions& options_;
  const Scene& scene_;
  const std::string& scene_text_;
  Rollout rollout_;
  std::optional<SensorCase> sensor_case_;
};

void RunCoverageFit(const std::vector<TrueParameter>& truth, const CoverageOptions& coverage,
                    const RecordedMotion& recording, CoverageFit* fit) {
  FitOptions options;
  options.jacobian = JacobianMethod::kSensitivity;
  options.check_interval = false;
  options.loss = LossOfSetting(fit->setting);
  for (const TrueParameter& parameter : truth) {
    options.parameters.push_back(parameter.name);
    if (parameter.name != kTimeOffset)
      options.overrides.start[parameter.name] = coverage.start_factor * parameter.value;
  }
  FitProblem problem({recording}, options);
  FitSummary summary = Fit(options, &problem);
  std::vector<ParameterUncertainty> noise(truth.size());
  if (summary.uncertainty) noise = summary.uncertainty->parameters;
  if (coverage.discretization.any() && summary.has_estimate()) {
    CheckDiscretization({recording}, options, coverage.discretization, problem, &summary);
  }
  std::vector<ParameterUncertainty> uncertainty(truth.size());
  if (summary.uncertainty) uncertainty = summary.uncertainty->parameters;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    fit->value.push_back(summary.has_estimate() ? summary.parameters[i].value : kNoNumber);
    fit->std.push_back(uncertainty[i].std);
    fit->lower95.push_back(uncertainty[i].lower95);
    fit->upper95.push_back(uncertainty[i].upper95);
    fit->noise_lower95.push_back(noise[i].lower95);
    fit->noise_upper95.push_back(noise[i].upper95);
    fit->known_start_std.push_back(uncertainty[i].known_start_std);
  }
  fit->rmse = summary.has_estimate() ? summary.error.rmse() : kNoNumber;
  fit->rollouts = summary.statistics.rollouts;
  fit->status = summary.status;
}

// What is asked of recordings that are made without a sensor.
void RequireRecordings(const CoverageOptions& options) {
  const StartSource start = options.import.start;
  ExpectUsage(!options.sigma || (std::isfinite(*options.sigma) && *options.sigma > 0.0),
              "--sigma: expected a number > 0 in m");
  ExpectUsage(!options.frame_rate || (std::isfinite(*options.frame_rate) && *options.frame_rate > 0.0),
              "--frame_rate: expected a number > 0 in Hz");
  ExpectUsage(options.num_markers >= 0, "--markers: expected a number >= 0; 0: all nodes");
  ExpectUsage(options.num_markers == 0 || start != StartSource::kFirstFrame,
              "--markers: a first frame of markers shows no start; expected --initial scene, smoothed, rest or moving");
  ExpectUsage(std::isfinite(options.import.cut) && options.import.cut >= 0.0, "--cut: expected a number >= 0 in s");
  ExpectUsage(options.import.cut == 0.0 || start != StartSource::kScene,
              "--cut: the scene's start is not that of a recording that begins later; expected another --initial");
  ExpectUsage(std::isfinite(options.import.handle_sigma) && options.import.handle_sigma >= 0.0,
              "--handle_sigma: expected a number >= 0 in m");
  ExpectUsage(options.resolution.steps >= 1, "--truth_steps: expected a number >= 1");
  ExpectUsage(options.resolution.levels >= 0, "--truth_levels: expected a number >= 0");
  if (options.sensor_path.empty()) return;
  for (const auto& [is_given, flag] :
       {std::pair(options.sigma.has_value(), "--sigma"), std::pair(options.frame_rate.has_value(), "--frame_rate"),
        std::pair(options.num_markers > 0, "--markers"), std::pair(options.resolution.steps > 1, "--truth_steps"),
        std::pair(options.resolution.levels > 0, "--truth_levels"),
        std::pair(options.import.handle_sigma > 0.0, "--handle_sigma"),
        std::pair(start != StartSource::kScene, "--initial")}) {
    ExpectUsage(!is_given, flag + std::string(": expected without --sensor, whose recordings have their own"));
  }
}

}  // namespace

void CoverageOptions::Validate() const {
  ExpectUsage(!scene_path.empty(), "--scene is missing; see benchmark --help");
  ExpectUsage(!truth.empty(), "--set: expected at least one parameter, as in mu=0.3,k_stretch=100");
  ExpectUsage(std::isfinite(noise) && noise > 0.0, "--noise: expected a number > 0, relative to the cloth's size");
  ExpectUsage(num_seeds >= 2, "--seeds: expected a number >= 2");
  ExpectUsage(num_threads >= 1, "--threads: expected a number >= 1");
  ExpectUsage(std::isfinite(start_factor) && start_factor > 0.0, "--start_factor: expected a number > 0");
  if (!settings.empty()) RequireKnown(settings, KnownSettings(*this), "--settings");
  RequireRecordings(*this);
}

CoverageBenchmark RunCoverageBenchmark(const CoverageOptions& options) {
  options.Validate();
  const std::string scene_text = ReadFile(options.scene_path, kMaxJsonBytes);
  const std::string folder = std::filesystem::path(options.scene_path).parent_path().string();
  const Scene scene = ParseScene(scene_text, options.scene_path, folder);
  CoverageBenchmark benchmark;
  benchmark.start = options.import.start;
  benchmark.discretization = options.discretization;
  benchmark.truth = MakeTrueParameters(options.truth, scene);
  benchmark.fits = PlanCoverageFits(options);
  if (options.sensor_path.empty()) {
    for (const CoverageFit& fit : benchmark.fits) {
      if (fit.seed == options.seed) CheckImport(options.import, SensorOptions(options, fit, scene), scene, scene_text);
    }
  }
  const Recorder recorder(options, benchmark.truth, scene, scene_text);
  if (!options.sensor_path.empty()) benchmark.truth.push_back({kTimeOffset, kClockError, false});
  const int num_fits = static_cast<int>(benchmark.fits.size());
  ParallelFor(
      num_fits, options.num_threads,
      [&](int i) {
        CoverageFit* fit = &benchmark.fits[i];
        RunCoverageFit(benchmark.truth, options, recorder.Record(*fit), fit);
      },
      [&](int i, int num_done) {
        if (!options.on_progress) return;
        const CoverageFit& fit = benchmark.fits[i];
        options.on_progress(Format("%s, seed %d: %s, %d rollouts", fit.setting.c_str(), static_cast<int>(fit.seed),
                                   FitStatusName(fit.status).c_str(), fit.rollouts),
                            num_done, num_fits);
      });
  return benchmark;
}

}  // namespace clothid
