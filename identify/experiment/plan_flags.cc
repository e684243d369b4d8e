#include "identify/experiment/plan_flags.h"

#include "identify/base/options.h"
#include "sim/scene/parameters.h"

namespace clothid {

PlanOptions ParsePlanFlags(const PlanFlags& flags) {
  PlanOptions options;
  options.scene_paths = ParseNames(flags.scenes, "--scenes");
  options.predicted_path = flags.predict;
  options.fit.parameters = ParseNames(flags.fit, "--fit");
  options.fit.each = ParseNames(flags.each, "--each");
  options.fit.overrides.start = ParseParameterValues(flags.start, "--start");
  options.fit.overrides.lower_bounds = ParseParameterValues(flags.lower, "--lower");
  options.fit.overrides.upper_bounds = ParseParameterValues(flags.upper, "--upper");
  options.fit.overrides.priors = ParseParameterPriors(flags.prior, "--prior");
  options.fit.num_threads = flags.threads;
  options.sigma = flags.sigma;
  options.frame_rate = flags.frame_rate;
  options.num_markers = flags.markers;
  options.has_forces = flags.forces;
  options.force_sigma = flags.force_sigma;
  options.handle_sigma = flags.handle_sigma;
  options.start = flags.initial == "scene" ? StartSource::kScene : ParseStartSource(flags.initial);
  options.num_draws = flags.draws;
  options.seed = flags.seed;
  options.output = flags.output;
  return options;
}

}  // namespace clothid
