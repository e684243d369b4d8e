// What of the options of a run goes with what.
#include "identify/run_options.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include "identify/base/knot_names.h"
#include "identify/prediction/bands.h"

namespace clothid {

namespace {

bool IsFolder(const std::string& path) {
  std::error_code ignored;
  return std::filesystem::is_directory(path, ignored);
}

void ValidateRepeat(const RunOptions& options) {
  if (!options.repeat) return;
  const std::vector<std::string>& paths = options.target_paths;
  if (!options.judges_folders()) {
    ExpectUsage(std::none_of(paths.begin(), paths.end(), IsFolder),
                "--target: expected recordings or folders of finished fits, not both");
    ExpectUsage(paths.size() + options.targets.size() > 1, "--repeat: expected at least two recordings");
    return;
  }
  const auto expect_absent = [](bool is_absent, const std::string& flag) {
    ExpectUsage(is_absent, flag + ": expected recordings as --target; these fits are finished");
  };
  expect_absent(options.holdout_paths.empty() && options.holdouts.empty(), "--holdout");
  expect_absent(!options.holdout_frames, "--holdout_frames");
  expect_absent(options.profiles.empty(), "--profile");
  expect_absent(!options.discretization.any(), "--discretization");
  expect_absent(options.landscape_paths.empty(), "--landscape");
  expect_absent(options.time_step.seconds == 0.0 && !options.time_step.is_automatic, "--time_step");
  expect_absent(options.fit.num_starts == 1, "--starts");
  expect_absent(options.fit.fields.empty(), "--field");
  expect_absent(!options.wind.is_given(), "--wind_profile");
  expect_absent(options.reading.scene_path.empty(), "--scene");
  expect_absent(options.reading.sigma_source == SigmaSource::kRecorded, "--sigma");
  expect_absent(!options.fit.loss.is_robust(), "--loss");
  expect_absent(!options.check_gradients, "--check_gradients");
  expect_absent(!options.resume, "--resume");
  expect_absent(!options.transfer, "--transfer");
  const ParameterOverrides& given = options.fit.overrides;
  expect_absent(given.start.empty(), "--start");
  expect_absent(given.lower_bounds.empty(), "--lower");
  expect_absent(given.upper_bounds.empty(), "--upper");
  expect_absent(given.priors.empty(), "--prior");
}

}  // namespace

bool RunOptions::judges_folders() const {
  return repeat && !target_paths.empty() && std::all_of(target_paths.begin(), target_paths.end(), IsFolder);
}

void RunOptions::Validate() const {
  fit.Validate();
  ExpectUsage(step_tolerance >= 0.0 && std::isfinite(step_tolerance), "--step_tolerance: expected a number > 0");
  ExpectUsage(!target_paths.empty() || !targets.empty(), "--target: expected a recording");
  ExpectUsage(target_paths.empty() || targets.empty(), "targets: expected without target_paths");
  ExpectUsage(holdout_paths.empty() || holdouts.empty(), "holdouts: expected without holdout_paths");
  ExpectUsage(holdout_draws == 0 || (holdout_draws >= kLeastDraws && holdout_draws <= kMostDraws),
              "--holdout_draws: expected 0, or a number from " + std::to_string(kLeastDraws) + " to " +
                  std::to_string(kMostDraws));
  const bool has_holdout = !holdout_paths.empty() || !holdouts.empty() || holdout_frames.has_value();
  ExpectUsage(!calibrates_bands || (has_holdout && holdout_draws > 0),
              "--calibrate_bands: expected with --holdout or --holdout_frames, and with --holdout_draws above 0");
  ExpectUsage(!holdout_frames || (holdout_paths.empty() && holdouts.empty()),
              "--holdout_frames: expected without --holdout");
  ExpectUsage(landscape_paths.empty() || (report_page && !output.empty()),
              "--landscape: is shown in report.html; expected without --report=false");
  ValidateRepeat(*this);
  ExpectUsage(!transfer || target_paths.size() + targets.size() > 1, "--transfer: expected at least two recordings");
  ExpectUsage(!transfer || (!holdout_frames && holdout_draws > 0 && fit.fields.empty() && !wind.is_given()),
              "--transfer: expected without --holdout_frames, --field and --wind_profile, and with --holdout_draws "
              "above 0");
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
