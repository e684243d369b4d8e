#include "identify/landscape/landscape.h"

#include <cmath>

namespace clothid {

double LandscapeAxis::Value(int index) const {
  if (index == 0) return lower;
  if (index == num_cells - 1) return upper;
  const double share = static_cast<double>(index) / (num_cells - 1);
  if (scale == ParameterScale::kLinear) return lower + share * (upper - lower);
  return lower * std::exp(share * std::log(upper / lower));
}

std::string ContactModeName(ContactMode mode) { return mode == ContactMode::kGap ? "gap" : "velocity"; }

int LandscapePlan::num_cells() const { return static_cast<int>(settings.size() * windows.size()) * cells_per_window(); }

int LandscapePlan::FirstCell(int setting, int window) const {
  return (setting * static_cast<int>(windows.size()) + window) * cells_per_window();
}

LandscapePlace LandscapePlan::PlaceOf(int cell) const {
  const int num_windows = static_cast<int>(windows.size());
  const int block = cell / cells_per_window(), inside = cell % cells_per_window();
  return {block / num_windows, block % num_windows, inside % windows.front().x.num_cells,
          inside / windows.front().x.num_cells};
}

std::vector<int> LandscapeShard::Cells(const LandscapePlan& plan) const {
  std::vector<int> cells;
  for (int cell = index; cell < plan.num_cells(); cell += count) cells.push_back(cell);
  return cells;
}

}  // namespace clothid
