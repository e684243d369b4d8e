// identify: binds the command line to the options of a fit and runs it.
#include <gflags/gflags.h>
#include <glog/logging.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <iostream>
#include <string>
#include <vector>

#include "identify/base/command_line.h"
#include "identify/base/options.h"
#include "identify/base/parallel_for.h"
#include "identify/base/progress.h"
#include "identify/base/register_flag.h"
#include "identify/base/version.h"
#include "identify/export/export.h"
#include "identify/fit/fit.h"
#include "identify/help.h"
#include "identify/run.h"
#include "identify/run_flags.h"
#include "sim/base/error.h"
#include "sim/base/program.h"

DEFINE_string(result, "", "result.json of an earlier fit to --export");

namespace clothid {
namespace {

// 0 where stderr is no terminal.
int TerminalColumns() {
  winsize size = {};
  return ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 ? size.ws_col : 0;
}

// Has the run tell on stderr where it stands.
void ShowProgress(ProgressPrinter* printer, std::vector<std::string>* names, RunOptions* options) {
  options->on_finding = [](const std::string& recording, const Finding& finding) {
    std::cerr << "identify: " << recording << ": warning: " << finding.what << ": " << finding.value << "; "
              << finding.hint << "\n";
  };
  options->on_repetition = [](const SingleFit& fit, int num_done, int num) {
    std::cerr << "identify: " << num_done << " of " << num << " fitted for itself: " << fit.name
              << (fit.why_not_used.empty() ? "" : ": " + fit.why_not_used) << "\n";
  };
  options->on_problem = [names](const std::vector<std::string>& of_problem) { *names = of_problem; };
  options->fit.on_progress = [printer](const EvaluationProgress& progress) { printer->Print(progress); };
  options->fit.on_iteration = [printer, names](const FitIteration& iteration) { printer->Print(*names, iteration); };
  options->fit.on_start = [printer, num_starts = options->fit.num_starts](int start) {
    printer->PrintStart(start, num_starts);
  };
  options->fit.on_stage = [printer](const FitPlan& plan, int stage) { printer->PrintStage(plan, stage); };
  options->on_fitted = [printer](const FitSummary&) { printer->EndFit(); };
  options->on_examined = [printer](const FitSummary& summary) {
    printer->EndFit();
    if (summary.status != FitStatus::kConverged) std::cerr << "identify: " << summary.message << "\n";
  };
}

int Run(const RunFlags& flags, const std::string& command_line) {
  if (!FLAGS_result.empty()) {
    ExportResult(FLAGS_result, flags.target, flags.exports, flags.output);
    return kExitSuccess;
  }
  if (flags.target.empty()) throw Error(ErrorKind::kUsage, "--target: expected a recording; see identify --help");
  if (flags.output.empty()) throw Error(ErrorKind::kUsage, "--output: expected a folder");
  RunOptions options = ParseRunFlags(flags);
  options.command_line = command_line;
  options.fit.cancel = &CatchInterrupts();
  ProgressPrinter printer(&std::cerr, isatty(STDERR_FILENO) != 0, options.fit.max_iterations, {}, TerminalColumns);
  std::vector<std::string> names;
  ShowProgress(&printer, &names, &options);
  int output_code = kExitSuccess;
  options.on_table = [&output_code](const std::string& table) {
    std::cout << table;
    output_code = FinishOutput("identify", kExitSuccess);
    std::cout.clear();  // that was told
  };
  const ExitCode exit_code = Identify(options).exit_code;
  return output_code == kExitSuccess || exit_code == kExitInterrupted ? exit_code : output_code;
}

}  // namespace
}  // namespace clothid

int main(int argc, char** argv) {
  // Ceres logs through glog: to stderr, and only what is fatal unless -v asks for more.
  FLAGS_logtostderr = true;
  FLAGS_minloglevel = google::GLOG_FATAL;
  static clothid::RunFlags flags;
  flags.output = "clothid_result";
  clothid::VisitRunFlags(&flags, [](const char* name, auto* field) { clothid::RegisterFlag(name, __FILE__, field); });
  const auto run = [&](const std::vector<std::string>&) {
    if (FLAGS_v > 0) FLAGS_minloglevel = google::GLOG_INFO;
    google::InitGoogleLogging(argv[0]);
    return clothid::Run(flags, clothid::JoinArguments(argc, argv));
  };
  clothid::Program program = {"identify", clothid::kHelp, clothid::kMoreHelp, {{"", {}, "", run}}};
  for (const char* list : {"target", "fit", "field", "each", "start", "lower", "upper", "prior", "profile", "landscape",
                           "holdout", "export"}) {
    program.lists[list] = ',';
  }
  program.git = clothid::GitHash();
  clothid::RunCommandLine(program, argc, argv);
}
