#include "tools/benchmark/benchmark_flags.h"

#include <gflags/gflags.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "identify/base/options.h"
#include "sim/base/error.h"
#include "sim/base/text_file.h"
#include "sim/scene/parameters.h"

DEFINE_string(scene, "", "scene.json; backprop, forward, accuracy: of wind, slope, sphere");
DEFINE_string(set, "", "the true values of the fitted parameters, NAME=VALUE[,...]");
DEFINE_double(noise, 0.01, "standard deviation of noise, relative to the cloth's size");
DEFINE_int32(starts, 4, "starts per parameter, even");
DEFINE_string(methods, "", "methods to compare; empty: all");
DEFINE_string(precision, "adaptive", "of the fits: adaptive or full");
DEFINE_uint64(seed, 1, "seed of the noise");
DEFINE_string(nodes, "", "nodes along the first axis of the grids; empty: see --help");
DEFINE_string(steps, "", "a number of steps; stability: steps per second; empty: see --help");
DEFINE_int32(repeats, 3, "repetitions, of which the table gives medians");
DEFINE_int32(seeds, 40, "noisy recordings per setting");
DEFINE_string(initial, "scene", "coverage: the start of the fits: scene, first, smoothed, rest or moving");
DEFINE_double(cut, 0.0, "coverage: s of the motion that are over when the recording begins");
DEFINE_double(handle_sigma, 0.0, "coverage: standard deviation of noise on the handles' path in m");
DEFINE_double(sigma, 0.0, "coverage: standard deviation of noise, m, in place of --noise");
DEFINE_double(frame_rate, 0.0, "coverage: frames per second; not given: one per step");
DEFINE_int32(markers, 0, "coverage: free nodes seen; 0: all nodes");
DEFINE_double(start_factor, clothid::kStartFactor, "coverage: start over truth of the parameters");
DEFINE_int32(truth_steps, 1, "coverage: steps of the truth per step of the scene");
DEFINE_int32(truth_levels, 0, "coverage: so often the mesh of the truth is refined");
DEFINE_string(discretization, "", "coverage: what intervals count with besides noise: step, mesh or all");
DEFINE_string(sensor, "", "coverage: sensor.json of a camera and a gripper; empty: white noise");
DEFINE_string(settings, "", "settings of the sensor or of the cloth; empty: all");
DEFINE_string(bending, "", "forward: laws of bending and their k_bend; empty: the scenes' own");
DEFINE_string(quantities, "", "accuracy: of forward, gradient, fit; empty: all");
DEFINE_string(contact, "", "stability: of gap, velocity; empty: both");
DEFINE_string(integrator, "", "of euler, sdirk2; empty: both");
DEFINE_string(k_stretch, "", "stability: stretch stiffness, N/m; empty: see --help");
DEFINE_bool(gradients, true, "stability: check gradients, too");
DEFINE_string(mu, "", "stability: friction coefficients; empty: see --help");
DEFINE_string(output, "", "folder for a CSV with one row per fit; empty: none");
DEFINE_int32(threads, 1, "fits side by side");

