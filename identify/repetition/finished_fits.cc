#include "identify/repetition/finished_fits.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "costs/prediction/alignment.h"
#include "identify/base/fitted_result.h"
#include "identify/base/join_words.h"
#include "identify/base/knot_names.h"
#include "sim/base/error.h"
#include "sim/base/json_document.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

namespace fs = std::filesystem;

constexpr char kResultName[] = "result.json";
constexpr std::size_t kShownFolders = 8;

std::string ResultPath(const std::string& folder) { return (fs::path(folder) / kResultName).string(); }

bool HasResult(const std::string& folder) {
  std::error_code ignored;
  return fs::exists(ResultPath(folder), ignored);
}

std::vector<std::string> SubFolders(const std::string& folder) {
  std::vector<std::string> found;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    std::error_code ignored;
    const bool is_hidden = it->path().filename().string().front() == '.';
    if (!is_hidden && it->is_directory(ignored)) found.push_back(it->path().string());
  }
  if (error) throw Error(ErrorKind::kIo, folder + ": cannot be read: " + error.message());
  std::sort(found.begin(), found.end());
  return found;
}

// Throws where some of `folders` have no result.
void ExpectResults(const std::string& parent, const std::vector<std::string>& folders) {
  std::vector<std::string> missing;
  for (const std::string& folder : folders) {
    if (!HasResult(folder)) missing.push_back(Printable(fs::path(folder).filename().string()));
  }
  if (missing.empty()) return;
  const std::size_t num_more = missing.size() > kShownFolders ? missing.size() - kShownFolders : 0;
  missing.resize(missing.size() - num_more);
  if (num_more > 0) missing.push_back(std::to_string(num_more) + " more");
  throw Error(ErrorKind::kBadData, parent + ": " + JoinWords(missing) + ": expected a finished fit in each, with " +
                                       kResultName + "; missing");
}

double NumberOrUnknown(const JsonNode& parent, const std::string& key) {
  const std::optional<JsonNode> node = parent.Find(key);
  const bool is_known = node && !node->is(JsonValue::Kind::kNull);
  return is_known ? node->Number() : std::numeric_limits<double>::quiet_NaN();
}

SingleEstimate ReadEstimate(const std::string& name, const JsonNode& node) {
  SingleEstimate estimate;
  estimate.name = name;
  const JsonNode scale = node.Require("scale", "\"log\" or \"linear\"; fit the recording again");
  if (scale.String() != "log" && scale.String() != "linear") scale.Fail("expected \"log\" or \"linear\"");
  estimate.scale = scale.String() == "log" ? ParameterScale::kLog : ParameterScale::kLinear;
  estimate.is_frozen = node.Require("frozen", "true or false").Boolean();
  estimate.value = node.Require("value", "a number").Number();
  node.Require("std", "a number or null");
  estimate.std = NumberOrUnknown(node, "std");
  estimate.lower95 = NumberOrUnknown(node, "lower95");
  estimate.upper95 = NumberOrUnknown(node, "upper95");
  estimate.step_error = NumberOrUnknown(node, "step_error");
  estimate.mesh_error = NumberOrUnknown(node, "mesh_error");
  estimate.lower_bound = std::fmax(estimate.lower_bound, NumberOrUnknown(node, "lower_bound"));
  estimate.upper_bound = std::fmin(estimate.upper_bound, NumberOrUnknown(node, "upper_bound"));
  return estimate;
}

// Throws where the fit is none to pool, or not yet.
void ExpectFinishedFit(const JsonNode& root) {
  const JsonNode schema = root.Require("schema", std::string("\"") + kResultSchema + "\"");
  if (schema.String() != kResultSchema) schema.Fail(std::string("expected \"") + kResultSchema + "\"");
  const JsonNode status = root.Require("status", "how the fit ended");
  if (status.String() != "converged" && status.String() != "not_converged") {
    status.Fail("expected a finished fit of one recording, got '" + Printable(status.String()) + "'");
  }
  if (const std::optional<JsonNode> repetitions = root.Find("repetitions")) {
    repetitions->Fail("expected a fit of one recording, got several that were judged together");
  }
}

std::string WhyNotUsed(const JsonNode& root) {
  const int code = root.Require("exit_code", "a number").Integer(0, 255);
  if (code != kExitNotConverged && code != kExitDoNotUse) return "";
  const std::vector<JsonNode> verdict = root.Require("verdict", "an array of lines").items();
  return verdict.empty() ? "not converged" : Printable(verdict.front().String());
}

