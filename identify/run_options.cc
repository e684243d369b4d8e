// What of the options of a run goes with what.
#include <cmath>
#include <string>

#include "identify/base/knot_names.h"
#include "identify/run.h"

namespace clothid {
namespace {

void Expect(bool condition, const std::string& message) {
  if (!condition) throw Error(ErrorKind::kUsage, message);
}

}  // namespace

void RunOptions::Validate() const {
  fit.Validate();
  Expect(step_tolerance >= 0.0 && std::isfinite(step_tolerance), "--step_tolerance: expected a number > 0");
  Expect(!target_paths.empty() || !targets.empty(), "--target: expected a recording");
  Expect(target_paths.empty() || targets.empty(), "targets: expected without target_paths");
  Expect(holdout_paths.empty() || holdouts.empty(), "holdouts: expected without holdout_paths");
  Expect(!holdout_frames || (holdout_paths.empty() && holdouts.empty()),
         "--holdout_frames: expected without --holdout");
  Expect(landscape_paths.empty() || (report_page && !output.empty()),
         "--landscape: is shown in report.html; expected without --report=false");
  Expect(!resume || !output.empty(), "--resume: expected with --output");
  Expect(simulators.empty() || !output.empty(), "--export: expected with --output");
  ValidateFields();
  ValidateWind();
}

void RunOptions::ValidateWind() const {
  if (!wind.is_given()) return;
  Expect(fields.empty(), "--wind_profile: expected without --field");
  for (const auto& [name, prior] : fit.overrides.priors) {
    Expect(!FindKnot(name), "--prior: knots of --wind_profile are believed to change little; expected none of '" +
                                name + "'; see --wind_smoothness");
  }
  if (fit.wind_smoothness > 0.0) return;
  const std::string hint = ", which several fits choose";
  Expect(!resume, "--resume: expected with --wind_smoothness" + hint);
  Expect(fit.num_starts == 1, "--starts: expected with --wind_smoothness" + hint);
  Expect(!time_step.is_automatic, "--time_step: expected with --wind_smoothness" + hint);
}

void RunOptions::ValidateFields() const {
  Expect(field_weight >= 0.0 && std::isfinite(field_weight), "--field_weight: expected a number > 0");
  Expect(field_weight == 0.0 || !fields.empty(), "--field_weight: expected with --field");
  if (fields.empty()) return;
  Expect(!resume, "--resume: expected without --field, whose evaluations no journal keeps");
  Expect(fit.num_starts == 1, "--starts: expected without --field, which starts once");
  Expect(profiles.empty(), "--profile: expected without --field, which a profile would hold");
  Expect(!discretization.any(), "--discretization: expected without --field, which is not fitted again");
  Expect(!time_step.is_automatic, "--time_step: expected without --field, which is not fitted again");
  Expect(fit.method != FitMethod::kLbfgs || field_weight > 0.0,
         "--field_weight: expected with --method lbfgs, which does not choose it");
}

}  // namespace clothid
