#include "datasets/curves/heavy_elastica.h"

#include <Eigen/Core>
#include <cmath>

namespace clothid {
namespace {

constexpr double kStepOfElastica = 2e-3;    // of v; steps of a fifth change c/L by less than 1e-7
constexpr double kSteepestTip = 1.5697963;  // rad, 89.94 degrees; the angle is then 83
constexpr int kBisections = 50;

// Slope, its derivative, x and z upwards, all over v.
Eigen::Vector4d ElasticaRates(double v, const Eigen::Vector4d& state) {
  return {state[1], -v * std::cos(state[0]), std::cos(state[0]), -std::sin(state[0])};
}

SaggingStrip SagOfTip(double tip_slope) {
  constexpr double h = kStepOfElastica;
  Eigen::Vector4d state(tip_slope, 0.0, 0.0, 0.0);
  for (double v = 0.0;; v += h) {
    const Eigen::Vector4d k1 = ElasticaRates(v, state), k2 = ElasticaRates(v + 0.5 * h, state + 0.5 * h * k1),
                          k3 = ElasticaRates(v + 0.5 * h, state + 0.5 * h * k2),
                          k4 = ElasticaRates(v + h, state + h * k3);
    const Eigen::Vector4d next = state + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    if (next[0] <= 0.0) {
      const double share = state[0] / (state[0] - next[0]), length = v + share * h;
      state += share * (next - state);
      return {1.0 / length, state[2] / length, state[3] / length};
    }
    state = next;
  }
}

// The strip whose slope at the tip is where `is_too_flat` ends.
template <typename Condition>
SaggingStrip FindSag(const Condition& is_too_flat) {
  double flat = 0.5 * kLeastSag, steep = kSteepestTip;
  for (int i = 0; i < kBisections; ++i) {
    const double middle = 0.5 * (flat + steep);
    (is_too_flat(SagOfTip(middle)) ? flat : steep) = middle;
  }
  return SagOfTip(0.5 * (flat + steep));
}

}  // namespace

SaggingStrip SagOfAngle(double angle) {
  return FindSag([&](const SaggingStrip& strip) { return std::atan2(-strip.tip_z, strip.tip_x) < angle; });
}

SaggingStrip SagOfBendingLength(double share) {
  return FindSag([&](const SaggingStrip& strip) { return strip.bending_length > share; });
}

}  // namespace clothid