// `version` of the first fit; empty: this is it.
SingleFit ReadFit(const std::string& folder, std::string* version) {
  const std::string path = ResultPath(folder);
  const JsonValue json = ParseJson(ReadText(path, kMaxJsonBytes), path);
  const JsonNode root(json, path);
  ExpectFinishedFit(root);
  const JsonNode provenance = root.Require("provenance", "an object");
  const JsonNode own_version = provenance.Require("version", "the version of clothid");
  if (version->empty()) *version = own_version.String();
  if (own_version.String() != *version) {
    own_version.Fail("expected '" + Printable(*version) + "', as the first fit has, got '" +
                     Printable(own_version.String()) + "'; fit again with one version");
  }
  SingleFit fit;
  fit.name = folder;
  fit.sha256 = provenance.Require("input_sha256", "a text").String();
  fit.why_not_used = WhyNotUsed(root);
  const JsonNode parameters = root.Require("parameters", "an object");
  for (const std::string& name : parameters.keys()) {
    fit.estimates.push_back(ReadEstimate(name, parameters.Require(name, "an object")));
  }
  return fit;
}

[[noreturn]] void FailOnParameters(const SingleFit& fit, const std::string& key, const std::string& problem) {
  throw Error(ErrorKind::kBadData, ResultPath(fit.name) + ": key '" + key + "': " + problem);
}

bool Contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

// Those of the recording itself left out.
std::vector<std::string> NamesOf(const SingleFit& fit, const std::vector<std::string>& own) {
  std::vector<std::string> names;
  for (const SingleEstimate& estimate : fit.estimates) {
    const bool is_own = Contains(own, BaseName(estimate.name)) || FindKnot(estimate.name);
    if (!is_own && !estimate.is_frozen) names.push_back(estimate.name);
  }
  return names;
}

}  // namespace

std::vector<std::string> FindFinishedFits(const std::vector<std::string>& paths) {
  std::vector<std::string> folders;
  for (const std::string& path : paths) {
    std::error_code ignored;
    if (!fs::is_directory(path, ignored)) throw Error(ErrorKind::kIo, path + ": expected the folder of a finished fit");
    if (HasResult(path)) {
      folders.push_back(path);
      continue;
    }
    const std::vector<std::string> found = SubFolders(path);
    if (found.empty()) {
      throw Error(ErrorKind::kBadData, path + ": expected " + kResultName + " of a finished fit, or folders of such");
    }
    ExpectResults(path, found);
    folders.insert(folders.end(), found.begin(), found.end());
  }
  return folders;
}

std::vector<SingleFit> ReadFinishedFits(const std::vector<std::string>& folders) {
  std::vector<SingleFit> fits;
  std::string version;
  for (const std::string& folder : folders) fits.push_back(ReadFit(folder, &version));
  return fits;
}

std::vector<std::string> SharedParameters(const std::vector<SingleFit>& fits, const std::vector<std::string>& chosen,
                                          const std::vector<std::string>& own) {
  const std::vector<std::string> left_out = ExpandAlignmentNames(own), wanted = ExpandAlignmentNames(chosen);
  const std::vector<std::string> names = NamesOf(fits.front(), left_out);
  for (const SingleFit& fit : fits) {
    for (const std::string& name : wanted) {
      if (fit.Find(name) == nullptr) FailOnParameters(fit, "parameters", "expected '" + Printable(name) + "' of --fit");
    }
    const std::vector<std::string> own_names = NamesOf(fit, left_out);
    if (wanted.empty() && !std::is_permutation(names.begin(), names.end(), own_names.begin(), own_names.end())) {
      FailOnParameters(fit, "parameters",
                       "expected " + JoinWords(names) + ", as " + fits.front().name + " has, got " +
                           JoinWords(own_names) + "; choose by --fit, leave out by --each");
    }
    for (const SingleEstimate& estimate : fit.estimates) {
      const SingleEstimate* first = fits.front().Find(estimate.name);
      if (first != nullptr && first->scale != estimate.scale) {
        FailOnParameters(fit, "parameters." + estimate.name + ".scale", "expected that of " + fits.front().name);
      }
    }
  }
  if (wanted.empty()) return names;
  std::vector<std::string> both;
  for (const std::string& name : names) {
    if (Contains(wanted, name)) both.push_back(name);
  }
  return both;
}

}  // namespace clothid
