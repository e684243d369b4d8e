#include "tools/benchmark/fits/benchmark_coverage.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "identify/base/parallel_for.h"
#include "identify/run.h"
#include "identify/uncertainty/uncertainty.h"
#include "sim/base/json_document.h"
#include "sim/base/text_file.h"
#include "sim/scene/scene_json.h"
#include "tools/benchmark/fits/sensor_case.h"

namespace clothid {
namespace {

constexpr char kTimeOffset[] = "time_offset";

const std::vector<std::string>& KnownSettings(const CoverageOptions& options) {
  if (!options.sensor_path.empty()) return kSensorSettings;
  return options.unknowns.wind.is_given() ? kWindSettings : kCoverageSettings;
}

SyntheticOptions SensorOptions(const CoverageOptions& options, const CoverageFit& fit, const Scene& scene) {
  SyntheticOptions synthetic;
  synthetic.noise_sigma = options.sigma ? *options.sigma : options.noise * ClothSize(scene.mesh);
  synthetic.num_markers = options.num_markers;
  synthetic.seed = fit.seed;
  if (options.frame_rate) synthetic.frame_rate = *options.frame_rate;
  if (options.force_sigma) synthetic.force_sensor.emplace().sigma = *options.force_sigma;
  if (fit.setting == "half") synthetic.drop_fraction = 0.5;
  if (fit.setting == "third") {
    synthetic.frame_rate = options.frame_rate ? *options.frame_rate / 3.0 : 1.0 / (3.0 * scene.time_step);
  }
  return synthetic;
}

std::string FolderOf(const std::string& path) { return std::filesystem::path(path).parent_path().string(); }

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
      : options_(options),
        scene_(scene),
        known_text_(WithoutTruth(options.unknowns, scene_text)),
        known_scene_(ParseScene(known_text_, options.scene_path, FolderOf(options.scene_path))) {
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
    if (!is_exact) return ImportRollout(options_.import, rollout_, scene_, known_text_, synthetic);
    RecordedMotion motion = MakeRecording(rollout_, scene_, known_text_, synthetic);
    motion.scene = known_scene_;
    return motion;
  }

