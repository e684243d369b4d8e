#include "tools/landscape/landscape_summary.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "identify/base/join_words.h"

namespace clothid {
namespace {

using Json = nlohmann::ordered_json;

// Of the `count` cells from `first` on. Sums of whole numbers below 2^53 are exact, so that no order of the cells shows
// in the means.
ContactMeans MeansOf(const LandscapeCell* first, int count) {
  double rollouts = 0.0, steps = 0.0;
  ContactMeans means = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
  for (const LandscapeCell* cell = first; cell != first + count; ++cell) {
    if (!std::isfinite(cell->cost)) continue;
    const RolloutCounts& counts = cell->counts;
    rollouts += 1.0;
    steps += counts.steps + counts.substeps;
    means.contact_changes += counts.contact_changes();
    means.nodes_joined += counts.nodes_joined;
    means.nodes_left += counts.nodes_left;
    means.branch_switches += counts.branch_switches;
    means.obstacle_switches += counts.obstacle_switches;
    means.contacts_per_step += counts.contacts;
  }
  for (double* mean : {&means.contact_changes, &means.nodes_joined, &means.nodes_left, &means.branch_switches,
                       &means.obstacle_switches}) {
    *mean /= rollouts;  // 0/0 is NaN
  }
  means.contacts_per_step /= steps;
  return means;
}

WindowSummary SummarizeWindow(const Landscape& landscape, int setting, int window) {
  const LandscapePlan& plan = landscape.plan;
  WindowSummary summary;
  summary.roughness = RoughnessOf(GridOf(landscape, setting, window));
  const int first = plan.FirstCell(setting, window);
  for (int index = first; index < first + plan.cells_per_window(); ++index) {
    const LandscapeCell& cell = landscape.cells[index];
    summary.failed_steps += cell.counts.failed_steps;
    summary.substeps += cell.counts.substeps;
    if (!std::isfinite(cell.cost)) continue;
    if (!std::isnan(summary.minimum) && cell.cost >= summary.minimum) continue;
    const LandscapePlace place = plan.PlaceOf(index);
    summary.minimum = cell.cost;
    summary.x = plan.windows[window].x.Value(place.ix);
    summary.y = plan.windows[window].y.Value(place.iy);
  }
  summary.contact = MeansOf(&landscape.cells[first], plan.cells_per_window());
  return summary;
}

Json AxisJson(const LandscapeAxis& axis) {
  return {{"parameter", axis.parameter},
          {"scale", axis.scale == ParameterScale::kLog ? "log" : "linear"},
          {"cells", axis.num_cells}};
}

Json WindowJson(const LandscapeWindow& window, const WindowSummary& summary) {
  const LandscapeRoughness& roughness = summary.roughness;
  const ContactMeans& contact = summary.contact;
  return {{"zoom", window.zoom},
          {"x", {window.x.lower, window.x.upper}},
          {"y", {window.y.lower, window.y.upper}},
          {"minimum", {{"cost", summary.minimum}, {"x", summary.x}, {"y", summary.y}}},
          {"range", roughness.range},
          {"roughness",
           {{"off_quadratic", roughness.off_quadratic},
            {"second_difference", roughness.second_difference},
            {"gradient_gap", roughness.gradient_gap},
            {"missing", roughness.reason.empty() ? Json(nullptr) : Json(roughness.reason)}}},
          {"per_rollout",
           {{"contact_changes", contact.contact_changes},
            {"nodes_joined", contact.nodes_joined},
            {"nodes_left", contact.nodes_left},
            {"branch_switches", contact.branch_switches},
            {"obstacle_switches", contact.obstacle_switches}}},
          {"contacts_per_step", contact.contacts_per_step},
          {"cells", roughness.cells},
          {"failed_cells", roughness.failed_cells},
          {"failed_steps", summary.failed_steps},
          {"substeps", summary.substeps}};
}

std::string SettingText(const LandscapeSetting& setting) {
  return setting.name.empty() ? "scene as it is" : setting.name;
}

std::string NumberOrDash(double value, int digits) { return std::isfinite(value) ? NumberText(value, digits) : "-"; }

constexpr char kLegend[] =
    "off quad., 2nd diff., grad. gap: roughness, relative to the range; changes: contact events per rollout;\n"
    "contacts: nodes in contact per step; failed: cells\n";

using Row = std::vector<std::string>;

// Columns of the table: what heads each, and what stands there.
std::vector<std::pair<std::string, std::string>> Columns(const LandscapeSetting& setting, const LandscapeWindow& window,
                                                         const WindowSummary& summary) {
  const LandscapeRoughness& roughness = summary.roughness;
  return {{"setting", SettingText(setting)},
          {"contact", ContactModeName(setting.contact_mode)},
          {"zoom", NumberOrDash(window.zoom, 6)},
          {"minimum", NumberOrDash(summary.minimum, 5)},
          {"at " + window.x.parameter, NumberOrDash(summary.x, 5)},
          {"at " + window.y.parameter, NumberOrDash(summary.y, 5)},
          {"range", NumberOrDash(roughness.range, 3)},
          {"off quad.", NumberOrDash(roughness.off_quadratic, 3)},
          {"2nd diff.", NumberOrDash(roughness.second_difference, 3)},
          {"grad. gap", NumberOrDash(roughness.gradient_gap, 3)},
          {"changes", NumberOrDash(summary.contact.contact_changes, 5)},
          {"contacts", NumberOrDash(summary.contact.contacts_per_step, 4)},
          {"failed", std::to_string(roughness.failed_cells)},
          {"substeps", std::to_string(summary.substeps)}};
}

// The first two columns to the left, the others to the right.
std::string Align(const std::vector<Row>& rows) {
  std::vector<std::size_t> widths(rows.front().size(), 0);
  for (const Row& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::ostringstream out;
  for (const Row& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      out << (i > 0 ? "  " : "") << (i < 2 ? std::left : std::right) << std::setw(static_cast<int>(widths[i]))
          << row[i];
    }
    out << "\n";
  }
  return out.str();
}

}  // namespace

LandscapeSummary Summarize(const Landscape& landscape) {
  LandscapeSummary summary;
  summary.plan = landscape.plan;
  for (std::size_t setting = 0; setting < landscape.plan.settings.size(); ++setting) {
    for (std::size_t window = 0; window < landscape.plan.windows.size(); ++window) {
      summary.windows.push_back(SummarizeWindow(landscape, static_cast<int>(setting), static_cast<int>(window)));
    }
  }
  return summary;
}

std::string SummaryJson(const LandscapeSummary& summary) {
  Json json;
  json["schema"] = "clothid.landscape_summary/1";
  json["x"] = AxisJson(summary.plan.windows.front().x);
  json["y"] = AxisJson(summary.plan.windows.front().y);
  json["settings"] = Json::array();
  for (std::size_t i = 0; i < summary.plan.settings.size(); ++i) {
    const LandscapeSetting& setting = summary.plan.settings[i];
    Json windows = Json::array();
    for (std::size_t j = 0; j < summary.plan.windows.size(); ++j) {
      windows.push_back(WindowJson(summary.plan.windows[j], summary.Of(static_cast<int>(i), static_cast<int>(j))));
    }
    json["settings"].push_back(
        {{"name", setting.name}, {"contact", ContactModeName(setting.contact_mode)}, {"windows", windows}});
  }
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string SummaryTable(const LandscapeSummary& summary) {
  std::vector<Row> rows(1);
  std::string notes;
  for (std::size_t i = 0; i < summary.plan.settings.size(); ++i) {
    for (std::size_t j = 0; j < summary.plan.windows.size(); ++j) {
      const WindowSummary& window = summary.Of(static_cast<int>(i), static_cast<int>(j));
      Row row;
      for (const auto& [head, text] : Columns(summary.plan.settings[i], summary.plan.windows[j], window)) {
        if (i + j == 0) rows.front().push_back(head);
        row.push_back(text);
      }
      rows.push_back(row);
      if (!window.roughness.reason.empty()) {
        notes += row[0] + ", " + row[1] + ", zoom " + row[2] + ": " + window.roughness.reason + "\n";
      }
    }
  }
  return Align(rows) + notes + kLegend;
}

}  // namespace clothid
