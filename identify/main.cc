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
#include "identify/base/version.h"
#include "identify/export/result_export.h"
#include "identify/fit/fit.h"
#include "identify/help.h"
#include "identify/run.h"
#include "identify/run_flags.h"
#include "sim/base/error.h"
#include "sim/base/program.h"
#include "sim/base/text_file.h"

DEFINE_string(target, "", "recordings to fit, separated by commas");
DEFINE_string(scene, "", "scene.json to use instead of the one in each recording");
DEFINE_string(fabric, "", "kind of cloth whose measured constants stand in for those that the scene does not give");
DEFINE_string(fit, "", "parameters to fit; empty: mu, where there are obstacles, and k_stretch, or k_warp,k_weft");
DEFINE_string(each, "", "parameters to fit of which every recording has its own");
DEFINE_string(field, "", "constants that vary over the cloth, NAME:ROWSxCOLUMNS[,...]");
DEFINE_double(field_weight, 0.0, "weight of the smoothness of fields; 0: chosen by the marginal likelihood");
DEFINE_string(wind_profile, "", "knots of a wind that changes over the time of every recording, KNOTS[:AXES]");
DEFINE_double(wind_smoothness, 0.0, "how far the wind wanders, m/s in a second; 0: chosen by the marginal likelihood");
DEFINE_string(start, "", "starting values, NAME=VALUE[,...]");
DEFINE_string(lower, "", "lower bounds, NAME=VALUE[,...]");
DEFINE_string(upper, "", "upper bounds, NAME=VALUE[,...]");
DEFINE_string(prior, "", "what is believed of parameters beforehand, NAME=MEDIAN:FACTOR or NAME=MEAN:STD[,...]");
DEFINE_string(jacobian, "adjoint", "adjoint, sensitivity or numeric");
DEFINE_string(adjoint, "reduced", "how reverse sweeps solve their linear systems, METHOD[:THRESHOLD]");
DEFINE_string(precision, "adaptive", "adaptive or full");
DEFINE_string(loss, "none", "none, huber:A or cauchy:A");
DEFINE_string(sigma, "recorded", "standard deviation of a coordinate: recorded, auto or a number in m");
DEFINE_string(initial, "estimated",
              "where the cloth starts if the scene does not say: estimated, rest, moving, smoothed or first");
DEFINE_bool(check, true, "check the recordings before the fit, as motion check does");
DEFINE_bool(check_gradients, false, "compare adjoint, sensitivities and finite differences at the start");
DEFINE_int32(max_iterations, 50, "iterations before the fit counts as not converged");
DEFINE_int32(threads, 1, "recordings and fits side by side");
DEFINE_string(output, "clothid_result", "folder for the results");
DEFINE_int32(starts, 1, "number of starting points");
DEFINE_uint64(seed, 0, "seed of the starting points");
DEFINE_string(profile, "", "parameters whose profile likelihood is wanted");
DEFINE_string(landscape, "", "folders that `landscape` wrote, to show in report.html");
DEFINE_string(discretization, "", "what intervals are to count with besides noise: step, mesh or all");
DEFINE_string(time_step, "", "of the simulation, in s, or auto; empty: the scene's");
DEFINE_string(holdout, "", "recordings that are not fitted, to judge the estimates on");
DEFINE_string(holdout_frames, "", "frames A:B of every recording that are not fitted, to judge the estimates on");
DEFINE_string(horizon, "growing", "growing: fits of the first frames lead to the start; full: all frames at once");
DEFINE_bool(resume, false, "continue a fit that was killed: replays the evaluations journaled in --output");
DEFINE_bool(report, true, "write report.html");
DEFINE_string(export, "", "simulators for which the constants are written to --output");
DEFINE_string(result, "", "result.json of an earlier fit to --export");
DEFINE_double(step_tolerance, 0.0, "relative residual of a time step; 0: the scene's");

