// What comes out of a fit: result.json, convergence.csv, predicted.bin, a table for people, an exit code.
#ifndef CLOTHID_IDENTIFY_REPORT_H_
#define CLOTHID_IDENTIFY_REPORT_H_

#include <optional>
#include <string>
#include <vector>

#include "datasets/motion_file.h"
#include "datasets/recorded_motion.h"
#include "identify/fit.h"
#include "identify/gradient_check.h"
#include "identify/holdout.h"
#include "identify/options.h"
#include "identify/output_folder.h"

namespace clothid {

enum ExitCode : int {
  kExitFitted = 0,
  kExitUsageOrIo = 1,
  kExitBadData = 2,
  kExitNotConverged = 3,
  kExitNotIdentifiable = 4,  // a fitted parameter has no influence or stands at its bound
  kExitHoldoutFailed = 5,    // the held-out recording could not be simulated at the estimate
  kExitInterrupted = 130,
};

// What a report says beside the fit itself.
struct RunRecord {
  JacobianMethod jacobian = JacobianMethod::kAdjoint;
  std::optional<GradientCheck> gradient_check;
  std::optional<Holdout> holdout;
  std::string flags;  // the command line
  long long seed = 0;
  int num_threads = 1;
};

// Where several apply: 130, 3, 4, 5 in that order.
ExitCode FitExitCode(const FitSummary& summary, const RunRecord& run);

// The text of result.json, schema "clothid.result/1". Numbers are written so that they read back exactly, NaN as null.
// All but "seconds", "flags" and "threads" is the same on repeated runs and on any number of threads. `std`, `lower95`
// and `upper95` are null: this version estimates no uncertainty; `identifiable` is false where a parameter has no
// influence, else null.
std::string ResultJson(const FitSummary& summary, const RunRecord& run, const std::vector<RecordedMotion>& motions);

// The text of convergence.csv: iteration,seconds,cost,<parameters>,gradient_norm,rollouts.
std::string ConvergenceCsv(const FitSummary& summary);

// A recording with the predicted positions of every point of `motion` at its times, nothing missing.
MotionTensors PredictedMotion(const RecordedMotion& motion, const Eigen::MatrixXd& predicted,
                              const std::vector<FittedParameter>& parameters);

// Writes and commits result.json, convergence.csv, and predicted.bin of the first recording, predicted_2.bin of the
// second and so on. The fit must have an estimate. Throws `Error` (kIo).
void WriteReport(const FitSummary& summary, const RunRecord& run, const std::vector<RecordedMotion>& motions,
                 OutputFolder* folder);

// The estimates as a small table, with errors in metres.
std::string ResultTable(const FitSummary& summary, const RunRecord& run);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_REPORT_H_
