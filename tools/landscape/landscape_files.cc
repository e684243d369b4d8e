#include "tools/landscape/landscape_files.h"

#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "datasets/files/sha256.h"
#include "identify/base/source_names.h"
#include "identify/landscape/landscape_row.h"
#include "sim/base/error.h"
#include "sim/base/text_file.h"
#include "tools/landscape/landscape_summary.h"

namespace clothid {
namespace {

nlohmann::ordered_json SigmaJson(const LandscapeSigma& sigma) {
  return {{"source", SigmaSourceName(sigma.source)},
          {"sigma_m", sigma.value},
          {"rmse_of_root_cost_m", sigma.rmse_of_root_cost}};
}

nlohmann::ordered_json PlanJson(const LandscapePlan& plan, const LandscapeOrigin& origin, const std::string& csv) {
  nlohmann::ordered_json json;
  json["schema"] = kLandscapeSchema;
  const auto axis = [](const LandscapeAxis& a) {
    return nlohmann::ordered_json{{"parameter", a.parameter},
                                  {"scale", a.scale == ParameterScale::kLog ? "log" : "linear"},
                                  {"cells", a.num_cells}};
  };
  json["axes"] = {{"x", axis(plan.windows.front().x)}, {"y", axis(plan.windows.front().y)}};
  for (const LandscapeWindow& window : plan.windows) {
    json["windows"].push_back(
        {{"zoom", window.zoom}, {"x", {window.x.lower, window.x.upper}}, {"y", {window.y.lower, window.y.upper}}});
  }
  for (const LandscapeSetting& setting : plan.settings) {
    json["settings"].push_back({{"name", setting.name}, {"contact", ContactModeName(setting.contact_mode)}});
  }
  json["has_gradients"] = plan.has_gradients;
  json["shard"] = nullptr;
  if (!origin.shard.is_whole()) json["shard"] = {{"index", origin.shard.index}, {"count", origin.shard.count}};
  json["truth"] = nlohmann::ordered_json::object();
  for (const auto& [name, value] : origin.truth) json["truth"][name] = value;
  if (origin.sigma) json["sigma"] = SigmaJson(*origin.sigma);
  if (origin.fit) json["fit"] = ScannedFitJson(*origin.fit);
  json["fingerprint"] = origin.fingerprint;
  json["landscape_sha256"] = Sha256Hex({csv});
  json["provenance"] = {{"version", origin.version}, {"git", origin.git}, {"input_sha256", origin.input_sha256}};
  return json;
}

[[noreturn]] void FailOnFolder(const std::string& folder, const std::string& problem) {
  throw Error(ErrorKind::kUsage, folder + ": " + problem);
}

std::string NameOf(const LandscapeShard& shard) {
  return "shard " + std::to_string(shard.index) + " of " + std::to_string(shard.count);
}

}  // namespace

bool IsLandscapeFile(const std::string& name) {
  return name == kLandscapeCsv || name == kTimingCsv || name == kPlanJson || name == kSummaryJson;
}

void WriteLandscape(const Landscape& landscape, const LandscapeOrigin& origin, OutputFolder* folder) {
  std::string csv = RowHeader(landscape.plan) + "\n", timing = "cell,seconds\n";
  for (const int cell : origin.shard.Cells(landscape.plan)) {
    csv += CellRow(landscape.plan, cell, landscape.cells[cell]) + "\n";
    timing += std::to_string(cell) + "," + ShortestText(landscape.cells[cell].seconds) + "\n";
  }
  folder->RemoveOthers(IsLandscapeFile);
  folder->Write(kLandscapeCsv, csv);
  folder->Write(kTimingCsv, timing);
  const nlohmann::ordered_json plan = PlanJson(landscape.plan, origin, csv);
  folder->Write(kPlanJson, plan.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
  if (origin.shard.is_whole()) folder->Write(kSummaryJson, SummaryJson(Summarize(landscape)));
}

LandscapePart MergeLandscapes(const std::vector<std::string>& folders) {
  if (folders.empty()) throw Error(ErrorKind::kUsage, "expected the folders of the shards; see landscape --help");
  LandscapePart merged;
  std::map<int, std::string> folder_of_shard;
  for (const std::string& folder : folders) {
    LandscapePart part = ReadLandscapePart(folder);
    const LandscapeShard shard = part.origin.shard;
    if (folder_of_shard.empty()) merged = part;
    if (part.origin.fingerprint != merged.origin.fingerprint) {
      FailOnFolder(folder,
                   "is of another scan than " + folders.front() + ": recording, scene, program or flags differ");
    }
    if (shard.count != merged.origin.shard.count) {
      FailOnFolder(folder, "is " + NameOf(shard) + ", but " + folders.front() + " is " + NameOf(merged.origin.shard));
    }
    const auto [found, is_new] = folder_of_shard.emplace(shard.index, folder);
    if (!is_new) FailOnFolder(folder, "is " + NameOf(shard) + ", as " + found->second + " is");
    for (const int cell : shard.Cells(merged.landscape.plan)) {
      merged.landscape.cells[cell] = std::move(part.landscape.cells[cell]);
    }
  }
  for (LandscapeShard shard = {0, merged.origin.shard.count}; shard.index < shard.count; ++shard.index) {
    if (folder_of_shard.count(shard.index) == 0) throw Error(ErrorKind::kUsage, NameOf(shard) + " is missing");
  }
  merged.origin.shard = {};
  return merged;
}

}  // namespace clothid
