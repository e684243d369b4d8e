// A landscape without a simulation: a bowl in the axes' scales plus bumps that grow with the number of the setting.
#ifndef CLOTHID_TESTS_TOOLS_LANDSCAPE_BUMPY_LANDSCAPE_H_
#define CLOTHID_TESTS_TOOLS_LANDSCAPE_BUMPY_LANDSCAPE_H_

#include <cmath>
#include <iomanip>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "identify/landscape/landscape.h"

namespace clothid {

inline constexpr double kBumpyMu = 0.3, kBumpyStretch = 300.0;  // the lowest point of the bowl

inline LandscapeWindow BumpyWindow(double zoom, int num_cells) {
  const double half = 0.5 * zoom;
  return {zoom,
          {"mu", ParameterScale::kLinear, kBumpyMu - 0.6 * half, kBumpyMu + 0.6 * half, num_cells},
          {"k_stretch", ParameterScale::kLog, kBumpyStretch * std::pow(1e3, -half), kBumpyStretch * std::pow(1e3, half),
           num_cells}};
}

// Settings "<name>" in velocity and in gap mode, the latter without bumps; gradients are those of the bowl. Every cell
// has 100 steps and, in setting s, 10 s nodes joined, 9 s left and 5 s branch switches, 200 contacts in all.
inline Landscape BumpyLandscape(const std::vector<std::string>& names, const std::vector<double>& zooms,
                                int num_cells) {
  Landscape landscape;
  landscape.plan.has_gradients = true;
  for (const std::string& name : names) {
    landscape.plan.settings.push_back({name, ContactMode::kVelocity});
    landscape.plan.settings.push_back({name, ContactMode::kGap});
  }
  for (const double zoom : zooms) landscape.plan.windows.push_back(BumpyWindow(zoom, num_cells));
  landscape.cells.resize(landscape.plan.num_cells());
  for (int i = 0; i < landscape.plan.num_cells(); ++i) {
    const LandscapePlace place = landscape.plan.PlaceOf(i);
    const LandscapeWindow& window = landscape.plan.windows[place.window];
    const double s = (window.x.Value(place.ix) - kBumpyMu) / 0.3;
    const double t = std::log10(window.y.Value(place.iy) / kBumpyStretch);
    const bool has_bumps = landscape.plan.settings[place.setting].contact_mode == ContactMode::kVelocity;
    const double bumps = std::sin(97.0 * s + 53.0 * t) * std::sin(71.0 * t - 31.0 * s + place.setting);
    LandscapeCell& cell = landscape.cells[i];
    cell.cost = 0.5 + s * s + 0.6 * s * t + 0.4 * t * t + (has_bumps ? 2e-4 * (1 + place.setting) * bumps : 0.0);
    cell.gradient_x = (2.0 * s + 0.6 * t) / 0.3;
    cell.gradient_y = (0.6 * s + 0.8 * t) / std::log(10.0);
    cell.counts.steps = 100;
    cell.counts.contacts = 200;
    cell.counts.nodes_joined = 10 * place.setting;
    cell.counts.nodes_left = 9 * place.setting;
    cell.counts.branch_switches = 5 * place.setting;
  }
  return landscape;
}

inline void FailCell(int cell, const std::string& failure, Landscape* landscape) {
  landscape->cells[cell].cost = std::numeric_limits<double>::quiet_NaN();
  landscape->cells[cell].failure = failure;
  landscape->cells[cell].counts = {};
  landscape->cells[cell].counts.failed_steps = 1;
}

// The columns of landscape.csv that the pictures are made of.
inline std::string BumpyCsv(const Landscape& landscape) {
  std::ostringstream csv;
  csv << std::setprecision(17) << "x,y,setting,contact,cost\n";
  for (int i = 0; i < landscape.plan.num_cells(); ++i) {
    const LandscapePlace place = landscape.plan.PlaceOf(i);
    const LandscapeWindow& window = landscape.plan.windows[place.window];
    const LandscapeSetting& setting = landscape.plan.settings[place.setting];
    csv << window.x.Value(place.ix) << "," << window.y.Value(place.iy) << ",\"" << setting.name << "\","
        << (setting.contact_mode == ContactMode::kGap ? "gap" : "velocity") << ",";
    if (std::isfinite(landscape.cells[i].cost)) csv << landscape.cells[i].cost;
    csv << "\n";
  }
  return csv.str();
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_TOOLS_LANDSCAPE_BUMPY_LANDSCAPE_H_
