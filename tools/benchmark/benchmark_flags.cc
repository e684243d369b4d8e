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

// Of flags that are not given the options of each mode have the defaults.
DEFINE_string(scene, "", "names of scenes");
DEFINE_string(methods, "", "backprop: linear solvers to compare");
DEFINE_string(nodes, "", "nodes along an axis of the grids");
DEFINE_string(steps, "", "number of steps; stability: steps per second");
DEFINE_string(repeats, "", "repetitions, of which the table gives medians");
DEFINE_string(settings, "", "settings of the cloth");
DEFINE_string(quantities, "", "accuracy: of forward, gradient");
DEFINE_string(contact, "", "stability: of gap, velocity");
DEFINE_string(integrator, "", "of euler, sdirk2");
DEFINE_string(k_stretch, "", "stability: stretch stiffness, N/m");
DEFINE_double(stiffening, 0.0, "stability: of a membrane of yarns");
DEFINE_string(mu, "", "stability: friction coefficients");
DEFINE_string(output, "", "folder for the CSV files; empty: none");
DEFINE_string(threads, "", "stability: cells side by side");

namespace clothid {
namespace {

// Each throws `Error` (kUsage) naming the flag.
void Parse(const std::string& text, const std::string& /*flag*/, std::string* value) { *value = text; }

void Parse(const std::string& text, const std::string& flag, int* value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), *value);
  if (error != std::errc() || end != text.data() + text.size()) {
    throw Error(ErrorKind::kUsage, flag + ": '" + Printable(text) + "': expected an integer");
  }
}

void Parse(const std::string& text, const std::string& flag, double* value) {
  const std::optional<double> number = ParseNumber(text);
  if (!number) throw Error(ErrorKind::kUsage, flag + ": '" + Printable(text) + "': expected a number");
  *value = *number;
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

}  // namespace

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
  options.stiffening = FLAGS_stiffening;
  Take("mu", &options.friction_coefficients);
  Take("steps", &options.step_rates);
  Take("nodes", &options.nodes);
  Take("threads", &options.num_threads);
  return options;
}

}  // namespace clothid
