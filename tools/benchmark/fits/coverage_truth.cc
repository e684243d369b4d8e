#include "tools/benchmark/fits/coverage_truth.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <nlohmann/json.hpp>

#include "sim/air/wind.h"
#include "sim/base/error.h"
#include "sim/scene/material_field.h"
#include "sim/scene/parameters.h"

namespace clothid {
namespace {

constexpr char kAxisNames[] = "xyz";

const GridField* FindField(ParameterKind kind, const Scene& scene) {
  const auto found = std::find_if(scene.fields.begin(), scene.fields.end(),
                                  [kind](const GridField& field) { return field.kind == kind; });
  return found == scene.fields.end() ? nullptr : &*found;
}

void AddKnotsOf(const WindRequest& request, const Scene& scene, const Eigen::VectorXd& times,
                std::vector<TrueParameter>* unknowns) {
  const Eigen::VectorXd knots = Eigen::VectorXd::LinSpaced(request.num_knots, times[0], times[times.size() - 1]);
  for (int axis = 0; axis < 3; ++axis) {
    if (!request.axes[axis]) continue;
    for (int k = 0; k < request.num_knots; ++k) {
      const std::string name = std::string("wind.") + kAxisNames[axis] + "." + std::to_string(k + 1);
      unknowns->push_back({name, scene.wind.mean[axis] + scene.wind.profile.At(knots[k])[axis], false});
    }
  }
}

// At place `index` of `count` on a line from 0 to 1.
double PlaceOf(int index, int count) { return count > 1 ? static_cast<double>(index) / (count - 1) : 0.5; }

void AddNodesOf(const FieldRequest& request, const std::vector<TrueParameter>& truth, const Scene& scene,
                std::vector<TrueParameter>* unknowns) {
  const GridField& field = *FindField(request.kind, scene);
  double level = 0.0, scale = 1.0;
  FieldOverTriangles(field, scene.mesh, &level);
  for (const TrueParameter& parameter : truth) {
    if (parameter.name == request.name) scale = parameter.value / level;
  }
  const Eigen::MatrixXd logs = field.values.array().log();
  for (int r = 0; r < request.rows; ++r) {
    for (int c = 0; c < request.columns; ++c) {
      const Eigen::Vector2d place(PlaceOf(c, request.columns), PlaceOf(r, request.rows));
      const std::string name = request.name + "." + std::to_string(r + 1) + "." + std::to_string(c + 1);
      unknowns->push_back({name, scale * std::exp(BetweenControlNodes(logs, place)), false});
    }
  }
}

}  // namespace

void ExpectTruth(const HiddenUnknowns& unknowns, const Scene& scene) {
  for (const FieldRequest& request : unknowns.fields) {
    ExpectUsage(FindField(request.kind, scene) != nullptr,
                "--field: expected a scene that has '" + request.name + "' as a field, which is the truth");
  }
  ExpectUsage(!unknowns.wind.is_given() || scene.wind.profile.num_knots() > 0,
              "--wind_profile: expected a scene whose wind has a profile, which is the truth");
}

std::string WithoutTruth(const HiddenUnknowns& unknowns, const std::string& scene_text) {
  if (!unknowns.any()) return scene_text;
  nlohmann::ordered_json scene = nlohmann::ordered_json::parse(scene_text);
  for (const FieldRequest& request : unknowns.fields) scene["fields"].erase(request.name);
  if (!unknowns.wind.is_given()) return scene.dump();
  for (nlohmann::ordered_json& velocity : scene["wind"]["profile"]["velocities"]) {
    for (int axis = 0; axis < 3; ++axis) {
      if (unknowns.wind.axes[axis]) velocity[axis] = 0.0;
    }
  }
  return scene.dump();
}

std::vector<TrueParameter> TrueUnknowns(const HiddenUnknowns& unknowns, const std::vector<TrueParameter>& truth,
                                        const Scene& scene, const Eigen::VectorXd& times) {
  std::vector<TrueParameter> all;
  if (unknowns.wind.is_given()) AddKnotsOf(unknowns.wind, scene, times, &all);
  for (const FieldRequest& request : unknowns.fields) AddNodesOf(request, truth, scene, &all);
  return all;
}

std::string UnknownsOf(const std::string& name) {
  std::string group = name;
  while (true) {
    const std::size_t dot = group.rfind('.');
    const bool is_number = dot != std::string::npos && dot + 1 < group.size() &&
                           std::all_of(group.begin() + static_cast<std::ptrdiff_t>(dot) + 1, group.end(),
                                       [](unsigned char c) { return std::isdigit(c) != 0; });
    if (!is_number) break;
    group.resize(dot);
  }
  return group == name ? name : group + ".*";
}

}  // namespace clothid
