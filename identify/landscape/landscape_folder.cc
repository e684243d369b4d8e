#include "identify/landscape/landscape_folder.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string_view>
#include <system_error>
#include <vector>

#include "datasets/files/sha256.h"
#include "identify/base/source_names.h"
#include "identify/landscape/landscape_row.h"
#include "sim/base/error.h"
#include "sim/base/json_document.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

std::string PathOf(const std::string& folder, const char* name) {
  return (std::filesystem::path(folder) / name).string();
}

LandscapeAxis ReadAxis(const JsonNode& node) {
  LandscapeAxis axis;
  axis.parameter = node.Require("parameter", "a name").String();
  const JsonNode scale = node.Require("scale", "\"linear\" or \"log\"");
  if (scale.String() != "linear" && scale.String() != "log") scale.Fail("expected \"linear\" or \"log\"");
  axis.scale = scale.String() == "log" ? ParameterScale::kLog : ParameterScale::kLinear;
  axis.num_cells = node.Require("cells", "an integer").Integer(2, kMaxLandscapeCells);
  return axis;
}

LandscapeAxis ReadRange(LandscapeAxis axis, const JsonNode& node) {
  const std::vector<JsonNode> ends = node.items();
  if (ends.size() != 2) node.Fail("expected two numbers");
  axis.lower = ends[0].Number();
  axis.upper = ends[1].Number();
  if (!(axis.lower < axis.upper)) node.Fail("expected two increasing numbers");
  if (axis.scale == ParameterScale::kLog && !(axis.lower > 0.0)) node.Fail("expected numbers > 0 on a log axis");
  return axis;
}

LandscapePlan ReadPlan(const JsonNode& root) {
  LandscapePlan plan;
  const JsonNode axes = root.Require("axes", "an object");
  const LandscapeAxis x = ReadAxis(axes.Require("x", "an axis")), y = ReadAxis(axes.Require("y", "an axis"));
  if (x.parameter == y.parameter) axes.Fail("expected two parameters");
  const JsonNode windows = root.Require("windows", "an array");
  for (const JsonNode& window : windows.items()) {
    plan.windows.push_back({window.Require("zoom", "a number").PositiveNumber(),
                            ReadRange(x, window.Require("x", "a range")),
                            ReadRange(y, window.Require("y", "a range"))});
  }
  const JsonNode settings = root.Require("settings", "an array");
  for (const JsonNode& setting : settings.items()) {
    const JsonNode contact = setting.Require("contact", "\"gap\" or \"velocity\"");
    if (contact.String() != "gap" && contact.String() != "velocity") contact.Fail("expected \"gap\" or \"velocity\"");
    plan.settings.push_back({setting.Require("name", "a name").String(),
                             contact.String() == "gap" ? ContactMode::kGap : ContactMode::kVelocity});
  }
  if (plan.windows.empty()) windows.Fail("expected at least one window");
  if (plan.settings.empty()) settings.Fail("expected at least one setting");
  const double num_cells =
      static_cast<double>(x.num_cells) * y.num_cells * static_cast<double>(plan.windows.size() * plan.settings.size());
  if (num_cells > kMaxLandscapeCells) axes.Fail("expected at most " + std::to_string(kMaxLandscapeCells) + " cells");
  plan.has_gradients = root.Require("has_gradients", "true or false").Boolean();
  return plan;
}

SigmaSource ReadSigmaSource(const JsonNode& node) {
  for (const SigmaSource source :
       {SigmaSource::kUnknown, SigmaSource::kRecorded, SigmaSource::kGiven, SigmaSource::kEstimated}) {
    if (node.String() == SigmaSourceName(source)) return source;
  }
  node.Fail("expected \"unknown\", \"recorded\", \"given\" or \"estimated\"");
}

LandscapeSigma ReadSigma(const JsonNode& node) {
  const auto read = [&](const char* key) {
    const JsonNode number = node.Require(key, "a number > 0 or null");
    return number.is(JsonValue::Kind::kNull) ? std::nan("") : number.PositiveNumber();
  };
  return {ReadSigmaSource(node.Require("source", "a text")), read("sigma_m"), read("rmse_of_root_cost_m")};
}