 private:
  const CoverageOptions& options_;
  const Scene& scene_;            // the truth
  const std::string known_text_;  // what a fit is told of it
  const Scene known_scene_;
  Rollout rollout_;
  std::optional<SensorCase> sensor_case_;
};

// Asks for the unknowns that are no parameters.
void FitUnknowns(const HiddenUnknowns& unknowns, RunOptions* run) {
  run->fit.fields = unknowns.fields;
  run->wind = unknowns.wind;
}

// How `benchmark coverage` fits. The parameters of `truth`, which come first, are asked for by name.
RunOptions OptionsOfFit(const std::vector<TrueParameter>& truth, const CoverageOptions& coverage,
                        const std::string& setting) {
  RunOptions run;
  run.check_recordings = false;
  run.fit.growing_horizon = false;
  run.discretization = coverage.discretization;
  run.fit.jacobian = JacobianMethod::kSensitivity;
  run.fit.check_interval = false;
  run.fit.loss = LossOfSetting(setting);
  for (const TrueParameter& parameter : truth) {
    if (UnknownsOf(parameter.name) != parameter.name) continue;
    run.fit.parameters.push_back(parameter.name);
    if (parameter.name != kTimeOffset)
      run.fit.overrides.start[parameter.name] = coverage.start_factor * parameter.value;
  }
  FitUnknowns(coverage.unknowns, &run);
  return run;
}

// What a fit says of the next of its unknowns.
struct FittedUnknown {
  double value = kNoNumber;
  double noise_lower95 = kNoNumber, noise_upper95 = kNoNumber;
  ParameterUncertainty uncertainty;
};

void AddUnknown(const FittedUnknown& unknown, CoverageFit* fit) {
  fit->value.push_back(unknown.value);
  fit->std.push_back(unknown.uncertainty.std);
  fit->lower95.push_back(unknown.uncertainty.lower95);
  fit->upper95.push_back(unknown.uncertainty.upper95);
  fit->noise_lower95.push_back(unknown.noise_lower95);
  fit->noise_upper95.push_back(unknown.noise_upper95);
  fit->known_start_std.push_back(unknown.uncertainty.known_start_std);
}

// The parameter `name`, knots among them. `noise`: before discretization was looked at.
FittedUnknown FindParameter(const std::string& name, const FitSummary& summary,
                            const std::optional<Uncertainty>& noise) {
  FittedUnknown unknown;
  for (std::size_t i = 0; i < summary.parameters.size(); ++i) {
    if (summary.parameters[i].name != name) continue;
    unknown.value = summary.parameters[i].value;
    if (summary.uncertainty) unknown.uncertainty = summary.uncertainty->parameters[i];
    if (!noise) continue;
    unknown.noise_lower95 = noise->parameters[i].lower95;
    unknown.noise_upper95 = noise->parameters[i].upper95;
  }
  return unknown;
}

void AddNodes(const FittedField& field, CoverageFit* fit) {
  for (Eigen::Index r = 0; r < field.values.rows(); ++r) {
    for (Eigen::Index c = 0; c < field.values.cols(); ++c) {
      FittedUnknown node;
      node.value = field.values(r, c);
      const double log_std = field.log_std.size() > 0 ? field.log_std(r, c) : kNoNumber;
      node.uncertainty.std = node.value * log_std;
      node.uncertainty.lower95 = node.noise_lower95 = node.value * std::exp(-kNormal95 * log_std);
      node.uncertainty.upper95 = node.noise_upper95 = node.value * std::exp(kNormal95 * log_std);
      AddUnknown(node, fit);
    }
  }
}

void RunCoverageFit(const std::vector<TrueParameter>& truth, const CoverageOptions& coverage, RecordedMotion recording,
                    CoverageFit* fit) {
  RunOptions run = OptionsOfFit(truth, coverage, fit->setting);
  run.targets = {std::move(recording)};
  std::optional<Uncertainty> noise;
  int rollouts = 0;  // of the fit alone
  run.on_fitted = [&](const FitSummary& summary) {
    noise = summary.uncertainty;
    rollouts = summary.statistics.rollouts;
  };
  RunResult result = Identify(run);
  FitSummary& summary = result.summary;
  const bool has_own_steps = coverage.resolution.steps == 1 && !coverage.discretization.any();
  if (has_own_steps) {  // the truth is of the steps of the model, which have no error then
    summary.uncertainty = noise;
    summary.statistics.rollouts = rollouts;
  }
  std::size_t num_nodes = 0;
  for (const FieldRequest& request : coverage.unknowns.fields) num_nodes += static_cast<std::size_t>(request.size());
  for (std::size_t i = 0; i < truth.size() - num_nodes; ++i) {
    AddUnknown(FindParameter(truth[i].name, summary, noise), fit);
  }
  if (summary.fields) {
    for (const FittedField& field : summary.fields->fields) AddNodes(field, fit);
  }
  while (fit->value.size() < truth.size()) AddUnknown({}, fit);
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
  const bool is_finer = options.resolution.steps > 1 || options.resolution.levels > 0;
  ExpectUsage(!options.force_sigma || (std::isfinite(*options.force_sigma) && *options.force_sigma > 0.0),
              "--force_sigma: expected a number > 0 in N");
  ExpectUsage(!options.force_sigma || !is_finer,
              "--force_sigma: expected without --truth_steps and --truth_levels, of which the forces are not known");
  if (options.sensor_path.empty()) return;
  for (const auto& [is_given, flag] :
       {std::pair(options.sigma.has_value(), "--sigma"), std::pair(options.frame_rate.has_value(), "--frame_rate"),
        std::pair(options.num_markers > 0, "--markers"), std::pair(options.resolution.steps > 1, "--truth_steps"),
        std::pair(options.resolution.levels > 0, "--truth_levels"),
        std::pair(options.import.handle_sigma > 0.0, "--handle_sigma"),
        std::pair(options.force_sigma.has_value(), "--force_sigma"),
        std::pair(!options.unknowns.fields.empty(), "--field"),
        std::pair(options.unknowns.wind.is_given(), "--wind_profile"),
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
  const Scene scene = ParseScene(scene_text, options.scene_path, FolderOf(options.scene_path));
  ExpectTruth(options.unknowns, scene);
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
  if (options.unknowns.any()) {
    const Eigen::VectorXd times = recorder.Record(benchmark.fits.front()).times;
    for (const TrueParameter& unknown : TrueUnknowns(options.unknowns, benchmark.truth, scene, times)) {
      benchmark.truth.push_back(unknown);
    }
  }
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
