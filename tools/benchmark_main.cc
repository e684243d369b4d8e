// benchmark: accuracy, cost and time of the methods against each other.
#include <gflags/gflags.h>
#include <glog/logging.h>

#include <charconv>
#include <chrono>
#include <iomanip>
#include <iostream>
#include <optional>
#include <sstream>
#include <string>
#include <system_error>
#include <vector>

#include "identify/options.h"
#include "identify/output_folder.h"
#include "sim/error.h"
#include "sim/parameters.h"
#include "sim/text_file.h"
#include "tools/benchmark_backprop.h"
#include "tools/benchmark_continuity.h"
#include "tools/benchmark_coverage.h"
#include "tools/benchmark_discretization.h"
#include "tools/benchmark_forward.h"
#include "tools/benchmark_jacobian.h"
#include "tools/benchmark_thresholds.h"
#include "tools/command_line.h"

DEFINE_string(scene, "", "scene.json; backprop, thresholds, forward: of wind, slope, sphere");
DEFINE_string(set, "", "the true values of the fitted parameters, NAME=VALUE[,...]");
DEFINE_double(noise, 0.01, "standard deviation of noise, relative to the cloth's size");
DEFINE_int32(starts, 4, "starts per parameter, even");
DEFINE_string(methods, "", "methods to compare; empty: all");
DEFINE_string(precision, "adaptive", "of the fits: adaptive or full");
DEFINE_uint64(seed, 1, "seed of the noise");
DEFINE_string(nodes, "", "nodes along the first axis of the grids; empty: see --help");
DEFINE_string(steps, "", "discretization: divisors of the time step; else a number of steps; empty: see --help");
DEFINE_int32(repeats, 3, "repetitions, of which the table gives medians");
DEFINE_int32(seeds, 40, "noisy recordings per setting");
DEFINE_string(settings, "", "settings of the sensor or of the cloth; empty: all");
DEFINE_int32(cells, 512, "continuity: steps of friction");
DEFINE_string(contact, "gap", "continuity: gap or velocity");
DEFINE_int32(lines, 8, "continuity: lines of start states");
DEFINE_string(output, "", "folder for a CSV with one row per fit; empty: none");
DEFINE_int32(threads, 1, "fits side by side");

namespace clothid {
namespace {

constexpr char kHelp[] = R"(benchmark: accuracy, cost and time of the methods against each other.

  benchmark jacobian       --scene FILE --set LIST [--noise] [--starts] [--methods] [--precision] [--seed] [--threads]
                           [--output]
  benchmark discretization --scene FILE --set LIST [--nodes] [--steps] [--threads] [--output]
  benchmark coverage       --scene FILE --set LIST [--seeds] [--settings] [--noise] [--seed] [--threads] [--output]
  benchmark forward        [--scene LIST] [--nodes] [--steps] [--repeats] [--output]
  benchmark backprop       [--scene] [--settings] [--nodes] [--steps] [--methods] [--repeats] [--output]
  benchmark thresholds     [--scene] [--settings] [--nodes] [--steps] [--methods] [--output]
  benchmark continuity     [--nodes] [--cells] [--contact] [--lines] [--seed] [--threads] [--output]

jacobian: fits two parameters to a synthetic recording, without and with noise, from a grid of starts (friction 0.02 to
0.58, others 0.1 to 10 times the truth) with each method, and prints how many fits reached the minimum, rollouts, sweeps,
failed steps, processor seconds (medians), and these relative to `sensitivity` (median over the starts).

discretization: simulates the truth on a grid of twice the density at a quarter of the scene's time step, fits models of
several grids and time steps to what is seen of it at the scene's own nodes and steps, and prints how far each is off.

coverage: fits recordings that differ by their noise and prints how many 95 % intervals contain the truth, and the
reported standard deviation beside that of the estimates: with every point in every frame (full), with half the points
missing (half), with every third frame (third).

forward: simulates the scenes wind, slope and sphere on square grids and prints the time of a step and its phases, the
factorisation beside its floating-point operations at the speed of dgemm, the growth with the number of nodes, and the
memory of a rollout per node and step. Processor time, medians over the repeats.

backprop: the reverse sweep by each of its linear solvers on the same rollouts of a cloth in the wind, on a slope, on a
sphere, with k = 20 N/m and steps of 5 ms (soft) and with 1000 N/m and 10 ms (realistic): processor time per step and its
parts, iterations, steps in which LU stepped in, the largest error of the gradient against LU, and how many times faster
than the direct solvers; 8 right-hand sides relative to one; relative to the rollout.

thresholds: errors of the gradient, parameter by parameter, for thresholds of the iterative solvers from 1e-1 to 1e-9.
tools/plot_thresholds draws its CSV.

continuity: what makes the motion of a cloth jump. A cloth slides, or stays, on a sphere and on triangulated ones, for
200 steps each with friction from 0 to 0.35: the velocities of a corner, an edge's centre and the centre at steps 50 and
200, their largest jump between successive values of friction and at half the step, and the jumps of more than 1 % that
are left when looked at closer. And one step along random lines of start states, through all branches of the contact
law, in both contact modes: how the largest jump goes with the distance of the points. tools/plot_continuity draws it.

