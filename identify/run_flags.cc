#include "identify/run_flags.h"

#include "datasets/fabric/scene_with_fabric.h"
#include "identify/checks/holdout.h"
#include "identify/export/export.h"
#include "sim/fabric/fabric.h"

namespace clothid {
namespace {

FitOptions ParseFitFlags(const RunFlags& flags) {
  FitOptions options;
  options.parameters = ParseNames(flags.fit, "--fit");
  options.each = ParseNames(flags.each, "--each");
  options.wind_smoothness = flags.wind_smoothness;
  options.fields = ParseFieldRequests(flags.field);
  options.field_weight = flags.field_weight;
  options.overrides.start = ParseParameterValues(flags.start, "--start");
  options.overrides.lower_bounds = ParseParameterValues(flags.lower, "--lower");
  options.overrides.upper_bounds = ParseParameterValues(flags.upper, "--upper");
  options.overrides.priors = ParseParameterPriors(flags.prior, "--prior");
  options.jacobian = ParseJacobianMethod(flags.jacobian);
  options.adjoint = ParseAdjointOptions(flags.adjoint);
  options.precision = ParseFitPrecision(flags.precision);
  options.assimilate = ParseAssimilation(flags.assimilate);
  options.loss = ParseRobustLoss(flags.loss);
  options.max_iterations = flags.max_iterations;
  options.num_threads = flags.threads;
  options.num_starts = flags.starts;
  options.seed = flags.seed;
  return options;
}

void ParseFabric(const std::string& fabric, RunOptions* options) {
  if (fabric.empty()) return;
  if (!IsFabricCard(fabric)) {
    options->reading.change_scene = [fabric](const std::string& text) {
      return WithFabric(text, fabric, "--fabric", "the scene");
    };
    return;
  }
  options->fabric_card = fabric;
  options->reading.change_scene = [card = ReadToldCard(fabric)](const std::string& text) {
    return WithFabricCard(text, card, "the scene");
  };
}

void ParseReading(const RunFlags& flags, ReadMotionOptions* reading) {
  reading->scene_path = flags.scene;
  reading->start = ParseStartSource(flags.initial);
  ParseSigma(flags.sigma, reading);
}

}  // namespace

RunOptions ParseRunFlags(const RunFlags& flags) {
  RunOptions options;
  options.target_paths = ParseNames(flags.target, "--target");
  options.repeat = flags.repeat;
  options.transfer = flags.transfer;
  options.holdout_paths = ParseNames(flags.holdout, "--holdout");
  options.holdout_draws = flags.holdout_draws;
  options.calibrates_bands = flags.calibrate_bands;
  if (!flags.holdout_frames.empty()) {
    options.holdout_frames = ParseFrameRange(flags.holdout_frames, "--holdout_frames");
  }
  ParseReading(flags, &options.reading);
  ParseFabric(flags.fabric, &options);
  options.time_step = ParseTimeStep(flags.time_step);
  options.step_tolerance = flags.step_tolerance;
  options.fit = ParseFitFlags(flags);
  options.fit.growing_horizon = ParseHorizon(flags.horizon);
  options.wind = ParseWindRequest(flags.wind_profile);
  options.check_recordings = flags.check;
  options.check_gradients = flags.check_gradients;
  options.profiles = ParseNames(flags.profile, "--profile");
  options.discretization = ParseDiscretization(flags.discretization);
  options.landscape_paths = ParseNames(flags.landscape, "--landscape");
  options.output = flags.output;
  options.report_page = flags.report;
  options.simulators = ParseSimulators(flags.exports, "--export");
  options.resume = flags.resume;
  return options;
}

}  // namespace clothid
