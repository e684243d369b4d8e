// What comes out of a fit: result.json, convergence.csv, predicted.bin, profile.csv, report.html, a table for people.
#ifndef CLOTHID_IDENTIFY_REPORT_REPORT_H_
#define CLOTHID_IDENTIFY_REPORT_REPORT_H_

#include <string>
#include <vector>

#include "datasets/motion/motion_file.h"
#include "datasets/motion/recorded_motion.h"
#include "identify/base/output_folder.h"
#include "identify/fit/fit.h"
#include "identify/verdict/verdict.h"

namespace clothid {

// The text of convergence.csv: iteration,seconds,cost,<parameters>,gradient_norm,rollouts.
std::string ConvergenceCsv(const FitSummary& summary);

// The text of profile.csv: parameter,value,cost_rise,<parameters>; one block of rows per profile.
std::string ProfileCsv(const FitSummary& summary, const FitChecks& checks);

// A recording with the predicted positions of every point of `motion` at its times, nothing missing.
MotionTensors PredictedMotion(const RecordedMotion& motion, const Eigen::MatrixXd& predicted,
                              const std::vector<FittedParameter>& parameters);

struct ReportOptions {
  bool page = true;  // report.html
};

// Writes and commits result.json, convergence.csv, profile.csv where profiles were asked for, predicted.bin of the
// first recording, predicted_2.bin of the second and so on, and report.html. An older report.html is replaced, or
// removed where none is asked for. The fit must have an estimate. Throws `Error` (kIo).
void WriteReport(const FitSummary& summary, const FitChecks& checks, const std::vector<RecordedMotion>& motions,
                 OutputFolder* folder, const ReportOptions& options = {});

// The estimates as a small table, with errors in metres, and the verdict.
std::string ResultTable(const FitSummary& summary, const FitChecks& checks);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_REPORT_REPORT_H_