LandscapeOrigin ReadOrigin(const JsonNode& root) {
  LandscapeOrigin origin;
  const JsonNode provenance = root.Require("provenance", "an object");
  origin.version = provenance.Require("version", "a text").String();
  origin.git = provenance.Require("git", "a text").String();
  origin.input_sha256 = provenance.Require("input_sha256", "a text").String();
  const JsonNode truth = root.Require("truth", "an object");
  for (const std::string& name : truth.keys()) origin.truth[name] = truth.Find(name)->Number();
  origin.fingerprint = root.Require("fingerprint", "a text").String();
  if (const std::optional<JsonNode> sigma = root.Find("sigma")) origin.sigma = ReadSigma(*sigma);
  if (const std::optional<JsonNode> fit = root.Find("fit")) origin.fit = ReadScannedFit(*fit);
  const JsonNode shard = root.Require("shard", "an object or null");
  if (!shard.is(JsonValue::Kind::kNull)) {
    origin.shard.count = shard.Require("count", "an integer").Integer(2, kMaxLandscapeCells);
    origin.shard.index = shard.Require("index", "an integer").Integer(0, origin.shard.count - 1);
  }
  return origin;
}

// One cell per line after the header, those of the shard in their order. Cells are made once there are lines for them.
void ReadCells(const std::string& folder, const std::string& sha256, LandscapePart* part) {
  const std::string path = PathOf(folder, kLandscapeCsv), text = ReadFile(path, kMaxCsvBytes);
  if (Sha256Hex({text}) != sha256) FailOnData(path, std::string("is not the file that ") + kPlanJson + " is of");
  const LandscapePlan& plan = part->landscape.plan;
  std::string_view rest = text;
  if (TakeLine(&rest) != RowHeader(plan)) FailOnData(path + ":1", "expected the header '" + RowHeader(plan) + "'");
  const std::vector<int> cells = part->origin.shard.Cells(plan);
  if (std::count(rest.begin(), rest.end(), '\n') < static_cast<std::ptrdiff_t>(cells.size())) {
    FailOnData(path, "expected a row for each of " + std::to_string(cells.size()) + " cells");
  }
  part->landscape.cells.resize(static_cast<std::size_t>(plan.num_cells()));
  int line = 1;
  for (const int cell : cells) {
    const std::string source = path + ":" + std::to_string(++line);
    part->landscape.cells[cell] = ParseRow(plan, cell, *TakeLine(&rest), source);
  }
  if (!rest.empty()) FailOnData(path + ":" + std::to_string(line + 1), "expected no further row");
}

void ReadTiming(const std::string& folder, LandscapePart* part) {
  const std::string path = PathOf(folder, kTimingCsv), text = ReadFile(path, kMaxCsvBytes);
  std::string_view rest = text;
  TakeLine(&rest);
  int line = 1;
  for (const int cell : part->origin.shard.Cells(part->landscape.plan)) {
    const std::string source = path + ":" + std::to_string(++line), start = std::to_string(cell) + ",";
    const std::string_view row = TakeLine(&rest).value_or("");
    const std::optional<double> seconds =
        row.substr(0, start.size()) == start ? ParseNumber(row.substr(start.size())) : std::nullopt;
    if (!seconds) FailOnData(source, "expected the seconds of cell " + std::to_string(cell));
    part->landscape.cells[cell].seconds = *seconds;
  }
}

}  // namespace

bool HasLandscape(const std::string& folder) {
  std::error_code ignored;
  return std::filesystem::exists(PathOf(folder, kPlanJson), ignored);
}

LandscapePart ReadLandscapePart(const std::string& folder) {
  std::error_code ignored;
  if (std::filesystem::exists(PathOf(folder, kCellStore), ignored)) {
    FailOnData(folder, "the scan was stopped before its end; run it again with --resume");
  }
  const std::string path = PathOf(folder, kPlanJson);
  const JsonValue json = ParseJson(ReadFile(path, kMaxJsonBytes), path);
  const JsonNode root(json, path);
  const JsonNode schema = root.Require("schema", kLandscapeSchema);
  if (schema.String() != kLandscapeSchema) schema.Fail(std::string("expected \"") + kLandscapeSchema + "\"");
  LandscapePart part;
  part.landscape.plan = ReadPlan(root);
  part.origin = ReadOrigin(root);
  ReadCells(folder, root.Require("landscape_sha256", "a text").String(), &part);
  ReadTiming(folder, &part);
  return part;
}

LandscapePart ReadWholeLandscape(const std::string& folder) {
  LandscapePart part = ReadLandscapePart(folder);
  const LandscapeShard& shard = part.origin.shard;
  if (!shard.is_whole()) {
    FailOnData(folder, "is shard " + std::to_string(shard.index) + " of " + std::to_string(shard.count) +
                           "; expected a whole scan, see landscape merge");
  }
  return part;
}

}  // namespace clothid
