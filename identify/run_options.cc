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
  // Fields and the check of gradients take reverse sweeps whatever the Jacobian does.
  const bool has_sweeps = fit.jacobian == JacobianMethod::kAdjoint || check_gradients || !fields.empty();
  ExpectUsage(has_sweeps || (fit.adjoint.method == AdjointMethod::kReduced && !fit.adjoint.threshold),
              "--adjoint: expected with --jacobian adjoint");
  ExpectUsage(simulators.empty() || !output.empty(), "--export: expected with --output");
  ValidateFields();
  ValidateWind();
}

void RunOptions::ValidateWind() const {
  if (!wind.is_given()) return;
  ExpectUsage(fields.empty(), "--wind_profile: expected without --field");
  for (const auto& [name, prior] : fit.overrides.priors) {
    ExpectUsage(!FindKnot(name), "--prior: knots of --wind_profile are believed to change little; expected none of '" +
                                     name + "'; see --wind_smoothness");
  }
  if (fit.wind_smoothness > 0.0) return;
  const std::string hint = ", which several fits choose";
  ExpectUsage(!resume, "--resume: expected with --wind_smoothness" + hint);
  ExpectUsage(fit.num_starts == 1, "--starts: expected with --wind_smoothness" + hint);
  ExpectUsage(!time_step.is_automatic, "--time_step: expected with --wind_smoothness" + hint);
}

void RunOptions::ValidateFields() const {
  ExpectUsage(field_weight >= 0.0 && std::isfinite(field_weight), "--field_weight: expected a number > 0");
  ExpectUsage(field_weight == 0.0 || !fields.empty(), "--field_weight: expected with --field");
  if (fields.empty()) return;
  ExpectUsage(!resume, "--resume: expected without --field, whose evaluations no journal keeps");
  ExpectUsage(fit.num_starts == 1, "--starts: expected without --field, which starts once");
  ExpectUsage(profiles.empty(), "--profile: expected without --field, which a profile would hold");
  ExpectUsage(!discretization.any(), "--discretization: expected without --field, which is not fitted again");
  ExpectUsage(!time_step.is_automatic, "--time_step: expected without --field, which is not fitted again");
}

}  // namespace clothid