  --scene FILE      scene.json; parameters that are not set have its nominal values
                    forward: of wind, slope, sphere (wind,slope); backprop, thresholds: likewise (all)
  --set LIST        the parameters to fit (jacobian: two) and their true values, NAME=VALUE[,...]
  --noise SHARE     standard deviation of noise relative to the cloth's size; jacobian: 0 for none (0.01)
  --starts N        N x N starts, N even (4)
  --methods LIST    (all) jacobian: of adjoint, sensitivity, numeric, lbfgs; the linear solver of the first and the last
                    can be added as in adjoint:fixed_point:1e-4, see identify --adjoint
                    backprop: of sparse_lu, umfpack, fixed_point:1e-4, fixed_point:1e-6, gmres:1e-4, gmres:1e-6, reduced,
                    kept (reduced, with the factors that the rollout kept)
                    thresholds: of fixed_point, gmres, reduced
  --precision KIND  of the fits: adaptive or full; see identify --help (adaptive)
  --seed S          of the noise; coverage: the first; continuity: of the lines (1)
  --nodes LIST      nodes of the fitted grids along the first axis, the second in proportion (the scene's, the truth's)
                    forward, backprop: along both axes (12,24,48); thresholds: likewise (24); continuity: one odd
                    number (9)
  --steps LIST      time steps of the fitted models: the scene's over each of these (1,2,4)
                    forward: the number of steps (100); backprop, thresholds: likewise (20 on 12 x 12 nodes, down to 4)
  --repeats N       repetitions, of which the table gives medians (3)
  --seeds N         recordings per setting (40)
  --settings LIST   of full, half, third; backprop, thresholds: of soft, realistic (all)
  --cells N         steps of friction; also run with twice as many (512)
  --contact MODE    of the cloth that slides: gap or velocity (gap)
  --lines N         lines of start states (8)
  --threads N       fits, rollouts or lines side by side; only the seconds depend on it (1)
  --output DIR      writes COMMAND.csv, one row per fit, sweep, or scene and size; continuity: one per surface and value
                    of friction, and continuity_lines.csv
  --help, --version

Exit codes: 0 done, whatever the table says; 1 usage, or a file that cannot be opened or written; 2 bad content.

Examples:
  benchmark jacobian --scene datasets/drape.scene.json --set mu=0.3,k_stretch=100 --output /tmp/jacobian
  benchmark discretization --scene datasets/drape.scene.json --set mu=0.24,k_stretch=70 --nodes 8,16,31
  benchmark coverage --scene datasets/drape.scene.json --set mu=0.24,k_stretch=70 --threads 2
  benchmark forward --nodes 24,48,96,192 --steps 10
  benchmark backprop --scene wind,slope --nodes 48 --output /tmp/backprop
  benchmark continuity --threads 2 --output /tmp/continuity
)";

// Throws `Error` (kUsage) naming `flag`.
int ParseInteger(const std::string& text, const std::string& flag) {
  int number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) {
    throw Error(ErrorKind::kUsage, flag + ": '" + Printable(text) + "': expected an integer");
  }
  return number;
}

// "8,16" -> {8, 16}.
std::vector<int> ParseIntegers(const std::string& text, const std::string& flag) {
  std::vector<int> numbers;
  for (const std::string& item : ParseNames(text, flag)) numbers.push_back(ParseInteger(item, flag));
  return numbers;
}

JacobianBenchmarkOptions JacobianOptionsFromFlags() {
  JacobianBenchmarkOptions options;
  options.scene_path = FLAGS_scene;
  options.truth = ParseParameterValues(FLAGS_set, "--set");
  options.noise = FLAGS_noise;
  options.starts_per_axis = FLAGS_starts;
  if (!FLAGS_methods.empty()) options.methods = ParseNames(FLAGS_methods, "--methods");
  options.precision = ParseFitPrecision(FLAGS_precision);
  options.seed = FLAGS_seed;
  options.num_threads = FLAGS_threads;
  return options;
}

