#include "identify/base/options.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "identify/base/parallel_for.h"
#include "sim/base/error.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

[[noreturn]] void FailOnOption(const std::string& message) { throw Error(ErrorKind::kUsage, message); }

}  // namespace

void FitOptions::Validate() const {
  if (max_iterations < 1) FailOnOption("--max_iterations: expected a number >= 1");
  if (num_starts < 1) FailOnOption("--starts: expected a number >= 1");
  if (num_threads < 1 || num_threads > kMaxThreads) {
    FailOnOption("--threads: expected a number from 1 to " + std::to_string(kMaxThreads));
  }
  if (!(wind_smoothness >= 0.0 && std::isfinite(wind_smoothness))) {
    FailOnOption("--wind_smoothness: expected a number > 0, in m/s per square root of a second");
  }
  if (!(field_weight >= 0.0 && std::isfinite(field_weight))) FailOnOption("--field_weight: expected a number > 0");
  if (!(function_tolerance > 0.0)) FailOnOption("function_tolerance: expected a number > 0");
  if (!(parameter_tolerance > 0.0)) FailOnOption("parameter_tolerance: expected a number > 0");
}

std::vector<std::string> ParseNames(const std::string& text, const std::string& flag) {
  std::vector<std::string> names;
  if (text.empty()) return names;
  for (const std::string& item : Split(text, ',')) {
    const std::string name(Trimmed(item));
    if (name.empty()) FailOnOption(flag + ": expected names separated by single commas, got '" + Printable(text) + "'");
    if (std::count(names.begin(), names.end(), name) > 0) FailOnOption(flag + ": '" + name + "' is given twice");
    names.push_back(name);
  }
  return names;
}

JacobianMethod ParseJacobianMethod(const std::string& text) {
  for (JacobianMethod method : {JacobianMethod::kAdjoint, JacobianMethod::kSensitivity, JacobianMethod::kNumeric}) {
    if (text == JacobianMethodName(method)) return method;
  }
  FailOnOption("--jacobian: expected adjoint, sensitivity or numeric, got '" + Printable(text) + "'");
}

AdjointOptions ParseAdjointOptions(const std::string& text) {
  static const std::map<std::string, AdjointMethod> methods = {{"reduced", AdjointMethod::kReduced},
                                                               {"lu", AdjointMethod::kLu},
                                                               {"fixed_point", AdjointMethod::kFixedPoint},
                                                               {"gmres", AdjointMethod::kSystemGmres}};
  const std::vector<std::string> parts = Split(text, ':');
  const auto method = methods.find(parts[0]);
  AdjointOptions options;
  if (parts.size() == 2) options.threshold = ParseNumber(parts[1]);
  if (method == methods.end() || parts.size() > 2 ||
      (parts.size() == 2 && !(options.threshold && *options.threshold > 0.0 && *options.threshold < 1.0))) {
    FailOnOption(
        "--adjoint: expected reduced, lu, fixed_point or gmres, with or without a threshold in (0, 1) as in "
        "gmres:1e-6, got '" +
        Printable(text) + "'");
  }
  options.method = method->second;
  return options;
}

FitPrecision ParseFitPrecision(const std::string& text) {
  if (text == "adaptive") return FitPrecision::kAdaptive;
  if (text == "full") return FitPrecision::kFull;
  FailOnOption("--precision: expected adaptive or full, got '" + Printable(text) + "'");
}

void ParseSigma(const std::string& text, ReadMotionOptions* options) {
  const std::optional<double> sigma = ParseNumber(text);
  if (text == "recorded") {
    options->sigma_source = SigmaSource::kRecorded;
  } else if (text == "auto") {
    options->sigma_source = SigmaSource::kEstimated;
  } else if (sigma && *sigma > 0.0 && std::isfinite(*sigma)) {
    options->sigma_source = SigmaSource::kGiven;
    options->sigma = *sigma;
  } else {
    FailOnOption("--sigma: expected recorded, auto or a number > 0 in m, got '" + Printable(text) + "'");
  }
}

StartSource ParseStartSource(const std::string& text) {
  if (text == "first") return StartSource::kFirstFrame;
  if (text == "smoothed") return StartSource::kSmoothed;
  if (text == "estimated") return StartSource::kEstimated;
  if (text == "rest") return StartSource::kRest;
  if (text == "moving") return StartSource::kMoving;
  FailOnOption("--initial: expected estimated, rest, moving, smoothed or first, got '" + Printable(text) + "'");
}

DiscretizationParts ParseDiscretization(const std::string& text) {
  if (text.empty()) return {};
  if (text == "all") return {true, true};
  if (text == "step") return {true, false};
  if (text == "mesh") return {false, true};
  FailOnOption("--discretization: expected step, mesh or all, got '" + Printable(text) + "'");
}

TimeStepOption ParseTimeStep(const std::string& text) {
  if (text.empty()) return {};
  if (text == "auto") return {0.0, true};
  const std::optional<double> seconds = ParseNumber(text);
  if (seconds && *seconds > 0.0 && std::isfinite(*seconds)) return {*seconds, false};
  FailOnOption("--time_step: expected auto or a number > 0 in s, got '" + Printable(text) + "'");
}

bool ParseHorizon(const std::string& text) {
  if (text == "growing") return true;
  if (text == "full") return false;
  FailOnOption("--horizon: expected growing or full, got '" + Printable(text) + "'");
}

AssimilationOption ParseAssimilation(const std::string& text) {
  AssimilationOption option;
  if (text == "off") return option;
  option.kind = AssimilationOption::Kind::kAuto;
  if (text == "auto") return option;
  option.kind = AssimilationOption::Kind::kMemory;
  const std::size_t colon = text.find(':');
  option.given.memory = ParseNumber(text.substr(0, colon)).value_or(0.0);
  double smoothing = 0.0;
  if (colon != std::string::npos) {
    smoothing = ParseNumber(text.substr(colon + 1)).value_or(-1.0);
    option.given.smoothing = smoothing;
  }
  const bool has_memory = option.given.memory > 0.0 && std::isfinite(option.given.memory);
  if (has_memory && smoothing >= 0.0 && std::isfinite(smoothing)) return option;
  FailOnOption("--assimilate: expected off, auto or MEMORY[:LENGTH] in s and m, got '" + Printable(text) + "'");
}

std::string JacobianMethodName(JacobianMethod method) {
  switch (method) {
    case JacobianMethod::kAdjoint:
      return "adjoint";
    case JacobianMethod::kSensitivity:
      return "sensitivity";
    case JacobianMethod::kNumeric:
      return "numeric";
  }
  return "unknown";
}

}  // namespace clothid
