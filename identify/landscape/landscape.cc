#include "identify/landscape/landscape.h"

#include <cmath>

#include "datasets/observation/observation.h"

namespace clothid {
namespace {

bool IsSame(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

}  // namespace

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

LandscapeSigma SigmaOf(const RecordedMotion& motion) {
  LandscapeSigma sigma;
  sigma.source = motion.sigma_source;
  sigma.rmse_of_root_cost = RmseOfRootCost(motion);
  const Observation observation(motion);
  if (!std::isnan(sigma.rmse_of_root_cost)) {
    sigma.value = observation.sigma(observation.coordinates().front());
  }
  return sigma;
}

bool IsSameSigma(const LandscapeSigma& a, const LandscapeSigma& b) {
  return a.source == b.source && IsSame(a.value, b.value);
}

double RmseOfRootCost(const RecordedMotion& motion) {
  const Observation observation(motion);
  if (!observation.forces().is_empty()) return std::nan("");
  const double sigma = observation.sigma(observation.coordinates().front());
  double num_points = 0.0;
  for (const SeenCoordinate& seen : observation.coordinates()) {
    if (observation.sigma(seen) != sigma || observation.is_border_row(seen)) return std::nan("");
    num_points += seen.point < observation.num_points() ? 1.0 / 3.0 : 1.0;
  }
  return sigma * std::sqrt(2.0 / num_points);
}

}  // namespace clothid
