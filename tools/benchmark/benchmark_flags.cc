#include "tools/benchmark/benchmark_flags.h"

#include <gflags/gflags.h>

#include <charconv>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "identify/base/options.h"
#include "sim/base/error.h"
#include "sim/base/text_file.h"
#include "sim/scene/parameters.h"

// Of flags that are not given the options of each mode have the defaults.
DEFINE_string(scene, "", "scene.json; forward, backprop, accuracy, stability: names of scenes");
DEFINE_string(set, "", "the true values of the fitted parameters, NAME=VALUE[,...]");
DEFINE_string(noise, "", "standard deviation of noise, relative to the cloth's size");
DEFINE_string(starts, "", "starts per parameter, even");
DEFINE_string(methods, "", "methods to compare");
DEFINE_string(precision, "", "of the fits: adaptive or full");
DEFINE_string(seed, "", "seed of the noise");
DEFINE_string(nodes, "", "nodes along an axis of the grids");
DEFINE_string(steps, "", "number of steps; stability: steps per second");
DEFINE_string(repeats, "", "repetitions, of which the table gives medians");
DEFINE_string(seeds, "", "noisy recordings per setting");
DEFINE_string(initial, "", "coverage: the start of the fits: scene, first, smoothed, rest or moving");
DEFINE_string(cut, "", "coverage: s of the motion that are over when the recording begins");
DEFINE_string(handle_sigma, "", "coverage: standard deviation of noise on the handles' path in m");
DEFINE_string(sigma, "", "coverage, fields: standard deviation of noise, m");
DEFINE_string(frame_rate, "", "coverage: frames per second");
DEFINE_string(markers, "", "coverage: free nodes seen");
DEFINE_string(start_factor, "", "coverage: start over truth of the parameters");
DEFINE_string(truth_steps, "", "coverage: steps of the truth per step of the scene");
DEFINE_string(truth_levels, "", "coverage: so often the mesh of the truth is refined");
DEFINE_string(discretization, "", "coverage: what intervals count with besides noise: step, mesh or all");
DEFINE_string(field, "", "coverage: constants fitted as fields, NAME:ROWSxCOLUMNS[,...]");
DEFINE_string(wind_profile, "", "coverage: knots of a wind that is fitted over time, N[:AXES]");
DEFINE_string(force_sigma, "", "coverage: standard deviation of noise of a gauge at the handles in N");
DEFINE_string(sensor, "", "sensor.json of a camera and a gripper");
DEFINE_string(settings, "", "settings of the sensor, of the cloth or of the control grids");
DEFINE_string(quantities, "", "accuracy: of forward, gradient");
DEFINE_string(contact, "", "stability: of gap, velocity");
DEFINE_string(integrator, "", "of euler, sdirk2");
DEFINE_string(k_stretch, "", "stability: stretch stiffness, N/m");
DEFINE_string(mu, "", "stability: friction coefficients");
DEFINE_string(output, "", "folder for the CSV files; empty: none");
DEFINE_string(threads, "", "fits side by side");

namespace clothid {
namespace {

// Each throws `Error` (kUsage) naming the flag.
void Parse(const std::string& text, const std::string& /*flag*/, std::string* value) { *value = text; }

template <typename Integer>
void ParseInteger(const std::string& text, const std::string& flag, Integer* value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), *value);
  if (error != std::errc() || end != text.data() + text.size()) {
    throw Error(ErrorKind::kUsage, flag + ": '" + Printable(text) + "': expected an integer");
  }
}

void Parse(const std::string& text, const std::string& flag, int* value) { ParseInteger(text, flag, value); }
void Parse(const std::string& text, const std::string& flag, std::uint64_t* value) { ParseInteger(text, flag, value); }

void Parse(const std::string& text, const std::string& flag, double* value) {
  const std::optional<double> number = ParseNumber(text);
  if (!number) throw Error(ErrorKind::kUsage, flag + ": '" + Printable(text) + "': expected a number");
  *value = *number;
}

void Parse(const std::string& text, const std::string& flag, std::optional<double>* value) {
  Parse(text, flag, &value->emplace());
}

// "8,16" -> {8, 16}.
template <typename Item>
void Parse(const std::string& text, const std::string& flag, std::vector<Item>* values) {
  values->clear();
  for (const std::string& item : ParseNames(text, flag)) Parse(item, flag, &values->emplace_back());
}

bool IsGiven(const char* flag) { return !gflags::GetCommandLineFlagInfoOrDie(flag).is_default; }

