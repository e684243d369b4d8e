#include "identify/base/model_error_json.h"

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace clothid {
namespace {

constexpr std::array<const char*, kNumPredictedKinds> kKindNames = {"points", "clouds", "forces"};

Eigen::VectorXd ReadNumbers(const JsonNode& node) {
  const std::vector<JsonNode> items = node.items();
  Eigen::VectorXd numbers(static_cast<Eigen::Index>(items.size()));
  for (std::size_t i = 0; i < items.size(); ++i) numbers[static_cast<Eigen::Index>(i)] = items[i].Number();
  return numbers;
}

ErrorCurve ReadCurve(const JsonNode& node) {
  ErrorCurve curve;
  const JsonNode times = node.Require("times", "an array"), variances = node.Require("variance", "an array");
  const JsonNode alike = node.Require("alike", "a number >= 1");
  curve.times = ReadNumbers(times);
  curve.variances = ReadNumbers(variances);
  curve.alike = alike.Number();
  for (Eigen::Index i = 1; i < curve.times.size(); ++i) {
    if (!(curve.times[i - 1] < curve.times[i])) times.Fail("expected increasing numbers");
  }
  if (curve.variances.size() != curve.times.size()) variances.Fail("expected as many numbers as 'times' has");
  if ((curve.variances.array() < 0.0).any()) variances.Fail("expected numbers >= 0");
  if (curve.alike < 1.0) alike.Fail("expected a number >= 1");
  return curve;
}

// Nothing where it is null.
std::optional<double> NumberOrNull(const JsonNode& node, const char* key) {
  const JsonNode value = node.Require(key, "a number or null");
  return value.is(JsonValue::Kind::kNull) ? std::nullopt : std::optional<double>(value.Number());
}

}  // namespace

nlohmann::ordered_json ModelErrorJson(const ModelError& error) {
  nlohmann::ordered_json curves = nlohmann::ordered_json::object();
  for (std::size_t k = 0; k < kKindNames.size(); ++k) {
    const ErrorCurve& curve = error.curves[k];
    if (curve.is_zero()) continue;
    const Eigen::VectorXd deviations = curve.variances.cwiseSqrt();
    curves[kKindNames[k]] = {
        {"times", curve.times}, {"deviation", deviations}, {"variance", curve.variances}, {"alike", curve.alike}};
  }
  return curves;
}

ModelError ReadModelError(const JsonNode& node) {
  ModelError error;
  for (const std::string& name : node.keys()) {
    std::size_t k = 0;
    while (k < kKindNames.size() && name != kKindNames[k]) ++k;
    if (k == kKindNames.size()) node.Fail("expected points, clouds and forces alone");
    error.curves[k] = ReadCurve(*node.Find(name));
  }
  return error;
}

nlohmann::ordered_json AssimilationJson(const Assimilation& assimilation) {
  nlohmann::ordered_json json = {{"memory_s", nullptr}, {"smoothing_m", nullptr}};
  if (!assimilation.is_on()) return json;
  json["memory_s"] = assimilation.memory;
  if (assimilation.smoothing) json["smoothing_m"] = *assimilation.smoothing;
  return json;
}

Assimilation ReadAssimilation(const JsonNode& node) {
  const std::optional<double> memory = NumberOrNull(node, "memory_s");
  if (!memory) return {};
  if (!(*memory > 0.0)) node.Find("memory_s")->Fail("expected a number > 0, or null");
  return {*memory, NumberOrNull(node, "smoothing_m")};
}

}  // namespace clothid
