#include "costs/prediction/rollout_cost_options.h"

#include <algorithm>
#include <cmath>

namespace clothid {
namespace {

// Forward differences do not step below this, in an internal coordinate of order one.
constexpr double kLeastDifferenceStep = 1e-6;

}  // namespace

CostStatistics& CostStatistics::operator+=(const CostStatistics& other) {
  rollouts += other.rollouts;
  sweeps += other.sweeps;
  counts += other.counts;
  rollout_seconds += other.rollout_seconds;
  derivative_seconds += other.derivative_seconds;
  return *this;
}

CostStatistics& CostStatistics::operator-=(const CostStatistics& other) {
  rollouts -= other.rollouts;
  sweeps -= other.sweeps;
  counts -= other.counts;
  rollout_seconds -= other.rollout_seconds;
  derivative_seconds -= other.derivative_seconds;
  return *this;
}

double ForwardDifferenceStep(const SolverOptions& solver) {
  return std::max(kLeastDifferenceStep, std::sqrt(solver.step_tolerance));
}

}  // namespace clothid
