#include "tools/landscape/landscape_summary.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tools/landscape/landscape_plan.h"

namespace clothid {
namespace {

using Json = nlohmann::ordered_json;

// Sums of whole numbers, so that no order of the cells shows in the means.
struct CountSums {
  long long rollouts = 0, steps = 0, contacts = 0, joined = 0, left = 0, branches = 0, obstacles = 0, changes = 0;

  void Add(const RolloutCounts& counts) {
    ++rollouts;
    steps += counts.steps + counts.substeps;
    contacts += counts.contacts;
    joined += counts.nodes_joined;
    left += counts.nodes_left;
    branches += counts.branch_switches;
    obstacles += counts.obstacle_switches;
    changes += counts.contact_changes();
  }
};

double Mean(long long sum, long long count) {
  return count > 0 ? static_cast<double>(sum) / static_cast<double>(count) : std::numeric_limits<double>::quiet_NaN();
}

ContactMeans MeansOf(const CountSums& sums) {
  ContactMeans means;
  means.contact_changes = Mean(sums.changes, sums.rollouts);
  means.nodes_joined = Mean(sums.joined, sums.rollouts);
  means.nodes_left = Mean(sums.left, sums.rollouts);
  means.branch_switches = Mean(sums.branches, sums.rollouts);
  means.obstacle_switches = Mean(sums.obstacles, sums.rollouts);
  means.contacts_per_step = Mean(sums.contacts, sums.steps);
  return means;
}

WindowSummary SummarizeWindow(const Landscape& landscape, int setting, int window) {
  const LandscapePlan& plan = landscape.plan;
  WindowSummary summary;
  summary.roughness = RoughnessOf(GridOf(landscape, setting, window));
  CountSums sums;
  const int first = plan.FirstCell(setting, window);
  for (int index = first; index < first + plan.cells_per_window(); ++index) {
    const LandscapeCell& cell = landscape.cells[index];
    summary.failed_steps += cell.counts.failed_steps;
    summary.substeps += cell.counts.substeps;
    if (!std::isfinite(cell.cost)) continue;
    sums.Add(cell.counts);
    if (!std::isnan(summary.minimum) && cell.cost >= summary.minimum) continue;
    const LandscapePlace place = plan.PlaceOf(index);
    summary.minimum = cell.cost;
    summary.x = plan.windows[window].x.Value(place.ix);
    summary.y = plan.windows[window].y.Value(place.iy);
  }
  summary.contact = MeansOf(sums);
  return summary;
}

// NaN and infinity as null.
Json NumberJson(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json AxisJson(const LandscapeAxis& axis) {
  return {{"parameter", axis.parameter},
          {"scale", axis.scale == ParameterScale::kLog ? "log" : "linear"},
          {"cells", axis.num_cells}};
}

Json WindowJson(const LandscapeWindow& window, const WindowSummary& summary) {
  const LandscapeRoughness& roughness = summary.roughness;
  const ContactMeans& contact = summary.contact;
  return {
      {"zoom", window.zoom},
      {"x", {window.x.lower, window.x.upper}},
      {"y", {window.y.lower, window.y.upper}},
      {"minimum", {{"cost", NumberJson(summary.minimum)}, {"x", NumberJson(summary.x)}, {"y", NumberJson(summary.y)}}},
      {"range", NumberJson(roughness.range)},
      {"roughness",
       {{"off_quadratic", NumberJson(roughness.off_quadratic)},
        {"second_difference", NumberJson(roughness.second_difference)},
        {"gradient_gap", NumberJson(roughness.gradient_gap)},
        {"missing", roughness.reason.empty() ? Json(nullptr) : Json(roughness.reason)}}},
      {"per_rollout",
       {{"contact_changes", NumberJson(contact.contact_changes)},
        {"nodes_joined", NumberJson(contact.nodes_joined)},
        {"nodes_left", NumberJson(contact.nodes_left)},
        {"branch_switches", NumberJson(contact.branch_switches)},
        {"obstacle_switches", NumberJson(contact.obstacle_switches)}}},
      {"contacts_per_step", NumberJson(contact.contacts_per_step)},
      {"cells", roughness.cells},
      {"failed_cells", roughness.failed_cells},
      {"failed_steps", summary.failed_steps},
      {"substeps", summary.substeps}};
}

std::string SettingText(const LandscapeSetting& setting) {
  return setting.name.empty() ? "scene as it is" : setting.name;
}

std::string NumberText(double value, int digits) {
  if (!std::isfinite(value)) return "-";
  std::ostringstream out;
  out << std::setprecision(digits) << value;
  return out.str();
}

constexpr char kLegend[] =
    "off quad., 2nd diff., grad. gap: roughness, relative to the range; changes: contact events per rollout;\n"
    "contacts: nodes in contact per step; failed: cells\n";

using Row = std::vector<std::string>;

Row Header(const LandscapeWindow& window) {
  return {"setting",
          "contact",
          "zoom",
          "minimum",
          "at " + window.x.parameter,
          "at " + window.y.parameter,
          "range",
          "off quad.",
          "2nd diff.",
          "grad. gap",
          "changes",
          "contacts",
          "failed",
          "substeps"};
}

Row TableRow(const LandscapeSetting& setting, const LandscapeWindow& window, const WindowSummary& summary) {
  const LandscapeRoughness& roughness = summary.roughness;
  return {SettingText(setting),
          ContactModeName(setting.contact_mode),
          NumberText(window.zoom, 6),
          NumberText(summary.minimum, 5),
          NumberText(summary.x, 5),
          NumberText(summary.y, 5),
          NumberText(roughness.range, 3),
          NumberText(roughness.off_quadratic, 3),
          NumberText(roughness.second_difference, 3),
          NumberText(roughness.gradient_gap, 3),
          NumberText(summary.contact.contact_changes, 5),
          NumberText(summary.contact.contacts_per_step, 4),
          std::to_string(roughness.failed_cells),
          std::to_string(summary.substeps)};
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
  std::vector<Row> rows = {Header(summary.plan.windows.front())};
  std::string notes;
  for (std::size_t i = 0; i < summary.plan.settings.size(); ++i) {
    for (std::size_t j = 0; j < summary.plan.windows.size(); ++j) {
      const WindowSummary& window = summary.Of(static_cast<int>(i), static_cast<int>(j));
      const Row row = TableRow(summary.plan.settings[i], summary.plan.windows[j], window);
      rows.push_back(row);
      if (!window.roughness.reason.empty()) {
        notes += row[0] + ", " + row[1] + ", zoom " + row[2] + ": " + window.roughness.reason + "\n";
      }
    }
  }
  return Align(rows) + notes + kLegend;
}

}  // namespace clothid
