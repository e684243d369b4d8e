#include "identify/wind/wind_request.h"

#include <algorithm>
#include <optional>
#include <string_view>

#include "sim/base/error.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

constexpr std::string_view kAxes = "xyz";

[[noreturn]] void Refuse(const std::string& text) {
  throw Error(ErrorKind::kUsage, "--wind_profile: expected KNOTS or KNOTS:AXES, as in 8 or 8:xy, with 2 to " +
                                     std::to_string(kMaxFittedKnots) + " knots, got '" + Printable(text) + "'");
}

void SetProfile(const WindRequest& request, RecordedMotion* motion) {
  Scene& scene = motion->scene;
  Wind wind = scene.nominal_parameters().wind;
  WindProfile profile;
  profile.times =
      Eigen::VectorXd::LinSpaced(request.num_knots, motion->times[0], motion->times[motion->num_frames() - 1]);
  profile.velocities.resize(3, request.num_knots);
  for (int knot = 0; knot < request.num_knots; ++knot) {
    profile.velocities.col(knot) = wind.profile.At(profile.times[knot]);
  }
  for (int axis = 0; axis < 3; ++axis) {
    for (auto range = scene.parameters.begin(); range != scene.parameters.end();) {
      const std::optional<ParameterId> id = FindParameter(range->first);
      const bool is_of_axis = id && id->kind == ParameterKind::kWind && id->axis == axis;
      range = is_of_axis && (IsWindKnot(*id) || request.axes[axis]) ? scene.parameters.erase(range) : std::next(range);
    }
    if (!request.axes[axis]) continue;
    profile.velocities.row(axis).array() += wind.mean[axis];
    wind.mean[axis] = 0.0;
  }
  wind.profile = profile;
  scene.wind = wind;
}

}  // namespace

WindRequest ParseWindRequest(const std::string& text) {
  WindRequest request;
  if (text.empty()) return request;
  const std::vector<std::string> parts = Split(text, ':');
  const std::optional<long long> count = ParseInteger(Trimmed(parts.front()));
  if (!count || *count < 2 || *count > kMaxFittedKnots || parts.size() > 2) Refuse(text);
  request.num_knots = static_cast<int>(*count);
  if (parts.size() == 1) return request;
  const std::string axes(Trimmed(parts.back()));
  request.axes = {};
  for (const char axis : axes) {
    const std::size_t index = kAxes.find(axis);
    if (index == std::string_view::npos || request.axes[index]) Refuse(text);
    request.axes[index] = true;
  }
  if (axes.empty()) Refuse(text);
  return request;
}

void SetWindProfile(const WindRequest& request, std::vector<RecordedMotion>* motions) {
  for (RecordedMotion& motion : *motions) {
    if (motion.num_frames() < 2) {
      throw Error(ErrorKind::kUsage, "--wind_profile: " + motion.name + " has a single frame; expected at least 2");
    }
    SetProfile(request, &motion);
  }
}

void AddKnots(const WindRequest& request, FitOptions* options) {
  for (int axis = 0; axis < 3; ++axis) {
    if (!request.axes[axis]) continue;
    const std::string name = ParameterName({ParameterKind::kWind, axis}, {});
    for (const std::vector<std::string>* names : {&options->parameters, &options->each}) {
      if (std::find(names->begin(), names->end(), name) == names->end()) continue;
      throw Error(ErrorKind::kUsage, "--wind_profile: its knots take the place of '" + name +
                                         "'; expected it not to be " + "fitted beside them");
    }
    for (int knot = 0; knot < request.num_knots; ++knot) {
      options->each.push_back(ParameterName({ParameterKind::kWind, axis, knot}, {}));
    }
  }
}

}  // namespace clothid
