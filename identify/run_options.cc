// What of the options of a run goes with what.
#include <cmath>
#include <string>

#include "identify/base/knot_names.h"
#include "identify/run.h"

namespace clothid {

void RunOptions::Validate() const {
  fit.Validate();
  ExpectUsage(step_tolerance >= 0.0 && std::isfinite(step_tolerance), "--step_tolerance: expected a number > 0");
  ExpectUsage(!target_paths.empty() || !targets.empty(), "--target: expected a recording");
  ExpectUsage(target_paths.empty() || targets.empty(), "targets: expected without target_paths");
  ExpectUsage(holdout_paths.empty() || holdouts.empty(), "holdouts: expected without holdout_paths");
  ExpectUsage(!holdout_frames || (holdout_paths.empty() && holdouts.empty()),
              "--holdout_frames: expected without --holdout");
  ExpectUsage(landscape_paths.empty() || (report_page && !output.empty()),
              "--landscape: is shown in report.html; expected without --report=false");
  ExpectUsage(!resume || !output.empty(), "--resume: expected with --output");
  ExpectUsage(fit.seed == 0 || fit.num_starts > 1, "--seed: expected with --starts, whose points it chooses");
  ExpectUsage(simulators.empty() || !output.empty(), "--export: expected with --output");
  ExpectUsage(fit.field_weight == 0.0 || !fit.fields.empty(), "--field_weight: expected with --field");
  for (const auto& [name, prior] : fit.overrides.priors) {
    ExpectUsage(!wind.is_given() || !FindKnot(name),
                "--prior: knots of --wind_profile are believed to change little; "
                "expected none of '" +
                    name + "'; see --wind_smoothness");
  }
}

}  // namespace clothid