// Sets `value` where the flag is given.
template <typename Value>
void Take(const char* flag, Value* value) {
  if (IsGiven(flag)) {
    Parse(gflags::GetCommandLineFlagInfoOrDie(flag).current_value, "--" + std::string(flag), value);
  }
}

BackpropCaseOptions CasesFromFlags() {
  BackpropCaseOptions options;
  Take("nodes", &options.nodes);
  Take("scene", &options.scenes);
  Take("settings", &options.settings);
  Take("steps", &options.num_steps);
  ExpectUsage(!IsGiven("steps") || options.num_steps >= 1, "--steps: expected one number >= 1");
  return options;
}

// Those of `identify --initial`, and the scene's own.
StartSource StartFromFlag() {
  if (FLAGS_initial.empty() || FLAGS_initial == "scene") return StartSource::kScene;
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
  Take("noise", &options.noise);
  Take("starts", &options.starts_per_axis);
  Take("methods", &options.methods);
  if (IsGiven("precision")) options.precision = ParseFitPrecision(FLAGS_precision);
  Take("seed", &options.seed);
  Take("threads", &options.num_threads);
  return options;
}

CoverageOptions CoverageOptionsFromFlags() {
  ExpectUsage(!IsGiven("sigma") || !IsGiven("noise"),
              "--sigma: expected without --noise, which says the same relative to the cloth's size");
  CoverageOptions options;
  options.scene_path = FLAGS_scene;
  options.truth = ParseParameterValues(FLAGS_set, "--set");
  Take("settings", &options.settings);
  Take("sensor", &options.sensor_path);
  options.import.start = StartFromFlag();
  Take("cut", &options.import.cut);
  Take("handle_sigma", &options.import.handle_sigma);
  Take("noise", &options.noise);
  Take("sigma", &options.sigma);
  Take("frame_rate", &options.frame_rate);
  Take("markers", &options.num_markers);
  Take("truth_steps", &options.resolution.steps);
  Take("truth_levels", &options.resolution.levels);
  options.discretization = ParseDiscretization(FLAGS_discretization);
  if (IsGiven("field")) options.unknowns.fields = ParseFieldRequests(FLAGS_field);
  options.unknowns.wind = ParseWindRequest(FLAGS_wind_profile);
  Take("force_sigma", &options.force_sigma);
  Take("start_factor", &options.start_factor);
  Take("seeds", &options.num_seeds);
  Take("seed", &options.seed);
  Take("threads", &options.num_threads);
  return options;
}

FieldsOptions FieldsOptionsFromFlags() {
  FieldsOptions options;
  options.scene_path = FLAGS_scene;
  for (const auto& [name, value] : ParseParameterValues(FLAGS_set, "--set")) {
    ExpectUsage(name == "k_stretch", "--set: expected k_stretch=NUMBER, the level of the truth");
    options.level = value;
  }
  Take("nodes", &options.nodes);
  Take("settings", &options.sides);
  Take("sigma", &options.noise);
  Take("seed", &options.seed);
  return options;
}

ForwardBenchmarkOptions ForwardOptionsFromFlags() {
  ForwardBenchmarkOptions options;
  Take("scene", &options.scenes);
  Take("integrator", &options.integrators);
  Take("nodes", &options.nodes);
  Take("steps", &options.num_steps);
  Take("repeats", &options.repeats);
  return options;
}

BackpropOptions BackpropOptionsFromFlags() {
  BackpropOptions options;
  options.cases = CasesFromFlags();
  Take("methods", &options.methods);
  Take("repeats", &options.num_repeats);
  return options;
}

AccuracyOptions AccuracyOptionsFromFlags() {
  AccuracyOptions options;
  Take("scene", &options.scenes);
  Take("settings", &options.settings);
  Take("quantities", &options.quantities);
  Take("integrator", &options.integrators);
  Take("nodes", &options.nodes);
  Take("repeats", &options.repeats);
  return options;
}

StabilityOptions StabilityOptionsFromFlags() {
  StabilityOptions options;
  Take("settings", &options.settings);
  Take("scene", &options.scenes);
  Take("integrator", &options.integrators);
  Take("contact", &options.contacts);
  Take("k_stretch", &options.stretch_stiffness);
  Take("mu", &options.friction_coefficients);
  Take("steps", &options.step_rates);
  Take("nodes", &options.nodes);
  Take("threads", &options.num_threads);
  return options;
}

}  // namespace clothid
