#include "tools/benchmark/benchmark_progress.h"

#include <chrono>
#include <iomanip>
#include <iostream>
#include <sstream>
#include <string>

#include "identify/fit/fit.h"
#include "sim/base/program.h"

namespace clothid {
namespace {

std::string Describe(const JacobianFit& fit) {
  std::ostringstream text;
  text << fit.method << ", noise " << fit.noise << ", start " << fit.start[0] << " " << fit.start[1] << ": "
       << FitStatusName(fit.status) << ", " << fit.rollouts << " rollouts";
  return text.str();
}

std::string Describe(const FieldsFit& fit) {
  return std::to_string(fit.side * fit.side) + " unknowns: " + (fit.has_converged ? "converged" : "not converged") +
         ", " + std::to_string(fit.rollouts) + " rollouts";
}

std::string Describe(const CoverageFit& fit) {
  return fit.setting + ", seed " + std::to_string(fit.seed) + ": " + FitStatusName(fit.status) + ", " +
         std::to_string(fit.rollouts) + " rollouts";
}

std::string Describe(const ForwardCase& result) {
  return result.scene + ", " + std::to_string(result.nodes) + " x " + std::to_string(result.nodes) + " nodes";
}

// Prints a line of progress. Throws `Interrupted` after a signal: a benchmark ends with the item that it is at.
void Report(const std::string& line) {
  std::cerr << line;
  if (IsInterrupted()) throw Interrupted();
}

std::string Describe(const StabilityRow& row) {
  std::ostringstream text;
  text << row.name << ", " << row.contact << ", " << row.integrator << ", k " << row.stretch_stiffness << ", h "
       << row.time_step << ", mu " << row.friction_coefficient << ": " << (row.ok() ? "ok" : row.error);
  return text.str();
}

// Reports every item: "fit 3 of 128: adjoint, noise 0.01, start 0.02 7: converged, 7 rollouts; 310 s left".
auto ProgressReporter(const std::string& what) {
  const auto start = std::chrono::steady_clock::now();
  return [start, what](const auto& item, int num_done, int num_items) {
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    std::ostringstream line;
    line << what << " " << num_done << " of " << num_items << ": " << Describe(item) << "; " << std::fixed
         << std::setprecision(0) << seconds.count() / num_done * (num_items - num_done) << " s left\n";
    Report(line.str());
  };
}

// Reports every item by its name: "case 3 of 18: wind, realistic, 24 x 24 nodes; 12 s so far". They differ too much in
// size to say how long the rest takes.
auto NameReporter(const std::string& what) {
  const auto start = std::chrono::steady_clock::now();
  return [start, what](const std::string& name, int num_done, int num_items) {
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    std::ostringstream line;
    line << what << " " << num_done << " of " << num_items << ": " << name << "; " << std::fixed << std::setprecision(0)
         << seconds.count() << " s so far\n";
    Report(line.str());
  };
}

void ReportCases(BackpropCaseOptions* options) {
  options->on_case = [report = NameReporter("case")](const BackpropCaseName& name, int num_done, int num_cases) {
    report(name.ToString(), num_done, num_cases);
  };
}

}  // namespace

void ReportProgress(JacobianBenchmarkOptions* options) { options->on_fit = ProgressReporter("fit"); }
void ReportProgress(FieldsOptions* options) { options->on_fit = ProgressReporter("fit"); }
void ReportProgress(CoverageOptions* options) { options->on_fit = ProgressReporter("fit"); }
void ReportProgress(StabilityOptions* options) { options->on_row = ProgressReporter("row"); }
void ReportProgress(ForwardBenchmarkOptions* options) { options->on_rollout = ProgressReporter("rollout"); }
void ReportProgress(BackpropOptions* options) { ReportCases(&options->cases); }
void ReportProgress(AccuracyOptions* options) { options->on_measured = NameReporter("part"); }

}  // namespace clothid