DiscretizationOptions DiscretizationOptionsFromFlags() {
  DiscretizationOptions options;
  options.scene_path = FLAGS_scene;
  options.truth = ParseParameterValues(FLAGS_set, "--set");
  options.nodes = ParseIntegers(FLAGS_nodes, "--nodes");
  if (!FLAGS_steps.empty()) options.step_divisors = ParseIntegers(FLAGS_steps, "--steps");
  options.num_threads = FLAGS_threads;
  return options;
}

CoverageOptions CoverageOptionsFromFlags() {
  CoverageOptions options;
  options.scene_path = FLAGS_scene;
  options.truth = ParseParameterValues(FLAGS_set, "--set");
  if (!FLAGS_settings.empty()) options.settings = ParseNames(FLAGS_settings, "--settings");
  options.noise = FLAGS_noise;
  options.num_seeds = FLAGS_seeds;
  options.seed = FLAGS_seed;
  options.num_threads = FLAGS_threads;
  return options;
}

ForwardBenchmarkOptions ForwardOptionsFromFlags() {
  ForwardBenchmarkOptions options;
  if (!FLAGS_scene.empty()) options.scenes = ParseNames(FLAGS_scene, "--scene");
  if (!FLAGS_nodes.empty()) options.nodes = ParseIntegers(FLAGS_nodes, "--nodes");
  if (!FLAGS_steps.empty()) options.num_steps = ParseInteger(FLAGS_steps, "--steps");
  options.repeats = FLAGS_repeats;
  return options;
}

// `nodes` where the flag is not given.
BackpropCaseOptions CasesFromFlags(const std::vector<int>& nodes) {
  BackpropCaseOptions options;
  options.nodes = FLAGS_nodes.empty() ? nodes : ParseIntegers(FLAGS_nodes, "--nodes");
  if (!FLAGS_scene.empty()) options.scenes = ParseNames(FLAGS_scene, "--scene");
  if (!FLAGS_settings.empty()) options.settings = ParseNames(FLAGS_settings, "--settings");
  if (!FLAGS_steps.empty()) {
    options.num_steps = ParseInteger(FLAGS_steps, "--steps");
    if (options.num_steps < 1) throw Error(ErrorKind::kUsage, "--steps: expected one number >= 1");
  }
  return options;
}

BackpropOptions BackpropOptionsFromFlags() {
  BackpropOptions options;
  options.cases = CasesFromFlags({12, 24, 48});
  options.methods = ParseNames(FLAGS_methods, "--methods");
  options.num_repeats = FLAGS_repeats;
  return options;
}

ThresholdOptions ThresholdOptionsFromFlags() {
  ThresholdOptions options;
  options.cases = CasesFromFlags({24});
  options.methods = ParseNames(FLAGS_methods, "--methods");
  return options;
}

ContinuityOptions ContinuityOptionsFromFlags() {
  ContinuityOptions options;
  if (!FLAGS_nodes.empty()) options.nodes = ParseInteger(FLAGS_nodes, "--nodes");
  options.num_cells = FLAGS_cells;
  options.contact = FLAGS_contact;
  options.num_lines = FLAGS_lines;
  options.seed = FLAGS_seed;
  options.num_threads = FLAGS_threads;
  return options;
}

std::string Describe(const JacobianFit& fit) {
  std::ostringstream text;
  text << fit.method << ", noise " << fit.noise << ", start " << fit.start[0] << " " << fit.start[1] << ": "
       << FitStatusName(fit.status) << ", " << fit.rollouts << " rollouts";
  return text.str();
}

std::string Describe(const DiscretizationFit& fit) {
  std::ostringstream text;
  text << fit.nodes[0] << " x " << fit.nodes[1] << " nodes, steps of " << 1e3 * fit.time_step
       << " ms: " << FitStatusName(fit.status) << ", " << fit.rollouts << " rollouts";
  return text.str();
}

std::string Describe(const CoverageFit& fit) {
  return fit.setting + ", seed " + std::to_string(fit.seed) + ": " + FitStatusName(fit.status) + ", " +
         std::to_string(fit.rollouts) + " rollouts";
}

std::string Describe(const ForwardCase& result) {
  return result.scene + ", " + std::to_string(result.nodes) + " x " + std::to_string(result.nodes) + " nodes";
}

// Reports every item: "fit 3 of 128: adjoint, noise 0.01, start 0.02 7: converged, 7 rollouts; 310 s left".
auto ProgressReporter(const std::string& what) {
  const auto start = std::chrono::steady_clock::now();
  return [start, what](const auto& item, int num_done, int num_items) {
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    std::ostringstream line;
    line << what << " " << num_done << " of " << num_items << ": " << Describe(item) << "; " << std::fixed
         << std::setprecision(0) << seconds.count() / num_done * (num_items - num_done) << " s left\n";
    std::cerr << line.str();
  };
}

