#include "identify/landscape/landscape_sigma.h"

#include <cmath>

#include "datasets/observation/observation.h"

namespace clothid {
namespace {

bool IsSame(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

}  // namespace

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
