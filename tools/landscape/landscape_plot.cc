#include "tools/landscape/landscape_plot.h"

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <system_error>

#include "identify/base/output_folder.h"
#include "identify/base/source_names.h"
#include "identify/page/page_template.h"
#include "sim/scene/parameters.h"
#include "tools/base/run_program.h"

namespace clothid {

// The files of these names, embedded by CMake.
std::string_view LandscapePage();        // page/landscape_page.html
std::string_view LandscapeStyle();       // page/landscape_page.css
std::string_view LandscapePageScript();  // page/landscape_*.js
std::string_view LandscapeScript();      // plot_landscape

namespace {

using Json = nlohmann::ordered_json;

// Exit codes of a python3 that is not there, and of plot_landscape without matplotlib.
constexpr int kNoProgram = 127, kNoMatplotlib = 3;

Json ValuesJson(const LandscapeAxis& axis) {
  Json values = Json::array();
  for (int i = 0; i < axis.num_cells; ++i) values.push_back(axis.Value(i));
  return values;
}

// Cells of one window of one setting, x fastest.
Json CellsJson(const Landscape& landscape, int setting, int window) {
  Json cost = Json::array(), changes = Json::array(), gradient_x = Json::array(), gradient_y = Json::array();
  Json failure = Json::object();
  const int first = landscape.plan.FirstCell(setting, window), count = landscape.plan.cells_per_window();
  for (int i = 0; i < count; ++i) {
    const LandscapeCell& cell = landscape.cells[first + i];
    cost.push_back(RoundedJson(cell.cost, 12));
    changes.push_back(cell.counts.contact_changes());
    gradient_x.push_back(RoundedJson(cell.gradient_x, 6));
    gradient_y.push_back(RoundedJson(cell.gradient_y, 6));
    if (!cell.failure.empty()) failure[std::to_string(i)] = cell.failure;
  }
  Json json = {{"cost", cost}, {"changes", changes}, {"failure", failure}};
  if (landscape.plan.has_gradients) {
    json["gradient_x"] = gradient_x;
    json["gradient_y"] = gradient_y;
  }
  return json;
}

// The true value of a parameter: its own, or the one of all obstacles for that of one; that of the cloth with itself is
// of none. Nothing where it was not set.
std::optional<double> TrueValue(const std::map<std::string, double>& truth, const std::string& parameter) {
  for (const std::string& name : {parameter, parameter.substr(0, parameter.find('.'))}) {
    if (const auto found = truth.find(name); found != truth.end()) return found->second;
    if (parameter == ParameterName({ParameterKind::kSelfFriction}, {})) break;
  }
  return std::nullopt;
}

Json TruthJson(const LandscapePart& part) {
  const LandscapeWindow& window = part.landscape.plan.windows.front();
  const std::optional<double> x = TrueValue(part.origin.truth, window.x.parameter);
  const std::optional<double> y = TrueValue(part.origin.truth, window.y.parameter);
  return x && y ? Json{{"x", *x}, {"y", *y}} : Json(nullptr);
}

Json SigmaJson(const LandscapeOrigin& origin) {
  if (!origin.sigma) return nullptr;
  return {{"source", SigmaSourceName(origin.sigma->source)},
          {"sigma_m", RoundedJson(origin.sigma->value, 12)},
          {"rmse_of_root_cost_m", RoundedJson(origin.sigma->rmse_of_root_cost, 12)}};
}

Json ProvenanceJson(const LandscapeOrigin& origin) {
  return {{"version", origin.version},
          {"git", origin.git},
          {"input_sha256", origin.input_sha256},
          {"truth", Json(origin.truth)}};
}

std::string DataText(const LandscapePart& part, const LandscapeSummary& summary) {
  const Landscape& landscape = part.landscape;
  Json json = {{"summary", Json::parse(SummaryJson(summary))},
               {"truth", TruthJson(part)},
               {"sigma", SigmaJson(part.origin)},
               {"provenance", ProvenanceJson(part.origin)},
               {"x", Json::array()},
               {"y", Json::array()},
               {"cells", Json::array()}};
  for (const LandscapeWindow& window : landscape.plan.windows) {
    json["x"].push_back(ValuesJson(window.x));
    json["y"].push_back(ValuesJson(window.y));
  }
  for (int setting = 0; setting < static_cast<int>(landscape.plan.settings.size()); ++setting) {
    for (int window = 0; window < static_cast<int>(landscape.plan.windows.size()); ++window) {
      json["cells"].push_back(CellsJson(landscape, setting, window));
    }
  }
  return ScriptText(json);
}

std::string LastLine(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  const std::size_t end = text.rfind('\n');
  return end == std::string::npos ? text : text.substr(end + 1);
}

// Why there is none, or an empty text.
std::string WritePng(const std::string& folder, OutputFolder* output) {
  const std::string name = "landscape.png";
  std::error_code ignored;
  std::filesystem::remove(std::filesystem::path(folder) / name, ignored);
  std::string reason;
  bool has_drawn = false;  // a python3 with matplotlib: why it failed is the reason, not what another one lacks
  for (const char* python : {"python3", "/usr/bin/python3"}) {
    const ProgramResult result =
        RunProgram({python, "-c", std::string(LandscapeScript()), folder, output->TemporaryPath(name)});
    if (result.exit_code == 0) {
      output->Commit();
      return "";
    }
    const bool draws = result.exit_code != kNoProgram && result.exit_code != kNoMatplotlib;
    if (has_drawn || (!draws && !reason.empty())) continue;
    has_drawn = draws;
    reason = result.exit_code == kNoProgram ? "there is no python3" : LastLine(result.err);
  }
  return name + " is left out: " + reason;
}

}  // namespace

std::string LandscapeHtml(const LandscapePart& part, const LandscapeSummary& summary) {
  const std::string style = "\n" + std::string(LandscapeStyle());
  return MakePage({"Landscape of the cost", LandscapePage(), style, /*has_charts=*/true, {LandscapePageScript()}},
                  DataText(part, summary));
}

LandscapePictures PlotLandscape(const LandscapePart& part, const LandscapeSummary& summary, const std::string& folder) {
  OutputFolder output(folder);
  output.KeepJournals();
  output.Write("landscape.html", LandscapeHtml(part, summary));
  output.Commit();
  LandscapePictures pictures;
  pictures.html = (std::filesystem::path(folder) / "landscape.html").string();
  pictures.note = WritePng(folder, &output);
  if (pictures.note.empty()) pictures.png = (std::filesystem::path(folder) / "landscape.png").string();
  return pictures;
}

}  // namespace clothid