template <typename Options>
void ReportProgress(Options* options) {
  options->on_fit = ProgressReporter("fit");
}

void ReportProgress(ForwardBenchmarkOptions* options) { options->on_rollout = ProgressReporter("rollout"); }

// Reports every case: "case 3 of 18: wind, realistic, 24 x 24 nodes; 12 s so far". Cases differ too much in size to say
// how long the rest takes.
void ReportCases(BackpropCaseOptions* options) {
  const auto start = std::chrono::steady_clock::now();
  options->on_case = [start](const BackpropCaseName& name, int num_done, int num_cases) {
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    std::ostringstream line;
    line << "case " << num_done << " of " << num_cases << ": " << name.ToString() << "; " << std::fixed
         << std::setprecision(0) << seconds.count() << " s so far\n";
    std::cerr << line.str();
  };
}

void ReportProgress(BackpropOptions* options) { ReportCases(&options->cases); }
void ReportProgress(ThresholdOptions* options) { ReportCases(&options->cases); }

void ReportProgress(ContinuityOptions* options) {
  const auto start = std::chrono::steady_clock::now();
  options->on_scan = [start](const std::string& scan, int num_done, int num_scans) {
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    std::ostringstream line;
    line << "scan " << num_done << " of " << num_scans << ": " << scan << "; " << std::fixed << std::setprecision(0)
         << seconds.count() << " s so far\n";
    std::cerr << line.str();
  };
}

// Runs the benchmark `run`, prints its table and, on request, writes its CSV `name`.csv.
template <typename Options, typename Benchmark>
int RunBenchmark(const std::string& name, Options options, Benchmark (*run)(const Options&),
                 std::string (*table)(const Benchmark&), std::string (*csv)(const Benchmark&)) {
  options.Validate();
  std::optional<OutputFolder> folder;  // before the fits, so that they do not run in vain
  if (!FLAGS_output.empty()) folder.emplace(FLAGS_output);
  ReportProgress(&options);
  const Benchmark benchmark = run(options);
  if (folder) {
    folder->Write(name + ".csv", csv(benchmark));
    folder->Commit();
  }
  std::cout << table(benchmark);
  return kExitSuccess;
}

// Like RunBenchmark, with a CSV for each of the two scans.
int RunContinuity() {
  ContinuityOptions options = ContinuityOptionsFromFlags();
  options.Validate();
  std::optional<OutputFolder> folder;
  if (!FLAGS_output.empty()) folder.emplace(FLAGS_output);
  ReportProgress(&options);
  const ContinuityBenchmark benchmark = RunContinuityBenchmark(options);
  if (folder) {
    folder->Write("continuity.csv", ContinuityCsv(benchmark));
    folder->Write("continuity_lines.csv", ContinuityLinesCsv(benchmark));
    folder->Commit();
  }
  std::cout << ContinuityTable(benchmark);
  return kExitSuccess;
}

int Run(const std::vector<std::string>& arguments) {
  const std::string known =
      "; there is: jacobian, discretization, coverage, forward, backprop, thresholds, continuity; see benchmark --help";
  if (arguments.empty()) throw Error(ErrorKind::kUsage, "a command is missing" + known);
  if (arguments.size() > 1) throw Error(ErrorKind::kUsage, "'" + arguments[1] + "': unexpected argument");
  const std::string& name = arguments[0];
  if (name == "jacobian") {
    return RunBenchmark(name, JacobianOptionsFromFlags(), RunJacobianBenchmark, JacobianTable, JacobianCsv);
  }
  if (name == "discretization") {
    return RunBenchmark(name, DiscretizationOptionsFromFlags(), RunDiscretizationBenchmark, DiscretizationTable,
                        DiscretizationCsv);
  }
  if (name == "coverage") {
    return RunBenchmark(name, CoverageOptionsFromFlags(), RunCoverageBenchmark, CoverageTable, CoverageCsv);
  }
  if (name == "forward") {
    return RunBenchmark(name, ForwardOptionsFromFlags(), RunForwardBenchmark, ForwardTable, ForwardCsv);
  }
  if (name == "backprop") {
    return RunBenchmark(name, BackpropOptionsFromFlags(), RunBackpropBenchmark, BackpropTable, BackpropCsv);
  }
  if (name == "thresholds") {
    return RunBenchmark(name, ThresholdOptionsFromFlags(), RunThresholdBenchmark, ThresholdTable, ThresholdCsv);
  }
  if (name == "continuity") return RunContinuity();
  throw Error(ErrorKind::kUsage, "'" + name + "': unknown command" + known);
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
