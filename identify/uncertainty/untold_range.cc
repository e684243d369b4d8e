#include "identify/uncertainty/untold_range.h"

#include <algorithm>
#include <cmath>

#include "identify/uncertainty/uncertainty.h"

namespace clothid {
namespace {

double UntoldCoordinate(const UntoldParameter& parameter, double value) {
  return parameter.scale == ParameterScale::kLog ? std::log(value) : value;
}

// The belief before anything was measured, without what is excluded.
UntoldRange BelievedRange(const UntoldParameter& parameter) {
  const double lower = UntoldCoordinate(parameter, parameter.lower_bound);
  const double upper = UntoldCoordinate(parameter, parameter.upper_bound);
  const double middle = 0.5 * (lower + upper);
  const double half = 0.5 * BelievedRangeOf(upper - lower, parameter.scale);
  UntoldRange range = {middle - half, middle + half, middle};
  if (!std::isnan(parameter.lower95)) range.lower = std::max(lower, UntoldCoordinate(parameter, parameter.lower95));
  if (!std::isnan(parameter.upper95)) range.upper = std::min(upper, UntoldCoordinate(parameter, parameter.upper95));
  range.lower = std::min(range.lower, range.upper);
  return range;
}

}  // namespace

double UntoldRange::At(double normal) const {
  if (std::isinf(deviation)) return lower + (upper - lower) * 0.5 * std::erfc(-normal / std::sqrt(2.0));
  const double inward = center < 0.5 * (lower + upper) ? 1.0 : -1.0;
  return std::clamp(center + inward * deviation * std::abs(normal), lower, upper);
}

std::optional<UntoldRange> RangeOf(const UntoldParameter& parameter) {
  if (!std::isfinite(parameter.lower_bound) || !std::isfinite(parameter.upper_bound)) return std::nullopt;
  const double noise = std::max(1.0, parameter.residual_scale);
  if (!(parameter.visible_change > kVisibleChange * noise)) {
    return parameter.hidden_alone ? std::optional<UntoldRange>(BelievedRange(parameter)) : std::nullopt;
  }
  if (!parameter.at_bound) return std::nullopt;
  UntoldRange range;
  range.lower = UntoldCoordinate(parameter, parameter.lower_bound);
  range.upper = UntoldCoordinate(parameter, parameter.upper_bound);
  const double q = UntoldCoordinate(parameter, parameter.value);
  range.center = q - range.lower < range.upper - q ? range.lower : range.upper;
  range.deviation = noise * (range.upper - range.lower) / parameter.visible_change;
  return range;
}

bool IsHiddenAlone(const std::vector<Eigen::VectorXd>& directions, Eigen::Index index) {
  constexpr double kTakesPart = 0.1;
  return std::any_of(directions.begin(), directions.end(), [&](const Eigen::VectorXd& direction) {
    Eigen::ArrayXd others = direction.array().abs();
    if (others[index] < 1.0) return false;
    others[index] = 0.0;
    return others.maxCoeff() < kTakesPart;
  });
}

}  // namespace clothid
