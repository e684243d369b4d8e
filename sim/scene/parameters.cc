#include "sim/scene/parameters.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <optional>
#include <string_view>

#include "sim/base/error.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

struct MaterialName {
  const char* name;
  ParameterKind kind;
};

constexpr MaterialName kMaterialNames[] = {{"k_stretch", ParameterKind::kStretchStiffness},
                                           {"k_bend", ParameterKind::kBendingStiffness},
                                           {"density", ParameterKind::kDensity},
                                           {"drag", ParameterKind::kDrag},
                                           {"damping", ParameterKind::kDamping}};

constexpr std::string_view kFrictionPrefix = "mu.";

// Of all kinds but kFriction.
double Material::*MaterialField(ParameterKind kind) {
  switch (kind) {
    case ParameterKind::kStretchStiffness:
      return &Material::stretch_stiffness;
    case ParameterKind::kBendingStiffness:
      return &Material::bending_stiffness;
    case ParameterKind::kDensity:
      return &Material::density;
    case ParameterKind::kDrag:
      return &Material::drag;
    case ParameterKind::kDamping:
      return &Material::damping;
    case ParameterKind::kFriction:
      break;
  }
  return nullptr;
}

std::string KnownNames(const std::vector<std::string>& obstacle_names) {
  std::string names;
  for (const MaterialName& material : kMaterialNames) names += std::string(material.name) + ", ";
  names += "mu";
  for (const std::string& obstacle : obstacle_names) names.append(", ").append(kFrictionPrefix).append(obstacle);
  return names;
}

}  // namespace

ParameterId ParseParameter(const std::string& name, const std::vector<std::string>& obstacle_names) {
  for (const MaterialName& material : kMaterialNames) {
    if (name == material.name) return {material.kind, kAllObstacles};
  }
  if (name == "mu") return {ParameterKind::kFriction, kAllObstacles};
  if (name.compare(0, kFrictionPrefix.size(), kFrictionPrefix) == 0) {
    const auto found = std::find(obstacle_names.begin(), obstacle_names.end(), name.substr(kFrictionPrefix.size()));
    if (found != obstacle_names.end()) {
      return {ParameterKind::kFriction, static_cast<int>(found - obstacle_names.begin())};
    }
  }
  throw Error(ErrorKind::kUsage, "unknown parameter '" + name + "'; expected one of " + KnownNames(obstacle_names));
}

std::string ParameterName(ParameterId id, const std::vector<std::string>& obstacle_names) {
  for (const MaterialName& material : kMaterialNames) {
    if (id.kind == material.kind) return material.name;
  }
  if (id.obstacle == kAllObstacles) return "mu";
  return std::string(kFrictionPrefix) + obstacle_names.at(static_cast<std::size_t>(id.obstacle));
}

std::map<std::string, double> ParseParameterValues(const std::string& text, const std::string& flag) {
  std::map<std::string, double> values;
  if (text.empty()) return values;
  for (const std::string& item : Split(text, ',')) {
    const std::size_t equals = item.find('=');
    const std::optional<double> value =
        equals == std::string::npos ? std::nullopt : ParseNumber(Trimmed(std::string_view(item).substr(equals + 1)));
    const std::string name(Trimmed(std::string_view(item).substr(0, equals)));
    if (name.empty() || !value) {
      throw Error(ErrorKind::kUsage, flag + ": expected NAME=NUMBER, a finite one, got '" + Printable(item) + "'");
    }
    if (!values.emplace(name, *value).second) {
      throw Error(ErrorKind::kUsage, flag + ": '" + Printable(name) + "' is given twice");
    }
  }
  return values;
}

double GetParameter(const Parameters& parameters, ParameterId id) {
  if (id.kind != ParameterKind::kFriction) return parameters.material.*MaterialField(id.kind);
  const std::vector<double>& mu = parameters.friction_coefficients;
  if (mu.empty()) return std::numeric_limits<double>::quiet_NaN();
  return id.obstacle == kAllObstacles ? mu.front() : mu.at(static_cast<std::size_t>(id.obstacle));
}

void SetParameter(ParameterId id, double value, Parameters* parameters) {
  std::vector<double>& mu = parameters->friction_coefficients;
  if (id.kind != ParameterKind::kFriction) {
    parameters->material.*MaterialField(id.kind) = value;
  } else if (id.obstacle == kAllObstacles) {
    std::fill(mu.begin(), mu.end(), value);
  } else {
    mu.at(static_cast<std::size_t>(id.obstacle)) = value;
  }
}

}  // namespace clothid
