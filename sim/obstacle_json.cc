#include "sim/obstacle_json.h"

#include <algorithm>
#include <memory>
#include <set>
#include <string>
#include <utility>

#include "sim/error.h"
#include "sim/obstacle.h"
#include "sim/text_file.h"

namespace clothid {
namespace {

// Names stand in flags ("mu.NAME"), so they must not hold what separates flags.
void CheckName(const JsonNode& name, std::set<std::string>* names) {
  const auto is_allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  };
  const std::string& text = name.String();
  if (text.empty() || !std::all_of(text.begin(), text.end(), is_allowed)) {
    name.Fail("expected a name of letters, digits, '_' and '-'");
  }
  if (!names->insert(text).second) name.Fail("expected a name that no other obstacle has");
}

std::string UniqueName(const std::string& type, std::set<std::string>* names) {
  std::string name = type;
  for (int i = 2; !names->insert(name).second; ++i) name = type + std::to_string(i);
  return name;
}

Eigen::Vector3d RequireVector(const JsonNode& node, const char* key) {
  return node.Require(key, "an array of three numbers").Vector3();
}

double RequireRadius(const JsonNode& node) { return node.Require("radius", "a number > 0 (m)").PositiveNumber(); }

// A constructor that refuses its arguments knows no key: `node` gives it.
template <typename Shape, typename... Arguments>
std::shared_ptr<const Obstacle> MakeShape(const JsonNode& node, const Arguments&... arguments) {
  std::string problem;
  try {
    return std::make_shared<Shape>(arguments...);
  } catch (const Error& error) {
    problem = error.what();
  }
  node.Fail(problem);
}

std::shared_ptr<const Obstacle> ReadShape(const JsonNode& node) {
  const std::string types = "\"plane\", \"sphere\" or \"capsule\"";
  const JsonNode type = node.Require("type", types);
  if (type.String() == "plane") {
    node.ExpectKeys({"name", "type", "point", "normal", "mu", "contact_distance"});
    return MakeShape<Plane>(node, RequireVector(node, "point"), RequireVector(node, "normal"));
  }
  if (type.String() == "sphere") {
    node.ExpectKeys({"name", "type", "center", "radius", "mu", "contact_distance"});
    return MakeShape<Sphere>(node, RequireVector(node, "center"), RequireRadius(node));
  }
  if (type.String() == "capsule") {
    node.ExpectKeys({"name", "type", "from", "to", "radius", "mu", "contact_distance"});
    return MakeShape<Capsule>(node, RequireVector(node, "from"), RequireVector(node, "to"), RequireRadius(node));
  }
  type.Fail("obstacles of type '" + Printable(type.String()) + "' are not supported; expected " + types);
}

}  // namespace

std::vector<SceneObstacle> ReadObstacles(const JsonNode& list) {
  std::set<std::string> names;
  for (const JsonNode& node : list.items()) {
    if (const auto name = node.Find("name")) CheckName(*name, &names);
  }
  std::vector<SceneObstacle> obstacles;
  for (const JsonNode& node : list.items()) {
    SceneObstacle obstacle;
    obstacle.shape = ReadShape(node);
    if (const auto mu = node.Find("mu")) obstacle.friction_coefficient = mu->NonNegativeNumber();
    if (const auto distance = node.Find("contact_distance")) obstacle.contact_distance = distance->NonNegativeNumber();
    const auto name = node.Find("name");
    obstacle.name = name ? name->String() : UniqueName(node.Find("type")->String(), &names);
    obstacles.push_back(std::move(obstacle));
  }
  return obstacles;
}

}  // namespace clothid
