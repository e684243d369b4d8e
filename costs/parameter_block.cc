#include "costs/parameter_block.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "sim/error.h"

namespace clothid {
namespace {

constexpr double kAtBound = 1e-3;
constexpr double kRelativeResolution = 1e-6;
constexpr double kLeastFriction = 0.01;

// The first of `given` and `from_scene` that is given.
double Choose(const std::map<std::string, double>& given, const std::string& name, double from_scene,
              double otherwise) {
  const auto it = given.find(name);
  if (it != given.end()) return it->second;
  return std::isnan(from_scene) ? otherwise : from_scene;
}

void CheckStart(const ParameterBlock& block) {
  if (!std::isfinite(block.start) || block.start < 0.0) {
    throw Error(ErrorKind::kUsage, "parameter '" + block.name + "': the starting value must be a finite number >= 0");
  }
  if (block.scale == ParameterScale::kLog && block.start == 0.0) {
    throw Error(ErrorKind::kUsage, "parameter '" + block.name +
                                       "': the starting value is 0, so the scene has no such term; give a positive "
                                       "nominal value in the scene or a positive start");
  }
}

void CheckBounds(const ParameterBlock& block) {
  const double least = block.scale == ParameterScale::kLog ? std::nextafter(0.0, 1.0) : 0.0;
  std::ostringstream bounds;
  bounds << "[" << block.lower_bound << ", " << block.upper_bound << "]";
  if (!(block.lower_bound >= least) || !(block.upper_bound > block.lower_bound) || !std::isfinite(block.upper_bound)) {
    throw Error(ErrorKind::kUsage,
                "parameter '" + block.name + "': bounds " + bounds.str() +
                    (least > 0.0 ? " must be positive and increasing" : " must be >= 0 and increasing"));
  }
  if (block.start < block.lower_bound || block.start > block.upper_bound) {
    std::ostringstream start;
    start << block.start;
    throw Error(ErrorKind::kUsage, "parameter '" + block.name + "': the starting value " + start.str() +
                                       " is outside its bounds " + bounds.str());
  }
}

}  // namespace

double ParameterBlock::ToCoordinate(double value) const {
  return scale == ParameterScale::kLog ? std::log(value) : value;
}

double ParameterBlock::ToValue(double coordinate) const {
  return scale == ParameterScale::kLog ? std::exp(coordinate) : coordinate;
}

double ParameterBlock::ValueDerivative(double coordinate) const {
  return scale == ParameterScale::kLog ? std::exp(coordinate) : 1.0;
}

double ParameterBlock::CoordinateRange() const { return ToCoordinate(upper_bound) - ToCoordinate(lower_bound); }

bool ParameterBlock::IsAtBound(double coordinate) const {
  const double distance = std::min(coordinate - ToCoordinate(lower_bound), ToCoordinate(upper_bound) - coordinate);
  return distance <= kAtBound * CoordinateRange();
}

double ParameterBlock::Resolution(double coordinate) const {
  return kRelativeResolution * (scale == ParameterScale::kLog ? 1.0 : std::max(std::abs(coordinate), kLeastFriction));
}

ParameterScale DefaultScale(ParameterKind kind) {
  return kind == ParameterKind::kFriction ? ParameterScale::kLinear : ParameterScale::kLog;
}

ParameterBlock MakeParameterBlock(const std::string& name, const Scene& scene, const ParameterOverrides& overrides) {
  const ParameterId id = ParseParameter(name, scene.obstacle_names());
  const auto range_it = scene.parameters.find(name);
  const ParameterRange range = range_it == scene.parameters.end() ? ParameterRange() : range_it->second;
  // The friction of all obstacles of a scene that has none: any start will do, nothing depends on it.
  const double nominal = GetParameter(scene.nominal_parameters(), id);

  ParameterBlock block;
  block.name = name;
  block.scale = DefaultScale(id.kind);
  block.frozen = range.frozen;
  block.start = Choose(overrides.start, name, range.nominal, std::isnan(nominal) ? 0.25 * kMaxFriction : nominal);
  CheckStart(block);
  const bool is_log = block.scale == ParameterScale::kLog;
  block.lower_bound =
      Choose(overrides.lower_bounds, name, range.lower_bound, is_log ? block.start / kBoundFactor : 0.0);
  block.upper_bound =
      Choose(overrides.upper_bounds, name, range.upper_bound, is_log ? block.start * kBoundFactor : kMaxFriction);
  CheckBounds(block);
  return block;
}

}  // namespace clothid
