// identify: binds the command line to the options of a fit and runs it.
#include <gflags/gflags.h>
#include <glog/logging.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <exception>
#include <iostream>
#include <string>
#include <vector>

#include "datasets/motion_file.h"
#include "identify/fit.h"
#include "identify/gradient_check.h"
#include "identify/holdout.h"
#include "identify/options.h"
#include "identify/output_folder.h"
#include "identify/problem.h"
#include "identify/progress.h"
#include "identify/report.h"
#include "identify/version.h"
#include "sim/error.h"

DEFINE_string(target, "", "recordings to fit, separated by commas");
DEFINE_string(scene, "", "scene.json to use instead of the one in each recording");
DEFINE_string(fit, "", "parameters to fit; empty: mu,k_stretch, or k_stretch where there are no obstacles");
DEFINE_string(start, "", "starting values, NAME=VALUE[,...]");
DEFINE_string(lower, "", "lower bounds, NAME=VALUE[,...]");
DEFINE_string(upper, "", "upper bounds, NAME=VALUE[,...]");
DEFINE_string(jacobian, "adjoint", "adjoint, sensitivity or numeric");
DEFINE_string(method, "lm", "lm or lbfgs");
DEFINE_string(loss, "none", "none or huber:A");
DEFINE_bool(check_gradients, false, "compare adjoint, sensitivities and finite differences at the start");
DEFINE_int32(max_iterations, 50, "iterations before the fit counts as not converged");
DEFINE_int32(threads, 1, "recordings simulated side by side");
DEFINE_string(output, "clothid_result", "folder for the results");
DEFINE_int64(seed, 0, "recorded in the result");
DEFINE_string(holdout, "", "a recording that is not fitted, to judge the estimates on");
DEFINE_double(step_tolerance, 0.0, "relative residual of a time step; 0: the scene's");

namespace clothid {
namespace {

constexpr char kHelp[] = R"(identify: fits friction and stiffness of cloth to recorded motion.

  identify --target FILE[,FILE...] [flags]