namespace clothid {
namespace {

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

std::vector<double> ParseNumbers(const std::string& text, const std::string& flag) {
  std::vector<double> numbers;
  for (const std::string& item : ParseNames(text, flag)) {
    const std::optional<double> number = ParseNumber(item);
    if (!number) throw Error(ErrorKind::kUsage, flag + ": '" + Printable(item) + "': expected a number");
    numbers.push_back(*number);
  }
  return numbers;
}

void SetIntegrators(std::vector<std::string>* integrators) {
  if (!FLAGS_integrator.empty()) *integrators = ParseNames(FLAGS_integrator, "--integrator");
}

bool IsGiven(const char* flag) { return !gflags::GetCommandLineFlagInfoOrDie(flag).is_default; }

BackpropCaseOptions CasesFromFlags() {
  BackpropCaseOptions options;
  if (!FLAGS_nodes.empty()) options.nodes = ParseIntegers(FLAGS_nodes, "--nodes");
  if (!FLAGS_scene.empty()) options.scenes = ParseNames(FLAGS_scene, "--scene");
  if (!FLAGS_settings.empty()) options.settings = ParseNames(FLAGS_settings, "--settings");
  if (!FLAGS_steps.empty()) {
    options.num_steps = ParseInteger(FLAGS_steps, "--steps");
    if (options.num_steps < 1) throw Error(ErrorKind::kUsage, "--steps: expected one number >= 1");
  }
  return options;
}

// Those of `identify --initial`, and the scene's own.
StartSource StartFromFlag() {
  if (FLAGS_initial == "scene") return StartSource::kScene;
  for (const char* name : {"first", "smoothed", "rest", "moving"}) {
    if (FLAGS_initial == name) return ParseStartSource(name);
  }
  throw Error(ErrorKind::kUsage,
              "--initial: expected scene, first, smoothed, rest or moving, got '" + Printable(FLAGS_initial) + "'");
}

}  // namespace

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

CoverageOptions CoverageOptionsFromFlags() {
  CoverageOptions options;
  options.scene_path = FLAGS_scene;
  options.truth = ParseParameterValues(FLAGS_set, "--set");
  if (!FLAGS_settings.empty()) options.settings = ParseNames(FLAGS_settings, "--settings");
  options.sensor_path = FLAGS_sensor;
  options.import = {StartFromFlag(), FLAGS_cut, FLAGS_handle_sigma};
  options.noise = FLAGS_noise;
  if (IsGiven("sigma")) options.sigma = FLAGS_sigma;
  if (options.sigma && IsGiven("noise")) {
    throw Error(ErrorKind::kUsage,
                "--sigma: expected without --noise, which says the same relative to the cloth's size");
  }
  if (IsGiven("frame_rate")) options.frame_rate = FLAGS_frame_rate;
  options.num_markers = FLAGS_markers;
  options.resolution = {FLAGS_truth_steps, FLAGS_truth_levels};
  options.discretization = ParseDiscretization(FLAGS_discretization);
  options.start_factor = FLAGS_start_factor;
  options.num_seeds = FLAGS_seeds;
  options.seed = FLAGS_seed;
  options.num_threads = FLAGS_threads;
  return options;
}

ForwardBenchmarkOptions ForwardOptionsFromFlags() {
  ForwardBenchmarkOptions options;
  if (!FLAGS_scene.empty()) options.scenes = ParseNames(FLAGS_scene, "--scene");
  SetIntegrators(&options.integrators);
  if (!FLAGS_bending.empty()) options.bending = ParseNames(FLAGS_bending, "--bending");
  if (!FLAGS_nodes.empty()) options.nodes = ParseIntegers(FLAGS_nodes, "--nodes");
  if (!FLAGS_steps.empty()) options.num_steps = ParseInteger(FLAGS_steps, "--steps");
  options.repeats = FLAGS_repeats;
  return options;
}

BackpropOptions BackpropOptionsFromFlags() {
  BackpropOptions options;
  options.cases = CasesFromFlags();
  options.methods = ParseNames(FLAGS_methods, "--methods");
  options.num_repeats = FLAGS_repeats;
  return options;
}

AccuracyOptions AccuracyOptionsFromFlags() {
  AccuracyOptions options;
  if (!FLAGS_scene.empty()) options.scenes = ParseNames(FLAGS_scene, "--scene");
  if (!FLAGS_settings.empty()) options.settings = ParseNames(FLAGS_settings, "--settings");
  if (!FLAGS_quantities.empty()) options.quantities = ParseNames(FLAGS_quantities, "--quantities");
  SetIntegrators(&options.integrators);
  if (!FLAGS_nodes.empty()) options.nodes = ParseInteger(FLAGS_nodes, "--nodes");
  options.repeats = FLAGS_repeats;
  return options;
}

FieldsOptions FieldsOptionsFromFlags() {
  FieldsOptions options;
  options.scene_path = FLAGS_scene;
  for (const auto& [name, value] : ParseParameterValues(FLAGS_set, "--set")) {
    if (name != "k_stretch") throw Error(ErrorKind::kUsage, "--set: expected k_stretch=NUMBER, the level of the truth");
    options.level = value;
  }
  if (!FLAGS_nodes.empty()) options.nodes = ParseInteger(FLAGS_nodes, "--nodes");
  if (!FLAGS_settings.empty()) options.sides = ParseIntegers(FLAGS_settings, "--settings");
  if (IsGiven("sigma")) options.noise = FLAGS_sigma;
  options.seed = FLAGS_seed;
  return options;
}

StabilityOptions StabilityOptionsFromFlags() {
  StabilityOptions options;
  if (!FLAGS_settings.empty()) options.settings = ParseNames(FLAGS_settings, "--settings");
  if (!FLAGS_scene.empty()) options.scenes = ParseNames(FLAGS_scene, "--scene");
  SetIntegrators(&options.integrators);
  if (!FLAGS_contact.empty()) options.contacts = ParseNames(FLAGS_contact, "--contact");
  if (!FLAGS_k_stretch.empty()) options.stretch_stiffness = ParseNumbers(FLAGS_k_stretch, "--k_stretch");
  if (!FLAGS_mu.empty()) options.friction_coefficients = ParseNumbers(FLAGS_mu, "--mu");
  if (!FLAGS_steps.empty()) options.step_rates = ParseIntegers(FLAGS_steps, "--steps");
  if (!FLAGS_nodes.empty()) options.nodes = ParseInteger(FLAGS_nodes, "--nodes");
  options.check_gradients = FLAGS_gradients;
  options.seed = FLAGS_seed;
  options.num_threads = FLAGS_threads;
  return options;
}

}  // namespace clothid