namespace clothid {
namespace {

RunFlags FlagsOfCommandLine() {
  RunFlags flags;
  flags.target = FLAGS_target;
  flags.scene = FLAGS_scene;
  flags.fabric = FLAGS_fabric;
  flags.fit = FLAGS_fit;
  flags.each = FLAGS_each;
  flags.field = FLAGS_field;
  flags.field_weight = FLAGS_field_weight;
  flags.wind_profile = FLAGS_wind_profile;
  flags.wind_smoothness = FLAGS_wind_smoothness;
  flags.start = FLAGS_start;
  flags.lower = FLAGS_lower;
  flags.upper = FLAGS_upper;
  flags.prior = FLAGS_prior;
  flags.jacobian = FLAGS_jacobian;
  flags.adjoint = FLAGS_adjoint;
  flags.precision = FLAGS_precision;
  flags.loss = FLAGS_loss;
  flags.sigma = FLAGS_sigma;
  flags.initial = FLAGS_initial;
  flags.check = FLAGS_check;
  flags.check_gradients = FLAGS_check_gradients;
  flags.max_iterations = FLAGS_max_iterations;
  flags.threads = FLAGS_threads;
  flags.output = FLAGS_output;
  flags.starts = FLAGS_starts;
  flags.seed = FLAGS_seed;
  flags.profile = FLAGS_profile;
  flags.landscape = FLAGS_landscape;
  flags.discretization = FLAGS_discretization;
  flags.time_step = FLAGS_time_step;
  flags.holdout = FLAGS_holdout;
  flags.holdout_frames = FLAGS_holdout_frames;
  flags.horizon = FLAGS_horizon;
  flags.exports = FLAGS_export;
  flags.resume = FLAGS_resume;
  flags.report = FLAGS_report;
  flags.step_tolerance = FLAGS_step_tolerance;
  return flags;
}

RunOptions OptionsFromFlags(const std::string& command_line) {
  if (FLAGS_target.empty()) throw Error(ErrorKind::kUsage, "--target: expected a recording; see identify --help");
  if (FLAGS_output.empty()) throw Error(ErrorKind::kUsage, "--output: expected a folder");
  RunOptions options = ParseRunFlags(FlagsOfCommandLine());
  options.command_line = command_line;
  return options;
}

std::string CommandLine(int argc, char** argv) {
  std::string line;
  for (int i = 1; i < argc; ++i) line += (i > 1 ? " " : "") + std::string(argv[i]);
  return line;
}

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
  options->on_problem = [names](const std::vector<std::string>& of_problem) { *names = of_problem; };
  options->fit.on_progress = [printer](const EvaluationProgress& progress) { printer->Print(progress); };
  options->fit.on_iteration = [printer, names](const FitIteration& iteration) { printer->Print(*names, iteration); };
  options->fit.on_start = [printer, num_starts = options->fit.num_starts](int start) {
    printer->PrintStart(start, num_starts);
  };
  options->on_fitted = [printer](const FitSummary&) { printer->EndFit(); };
  options->on_examined = [printer](const FitSummary& summary) {
    printer->EndFit();
    if (summary.status != FitStatus::kConverged) std::cerr << "identify: " << summary.message << "\n";
  };
}

int Run(const std::string& command_line) {
  if (!FLAGS_result.empty()) {
    ExportResult(FLAGS_result, FLAGS_target, FLAGS_export, FLAGS_output);
    return kExitSuccess;
  }
  RunOptions options = OptionsFromFlags(command_line);
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
  const auto run = [&](const std::vector<std::string>&) {
    if (FLAGS_v > 0) FLAGS_minloglevel = google::GLOG_INFO;
    google::InitGoogleLogging(argv[0]);
    return clothid::Run(clothid::CommandLine(argc, argv));
  };
  clothid::Program program = {"identify", clothid::kHelp, clothid::kMoreHelp, {{"", {}, "", run}}};
  for (const char* list : {"target", "fit", "field", "each", "start", "lower", "upper", "prior", "profile", "landscape",
                           "holdout", "export"}) {
    program.lists[list] = ',';
  }
  program.git = clothid::GitHash();
  return clothid::RunCommandLine(program, argc, argv);
}
