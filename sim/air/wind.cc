#include "sim/air/wind.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "sim/base/error.h"

namespace clothid {

double WindProfile::Weight(int knot, double time) const {
  const Eigen::Index last = times.size() - 1;
  const double t = std::clamp(time, times[0], times[last]);
  const auto ramp = [&](Eigen::Index from) {
    return from < 0 || from > last ? 0.0 : (t - times[from]) / (times[knot] - times[from]);
  };
  if (t == times[knot]) return 1.0;
  return std::max(0.0, ramp(t < times[knot] ? knot - 1 : knot + 1));
}

Eigen::Vector3d WindProfile::At(double time) const {
  const Eigen::Index last = times.size() - 1;
  if (last < 0) return Eigen::Vector3d::Zero();
  if (!(time > times[0])) return velocities.col(0);
  if (time >= times[last]) return velocities.col(last);
  const Eigen::Index i = std::upper_bound(times.begin(), times.end(), time) - times.begin() - 1;
  const double share = (time - times[i]) / (times[i + 1] - times[i]);
  return velocities.col(i) + share * (velocities.col(i + 1) - velocities.col(i));
}

std::vector<RestPlace> RestPlaces(const Eigen::Matrix3Xd& positions, const Eigen::VectorXd& areas) {
  const Eigen::Vector3d center = positions * areas / areas.sum();
  std::vector<RestPlace> places;
  for (const auto& position : positions.colwise()) places.push_back({position, position - center});
  return places;
}

double Wind::GustAngle(double time, const RestPlace& place) const {
  return frequency * time + wave_vector.dot(place.position) + phase;
}

Eigen::Vector3d Wind::At(double time, const RestPlace& place) const {
  Eigen::Vector3d velocity = mean + gust * std::sin(GustAngle(time, place));
  if (profile.num_knots() > 0) velocity += profile.At(time);
  if (!shear.isZero(0.0)) velocity *= ShearFactor(place);
  return velocity;
}

void ValidateWind(const Wind& wind, const std::string& source) {
  const auto expect = [&](bool condition, const std::string& key, const std::string& expected) {
    if (!condition) throw Error(ErrorKind::kBadData, source + ": key 'wind." + key + "': expected " + expected);
  };
  expect(wind.mean.allFinite(), "mean", "finite numbers");
  expect(wind.gust.allFinite(), "gust", "finite numbers");
  expect(std::isfinite(wind.frequency), "frequency", "a finite number");
  expect(wind.wave_vector.allFinite(), "wave_vector", "finite numbers");
  expect(std::isfinite(wind.phase), "phase", "a finite number");
  expect(wind.shear.allFinite(), "shear", "finite numbers");
  const WindProfile& profile = wind.profile;
  expect(profile.num_knots() <= kMaxWindKnots, "profile.times", "at most " + std::to_string(kMaxWindKnots) + " times");
  expect(profile.times.allFinite() && std::is_sorted(profile.times.begin(), profile.times.end(), std::less_equal<>()),
         "profile.times", "finite numbers that increase");
  expect(profile.velocities.cols() == profile.times.size() && profile.velocities.allFinite(), "profile.velocities",
         "three finite numbers for each of the times");
}

}  // namespace clothid