  --target FILES      motion.bin recordings, fitted jointly
  --scene FILE        scene.json to use instead of the one in each recording
  --fit NAMES         of mu, mu.OBSTACLE, k_stretch, k_bend, density, drag (mu,k_stretch; k_stretch without obstacles)
  --start LIST        starting values, NAME=VALUE[,...] (the scene's nominal values)
  --lower, --upper    bounds, NAME=VALUE[,...] (the scene's; else mu 0..2, the others start/1e4..start*1e4)
  --jacobian KIND     adjoint, sensitivity or numeric (adjoint)
  --method METHOD     lm: Levenberg-Marquardt; lbfgs: for many parameters (lm)
  --loss LOSS         none, or huber:A per observed point, A in standard deviations (none)
  --check_gradients   compare adjoint, sensitivities and central differences at the start
  --max_iterations N  (50)
  --threads N         recordings simulated side by side; the result does not depend on it (1)
  --holdout FILE      a recording that is not fitted: its error before and after
  --step_tolerance X  relative residual of a time step (the scene's)
  --seed S            recorded in the result (0)
  --output DIR        result.json, convergence.csv, predicted.bin (clothid_result)
  --help, --version

Ctrl-C saves the best point so far. Exit codes: 0 fitted; 1 usage, or a file that cannot be opened or written;
2 bad data; 3 not converged; 4 a parameter has no influence or stands at its bound; 5 the held-out recording failed;
130 interrupted.

Example:
  identify --target datasets/drape.motion.bin --fit mu,k_stretch --output /tmp/drape
)";

// Set by the signal handler, which can reach nothing but a global.
std::atomic<bool> interrupted{false};

// The first signal asks the fit to end; the next one ends the process as usual.
extern "C" void HandleSignal(int signal) {
  interrupted.store(true);
  std::signal(signal, SIG_DFL);
}

bool IsSet(const char* flag) {
  std::string value;
  return gflags::GetCommandLineOption(flag, &value) && value == "true";
}

FitOptions OptionsFromFlags() {
  FitOptions options;
  options.parameters = ParseNames(FLAGS_fit, "--fit");
  options.overrides.start = ParseParameterValues(FLAGS_start, "--start");
  options.overrides.lower_bounds = ParseParameterValues(FLAGS_lower, "--lower");
  options.overrides.upper_bounds = ParseParameterValues(FLAGS_upper, "--upper");
  options.jacobian = ParseJacobianMethod(FLAGS_jacobian);
  options.method = ParseFitMethod(FLAGS_method);
  options.loss = ParseRobustLoss(FLAGS_loss);
  options.max_iterations = FLAGS_max_iterations;
  options.num_threads = FLAGS_threads;
  options.cancel = &interrupted;
  options.Validate();
  return options;
}

RecordedMotion Read(const std::string& path) {
  ReadMotionOptions options;
  options.scene_path = FLAGS_scene;
  RecordedMotion motion = ReadMotion(path, options);
  if (FLAGS_step_tolerance > 0.0) motion.scene.solver.step_tolerance = FLAGS_step_tolerance;
  return motion;
}

std::string CommandLine(int argc, char** argv) {
  std::string line;
  for (int i = 1; i < argc; ++i) line += (i > 1 ? " " : "") + std::string(argv[i]);
  return line;
}

int Identify(const std::string& flags) {
  FitOptions options = OptionsFromFlags();
  if (FLAGS_step_tolerance < 0.0) throw Error(ErrorKind::kUsage, "--step_tolerance: expected a number > 0");
  const std::vector<std::string> targets = ParseNames(FLAGS_target, "--target");
  if (targets.empty()) throw Error(ErrorKind::kUsage, "--target: expected a recording; see --help");
  std::vector<RecordedMotion> motions, holdouts;
  for (const std::string& path : targets) motions.push_back(Read(path));
  if (!FLAGS_holdout.empty()) holdouts.push_back(Read(FLAGS_holdout));

  FitProblem problem(motions, options);
  OutputFolder folder(FLAGS_output);
  RunRecord run;
  run.jacobian = options.jacobian;
  run.flags = flags;
  run.seed = FLAGS_seed;
  run.num_threads = options.num_threads;
  if (FLAGS_check_gradients) run.gradient_check = CheckGradients(motions, options);

  FitSummary summary;
  {
    std::vector<std::string> names;
    for (const ParameterBlock& block : problem.blocks()) names.push_back(block.name);
    ProgressPrinter printer(&std::cerr, isatty(STDERR_FILENO) != 0, options.max_iterations);
    options.on_iteration = [&](const FitIteration& iteration) { printer.Print(names, iteration); };
    summary = Fit(options, &problem);
  }
  if (summary.status != FitStatus::kConverged) std::cerr << "identify: " << summary.message << "\n";
  if (!summary.has_estimate()) return FitExitCode(summary, run);

  if (!holdouts.empty()) {
    Eigen::VectorXd values(problem.num_blocks());
    for (int i = 0; i < problem.num_blocks(); ++i) values[i] = summary.parameters[i].value;
    run.holdout = EvaluateHoldout(holdouts.front(), problem.blocks(), values);
    if (!run.holdout->failure.empty()) std::cerr << "identify: holdout: " << run.holdout->failure << "\n";
  }
  WriteReport(summary, run, motions, &folder);
  std::cout << ResultTable(summary, run);
  return FitExitCode(summary, run);
}

}  // namespace
}  // namespace clothid

int main(int argc, char** argv) {
  const std::string flags = clothid::CommandLine(argc, argv);
  // Ceres logs through glog: to stderr, and only what is fatal unless -v asks for more.
  FLAGS_logtostderr = true;
  FLAGS_minloglevel = google::GLOG_FATAL;
  gflags::ParseCommandLineNonHelpFlags(&argc, &argv, /*remove_flags=*/true);
  if (clothid::IsSet("help") || clothid::IsSet("helpfull") || clothid::IsSet("helpshort")) {
    std::cout << clothid::kHelp;
    return clothid::kExitFitted;
  }
  if (clothid::IsSet("version")) {
    std::cout << "identify (clothid) " << clothid::Version() << " git " << clothid::GitHash() << "\n";
    return clothid::kExitFitted;
  }
  if (FLAGS_v > 0) FLAGS_minloglevel = google::GLOG_INFO;
  google::InitGoogleLogging(argv[0]);
  std::signal(SIGINT, clothid::HandleSignal);
  std::signal(SIGTERM, clothid::HandleSignal);
  try {
    if (argc > 1) {
      throw clothid::Error(clothid::ErrorKind::kUsage,
                           std::string("'") + argv[1] + "': expected flags only; see --help");
    }
    return clothid::Identify(flags);
  } catch (const clothid::Error& error) {
    std::cerr << "identify: " << error.what() << "\n";
    return error.kind() == clothid::ErrorKind::kBadData ? clothid::kExitBadData : clothid::kExitUsageOrIo;
  } catch (const std::exception& error) {
    std::cerr << "identify: " << error.what() << "\n";
    return clothid::kExitNotConverged;
  }
}
