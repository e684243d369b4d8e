// What comes out of a fit: result.json, fabric.json and card.html, convergence.csv, predicted.bin, profile.csv,
// report.html, a table for people.
#ifndef CLOTHID_IDENTIFY_REPORT_REPORT_H_
#define CLOTHID_IDENTIFY_REPORT_REPORT_H_

#include <string>
#include <vector>

#include "datasets/fabric/fabric_card.h"
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

// A recording with the predicted positions of every point of `motion` at its times, nothing missing, and the predicted
// `forces` [3G x F] N at theirs, if it has any.
MotionTensors PredictedMotion(const RecordedMotion& motion, const Eigen::MatrixXd& predicted,
                              const std::vector<FittedParameter>& parameters, const Eigen::MatrixXd& forces = {});

// Whether `WriteReport` writes files of this name: result.json, fabric.json, convergence.csv, profile.csv,
// predicted.bin, predicted_2.bin and so on, card.html, report.html, export_mujoco.xml and the like.
bool IsReportFile(const std::string& name);

struct ReportOptions {
  bool page = true;                     // report.html and card.html
  std::vector<std::string> simulators;  // for which constants are exported (identify/export/export.h)
};

// Writes and commits result.json, fabric.json, convergence.csv, profile.csv where profiles were asked for,
// predicted.bin of the first recording, predicted_2.bin of the second and so on, card.html and report.html, in place of
// all such files that are there.
// The fit must have an estimate. Throws `Error` (kIo). Where that is about predictions or pages, which are large, the
// others are there without them, and the journals stay for a fit that resumes; else nothing is.
void WriteReport(const FitSummary& summary, const FitChecks& checks, const std::vector<RecordedMotion>& motions,
                 OutputFolder* folder, const ReportOptions& options = {});

// The same for finished fits that were judged together (`FitChecks::repetitions`), which have neither recordings nor a
// joint fit: result.json, report.html with what they tell, their card, null where there is none, and, for the cloth of
// `scene`, which may be null without simulators, the exports. Throws `Error` (kIo), leaving nothing.
void WritePooledReport(const FitSummary& summary, const FitChecks& checks, const Verdict& verdict, const Scene* scene,
                       const FabricCard* card, OutputFolder* folder, const ReportOptions& options = {});

// The table of these.
std::string PooledTable(const FitChecks& checks, const Verdict& verdict);

// The estimates as a small table, with errors in metres, and the verdict.
std::string ResultTable(const FitSummary& summary, const FitChecks& checks);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_REPORT_REPORT_H_
