// benchmark: accuracy, cost and time of the methods against each other.
#include <gflags/gflags.h>
#include <glog/logging.h>

#include <chrono>
#include <iomanip>
#include <iostream>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "identify/output_folder.h"
#include "tools/benchmark_jacobian.h"
#include "tools/command_line.h"

DEFINE_string(scene, "", "scene.json");
DEFINE_string(set, "", "the true values of the two fitted parameters, NAME=VALUE,NAME=VALUE");
DEFINE_double(noise, 0.01, "noise of the second recording, relative to the cloth's size; 0: only the one without");
DEFINE_int32(starts, 4, "starts per parameter, even");
DEFINE_string(methods, "adjoint,sensitivity,numeric,lbfgs", "methods to compare");
DEFINE_uint64(seed, 1, "seed of the noise");
DEFINE_string(output, "", "folder for jacobian.csv, one row per fit; empty: none");
DEFINE_int32(threads, 1, "fits side by side");

namespace clothid {
namespace {

constexpr char kHelp[] = R"(benchmark: accuracy, cost and time of the methods against each other.

  benchmark jacobian --scene FILE --set LIST [flags]

jacobian: fits two parameters to a synthetic recording, without and with noise, from a grid of starts (friction 0.02 to
0.58, others 0.1 to 10 times the truth) with each method, and prints how many fits reached the minimum, rollouts, sweeps,
failed steps, processor seconds (medians), and these relative to `sensitivity` (median over the starts).

  --scene FILE      scene.json; parameters that are not set have its nominal values
  --set LIST        the two parameters to fit and their true values, NAME=VALUE,NAME=VALUE
  --noise SHARE     noise of the second recording, standard deviation relative to the cloth's size; 0: none (0.01)
  --starts N        N x N starts, N even (4)
  --methods LIST    of adjoint, sensitivity, numeric, lbfgs (all)
  --seed S          of the noise (1)
  --threads N       fits side by side; only the seconds depend on it (1)
  --output DIR      writes jacobian.csv, one row per fit
  --help, --version

Exit codes: 0 done, whatever the table says; 1 usage, or a file that cannot be opened or written; 2 bad content.

Example:
  benchmark jacobian --scene datasets/drape.scene.json --set mu=0.3,k_stretch=100 --output /tmp/jacobian
)";

JacobianBenchmarkOptions OptionsFromFlags() {
  JacobianBenchmarkOptions options;
  options.scene_path = FLAGS_scene;
  options.truth = ParseParameterValues(FLAGS_set, "--set");
  options.noise = FLAGS_noise;
  options.starts_per_axis = FLAGS_starts;
  options.methods = ParseNames(FLAGS_methods, "--methods");
  options.seed = FLAGS_seed;
  options.num_threads = FLAGS_threads;
  return options;
}

// "fit 3 of 128: adjoint, noise 0.01, start 0.02 7: converged, 7 rollouts; 310 s left". `seconds` since the start.
void PrintProgress(const JacobianFit& fit, int num_done, int num_fits, double seconds) {
  std::ostringstream line;
  line << "fit " << num_done << " of " << num_fits << ": " << fit.method << ", noise " << fit.noise << ", start "
       << fit.start[0] << " " << fit.start[1] << ": " << FitStatusName(fit.status) << ", " << fit.rollouts
       << " rollouts; " << std::fixed << std::setprecision(0) << seconds / num_done * (num_fits - num_done)
       << " s left\n";
  std::cerr << line.str();
}

int RunJacobian() {
  JacobianBenchmarkOptions options = OptionsFromFlags();
  options.Validate();
  std::optional<OutputFolder> folder;  // before the fits, so that they do not run in vain
  if (!FLAGS_output.empty()) folder.emplace(FLAGS_output);
  const auto start = std::chrono::steady_clock::now();
  options.on_fit = [start](const JacobianFit& fit, int num_done, int num_fits) {
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    PrintProgress(fit, num_done, num_fits, seconds.count());
  };
  const JacobianBenchmark benchmark = RunJacobianBenchmark(options);
  if (folder) {
    folder->Write("jacobian.csv", JacobianCsv(benchmark));
    folder->Commit();
  }
  std::cout << JacobianTable(benchmark);
  return kExitSuccess;
}

int Run(const std::vector<std::string>& arguments) {
  const std::string known = "; there is: jacobian; see benchmark --help";
  if (arguments.empty()) throw Error(ErrorKind::kUsage, "a command is missing" + known);
  if (arguments.size() > 1) throw Error(ErrorKind::kUsage, "'" + arguments[1] + "': unexpected argument");
  if (arguments[0] == "jacobian") return RunJacobian();
  throw Error(ErrorKind::kUsage, "'" + arguments[0] + "': unknown command" + known);
}

}  // namespace
}  // namespace clothid

int main(int argc, char** argv) {
  // Ceres logs through glog: to stderr, and only what is fatal.
  FLAGS_logtostderr = true;
  FLAGS_minloglevel = google::GLOG_FATAL;
  google::InitGoogleLogging(argv[0]);
  return clothid::RunCommand("benchmark", clothid::kHelp, argc, argv, clothid::Run);
}
