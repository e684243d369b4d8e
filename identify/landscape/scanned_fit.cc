#include "identify/landscape/scanned_fit.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "costs/prediction/parameter_block.h"
#include "identify/base/model_error_json.h"
#include "identify/base/source_names.h"
#include "sim/base/error.h"

namespace clothid {
namespace {

[[noreturn]] void FailOnResult(const FittedResult& result, const std::string& problem) {
  throw Error(ErrorKind::kUsage, "--result: " + result.path + ": " + problem);
}

// Whether the residuals of recording `r` were those of `motion`, which start and sigma decide.
bool IsReadAlike(const FittedResult& result, std::size_t r, const RecordedMotion& motion) {
  if (result.readings.empty()) {  // nobody told more of them than their files do
    return (motion.sigma_source == SigmaSource::kRecorded || motion.sigma_source == SigmaSource::kUnknown) &&
           (motion.start_source == StartSource::kScene || motion.start_source == StartSource::kFirstFrame);
  }
  const FittedReading& reading = result.readings[r];
  const double sigma = motion.sigma.size() > 0 ? motion.sigma.mean() : std::nan("");
  return reading.sigma_source == SigmaSourceName(motion.sigma_source) &&
         reading.start_source == StartSourceName(motion.start_source) &&
         (reading.sigma == sigma || (std::isnan(reading.sigma) && std::isnan(sigma)));
}

// Of the largest of a curve: on another processor predictions differ by 1e-8 m, variances of errors by more.
constexpr double kSameVariance = 1e-4;

bool IsSameCurve(const ErrorCurve& a, const ErrorCurve& b) {
  if (a.is_zero() || b.is_zero()) return a.is_zero() && b.is_zero();
  if (a.times.size() != b.times.size() || a.times != b.times) return false;
  const Eigen::ArrayXd first = a.alike * a.variances, second = b.alike * b.variances;
  return (first - second).abs().maxCoeff() <= kSameVariance * second.maxCoeff();
}

}  // namespace

ScannedFit ScannedFitOf(const FittedResult& result, const RecordedMotion& motion) {
  const auto found = std::find(result.recordings.begin(), result.recordings.end(), motion.sha256);
  if (found == result.recordings.end()) FailOnResult(result, "is a fit of other recordings than --target");
  const std::size_t r = static_cast<std::size_t>(found - result.recordings.begin());
  if (!IsReadAlike(result, r, motion)) {
    FailOnResult(result, "is a fit with another sigma or start; expected --sigma and --initial as of that fit");
  }
  ScannedFit fit;
  fit.model_error = result.model_errors[r];
  fit.assimilation = result.assimilation;
  const std::string suffix = "@" + std::to_string(r + 1);
  for (const auto& [name, value] : result.estimates) {
    const std::string base = BaseName(name);
    if (name == base || name == base + suffix) fit.held[base] = value;
  }
  return fit;
}

bool IsSameWeight(const ModelError& a, const ModelError& b) {
  return std::equal(a.curves.begin(), a.curves.end(), b.curves.begin(), IsSameCurve);
}

nlohmann::ordered_json ScannedFitJson(const ScannedFit& fit) {
  nlohmann::ordered_json held = nlohmann::ordered_json::object();
  for (const auto& [name, value] : fit.held) held[name] = value;
  nlohmann::ordered_json json = {{"held", held}, {"model_error", ModelErrorJson(fit.model_error)}};
  if (fit.assimilation.is_on()) json["assimilation"] = AssimilationJson(fit.assimilation);
  return json;
}

ScannedFit ReadScannedFit(const JsonNode& node) {
  ScannedFit fit;
  const JsonNode held = node.Require("held", "an object");
  for (const std::string& name : held.keys()) fit.held[name] = held.Find(name)->Number();
  fit.model_error = ReadModelError(node.Require("model_error", "an object"));
  if (const auto assimilation = node.Find("assimilation")) fit.assimilation = ReadAssimilation(*assimilation);
  return fit;
}

}  // namespace clothid
