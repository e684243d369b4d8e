// What a run is asked to do, and what comes out of it.
#ifndef CLOTHID_IDENTIFY_RUN_OPTIONS_H_
#define CLOTHID_IDENTIFY_RUN_OPTIONS_H_

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "costs/field/field_request.h"
#include "datasets/checking/finding.h"
#include "datasets/motion/motion_file.h"
#include "datasets/motion/recorded_motion.h"
#include "identify/base/options.h"
#include "identify/checks/holdout.h"
#include "identify/fit/fit.h"
#include "identify/repetition/repetitions.h"
#include "identify/verdict/verdict.h"
#include "identify/wind/wind_request.h"
#include "sim/base/error.h"

namespace clothid {

struct RunOptions {
  RunOptions() { fit.assimilate.kind = AssimilationOption::Kind::kAuto; }

  // What is fitted, jointly: motion.bin files, or recordings that are in memory. One of the two, the other empty.
  std::vector<std::string> target_paths;
  std::vector<RecordedMotion> targets;
  // Recordings to judge the estimates on, likewise; or those frames of every fitted one. At most one of the three.
  std::vector<std::string> holdout_paths;
  std::vector<RecordedMotion> holdouts;
  std::optional<FrameRange> holdout_frames;
  int holdout_draws = 20;         // rollouts of each that make its bands (identify/prediction/held_bands.h); 0: none
  bool calibrates_bands = false;  // with a factor on the missing force
  ReadMotionOptions reading;      // of all files: scene, start, sigma
  std::string fabric_card;        // the file that `reading.change_scene` is from, which is not to be replaced; or empty
  TimeStepOption time_step;       // of all recordings, held-out ones too
  double step_tolerance = 0.0;    // relative residual of a time step, in all recordings; 0: that of each scene
  // What `motion check` looks for is looked for in every recording before anything is fitted, held-out ones among them.
  // A problem ends the run.
  bool check_recordings = true;
  // Finds the slow forces that the model lacks, for predictions of other motions by result.json
  // (identify/prediction/force_match.h). They are found in any case where measurements are held out.
  bool finds_missing_forces = true;
  // The fit itself with its callbacks, which see the main fit, and its `cancel`, which ends the whole run.
  FitOptions fit;
  // A wind that changes over the time of every recording, fitted with the parameters; its smoothness is
  // `FitOptions::wind_smoothness`, 0: it is chosen (identify/uncertainty/smoothness.h).
  WindRequest wind;
  // Beside the fit.
  bool check_gradients = false;              // at the start, before the fit
  std::vector<std::string> profiles;         // parameters whose profile likelihood is wanted
  DiscretizationParts discretization;        // the fit again with other time steps, another mesh; widens intervals
  std::vector<std::string> landscape_paths;  // folders that `landscape` wrote of a recording of `target_paths`
  // The recordings are repetitions of one experiment: each is fitted for itself, too, and their estimates are pooled
  // (identify/repetition/repetitions.h). `target_paths` may then all be folders of finished fits, or of such folders,
  // which are pooled without a fit (identify/repetition/finished_fits.h).
  bool repeat = false;
  // Each of the recordings is fitted for itself, too, and predicts the others (identify/prediction/transfer.h), by
  // `holdout_draws` rollouts each.
  bool transfer = false;
  // What is written.
  std::string output;                   // the folder; empty: nothing is written
  bool report_page = true;              // report.html as well
  std::vector<std::string> simulators;  // for which constants are exported (identify/export/export.h), with an output
  bool resume = false;                  // goes on with what a killed run left in `output`, and keeps such a journal
  std::string command_line;             // "flags" of result.json
  bool keep_recordings = false;         // in the result, for reports that are made later
  // Told on the thread of the call, but `on_repetition` on any, one at a time; may be empty. What they throw leaves
  // `Identify`.
  std::function<void(const std::string& recording, const Finding&)> on_finding;    // warnings, before the fit
  std::function<void(const SingleFit& fit, int num_done, int num)> on_repetition;  // one was fitted for itself
  std::function<void(const std::vector<std::string>& names)> on_problem;           // of all parameters, before the fit
  std::function<void(const FitSummary&)> on_fitted;                                // the main fit has ended
  std::function<void(const FitSummary&)> on_examined;  // nothing but the files is left to do
  // `RunResult::table`, where there is one, before the files are written: what goes wrong there does not lose it.
  std::function<void(const std::string& table)> on_table;

  // Whether `repeat` is of finished fits: every one of `target_paths` is a folder.
  bool judges_folders() const;

  // Throws `Error` (kUsage) naming the first value that is out of range or goes with no other.
  void Validate() const;
};

struct RunResult {
  // Without an estimate (`FitSummary::has_estimate`) its message says why, nothing was written, and `table` is empty.
  // Of recordings the joint fit; of finished fits (`RunOptions::judges_folders`) it has status, message and, as
  // estimates, the means alone.
  FitSummary summary;
  FitChecks checks;
  ExitCode exit_code = kExitNotConverged;  // of the verdict
  Verdict verdict;                         // of `Judge`
  std::string table;                       // of `ResultTable`
  // Where there is an estimate and `RunOptions::keep_recordings` asks for them: the fitted recordings as they were
  // fitted, which `ResultJson`, `ReportHtml` and `WriteReport` take with `summary` and `checks`.
  std::vector<RecordedMotion> recordings;
};

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_RUN_OPTIONS_H_
