#include "identify/base/fitted_result.h"

#include <cmath>
#include <cstddef>
#include <optional>

#include "identify/base/model_error_json.h"
#include "sim/base/json_document.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

JsonValue ReadJson(const std::string& path) { return ParseJson(ReadText(path, kMaxJsonBytes), path); }

void ExpectResult(const JsonNode& root) {
  const std::string expected = std::string("\"") + kResultSchema + "\", with 'parameters'";
  const JsonNode schema = root.Require("schema", expected);
  if (!schema.is(JsonValue::Kind::kString) || schema.String() != kResultSchema) schema.Fail("expected " + expected);
}

std::map<std::string, double> EstimatesOf(const JsonNode& root) {
  std::map<std::string, double> values;
  const JsonNode parameters = root.Require("parameters", "an object");
  for (const std::string& name : parameters.keys()) {
    values[name] = parameters.Find(name)->Require("value", "a number").Number();
  }
  return values;
}

// Throws `Error` (kBadData) unless the estimates are all there is to know of the simulation of a fit that has ended.
void ExpectEnded(const JsonNode& root) {
  const JsonNode status = root.Require("status", "a text");
  if (status.String() != "converged" && status.String() != "not_converged") {
    status.Fail("expected that of a fit with an estimate, \"converged\" or \"not_converged\", got \"" +
                Printable(status.String()) + "\"");
  }
  if (const auto fields = root.Find("fields"))
    fields->Fail("expected a fit without fields, which no result.json holds");
}

// One for each recording; none where the key is missing.
std::vector<JsonNode> ItemsOf(const JsonNode& root, const std::string& key, std::size_t num_recordings) {
  const std::optional<JsonNode> list = root.Find(key);
  if (!list) return {};
  const std::vector<JsonNode> items = list->items();
  if (items.size() != num_recordings) list->Fail("expected one item for each recording of 'provenance.input_sha256'");
  return items;
}

FittedReading ReadReading(const JsonNode& node) {
  const JsonNode sigma = node.Require("sigma_m", "a number or null");
  return {node.Require("sigma_source", "a text").String(), node.Require("initial", "a text").String(),
          sigma.is(JsonValue::Kind::kNull) ? std::nan("") : sigma.Number()};
}

}  // namespace

std::map<std::string, double> ReadEstimates(const std::string& path) {
  const JsonValue json = ReadJson(path);
  const JsonNode root(json, path);
  ExpectResult(root);
  return EstimatesOf(root);
}

FittedResult ReadFittedResult(const std::string& path) {
  const JsonValue json = ReadJson(path);
  const JsonNode root(json, path);
  FittedResult result;
  result.path = path;
  ExpectResult(root);
  ExpectEnded(root);
  result.estimates = EstimatesOf(root);
  const JsonNode recordings = root.Require("provenance", "an object").Require("input_sha256", "a text");
  result.recordings = Split(recordings.String(), ',');
  const std::size_t num_recordings = result.recordings.size();
  result.model_errors.resize(num_recordings);  // all frames weigh the same
  const std::vector<JsonNode> errors = ItemsOf(root, "model_error", num_recordings);
  for (std::size_t r = 0; r < errors.size(); ++r) result.model_errors[r] = ReadModelError(errors[r]);
  if (const auto assimilation = root.Find("assimilation")) result.assimilation = ReadAssimilation(*assimilation);
  for (const JsonNode& item : ItemsOf(root, "recordings", num_recordings)) result.readings.push_back(ReadReading(item));
  return result;
}

}  // namespace clothid
