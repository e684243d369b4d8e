#include "sim/scene/obstacle_json.h"

#include <algorithm>
#include <memory>
#include <set>
#include <string>
#include <utility>

#include "sim/base/error.h"
#include "sim/base/text_file.h"
#include "sim/mesh/mesh.h"
#include "sim/mesh/obj_file.h"
#include "sim/obstacle/obstacle.h"
#include "sim/obstacle/triangulated_surface.h"

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

// A constructor that refuses its arguments knows no key: `node` gives it, and `source`, where it is not empty, a file.
template <typename Shape, typename... Arguments>
std::shared_ptr<const Obstacle> MakeShape(const JsonNode& node, const std::string& source,
                                          const Arguments&... arguments) {
  std::string problem;
  try {
    return std::make_shared<Shape>(arguments...);
  } catch (const Error& error) {
    problem = error.what();
  }
  node.Fail(source + problem);
}

Eigen::Matrix3Xd ReadVertices(const JsonNode& list) {
  const std::vector<JsonNode> items = list.items();
  Eigen::Matrix3Xd vertices(3, static_cast<Eigen::Index>(items.size()));
  for (std::size_t i = 0; i < items.size(); ++i) vertices.col(i) = items[i].Vector3();
  return vertices;
}

Eigen::Matrix3Xi ReadFaces(const JsonNode& list, int num_vertices) {
  const std::vector<JsonNode> items = list.items();
  Eigen::Matrix3Xi faces(3, static_cast<Eigen::Index>(items.size()));
  for (std::size_t i = 0; i < items.size(); ++i) {
    const std::vector<JsonNode> corners = items[i].items();
    if (corners.size() != 3) items[i].Fail("expected an array of three vertices");
    for (std::size_t k = 0; k < 3; ++k) faces(k, i) = corners[k].Integer(0, num_vertices - 1);
  }
  return faces;
}

std::shared_ptr<const Obstacle> ReadSurface(const JsonNode& node, const std::string& folder) {
  node.ExpectKeys({"name", "type", "obj", "vertices", "faces", "mu", "contact_distance"});
  const auto obj = node.Find("obj");
  if (obj.has_value() == (node.Find("vertices") || node.Find("faces"))) {
    node.Fail("expected either \"obj\" or \"vertices\" and \"faces\"");
  }
  if (obj) {
    const std::string path = obj->Path(folder);
    const Mesh mesh = ReadObj(path);
    return MakeShape<TriangulatedSurface>(*obj, path + ": ", mesh.rest_positions, mesh.faces);
  }
  const Eigen::Matrix3Xd vertices = ReadVertices(node.Require("vertices", "a list of [x, y, z] (m)"));
  const JsonNode faces = node.Require("faces", "a list of [i, j, k]");
  return MakeShape<TriangulatedSurface>(faces, "", vertices, ReadFaces(faces, static_cast<int>(vertices.cols())));
}

std::shared_ptr<const Obstacle> ReadShape(const JsonNode& node, const std::string& folder) {
  const std::string types = "\"plane\", \"sphere\", \"capsule\" or \"mesh\"";
  const JsonNode type = node.Require("type", types);
  if (type.String() == "plane") {
    node.ExpectKeys({"name", "type", "point", "normal", "mu", "contact_distance"});
    return MakeShape<Plane>(node, "", RequireVector(node, "point"), RequireVector(node, "normal"));
  }
  if (type.String() == "sphere") {
    node.ExpectKeys({"name", "type", "center", "radius", "mu", "contact_distance"});
    return MakeShape<Sphere>(node, "", RequireVector(node, "center"), RequireRadius(node));
  }
  if (type.String() == "capsule") {
    node.ExpectKeys({"name", "type", "from", "to", "radius", "mu", "contact_distance"});
    return MakeShape<Capsule>(node, "", RequireVector(node, "from"), RequireVector(node, "to"), RequireRadius(node));
  }
  if (type.String() == "mesh") return ReadSurface(node, folder);
  type.Fail("obstacles of type '" + Printable(type.String()) + "' are not supported; expected " + types);
}

}  // namespace

std::vector<SceneObstacle> ReadObstacles(const JsonNode& list, const std::string& folder) {
  if (list.items().size() > kMaxObstacles) {
    list.Fail("expected at most " + std::to_string(kMaxObstacles) + " obstacles");
  }
  std::set<std::string> names;
  for (const JsonNode& node : list.items()) {
    if (const auto name = node.Find("name")) CheckName(*name, &names);
  }
  std::vector<SceneObstacle> obstacles;
  for (const JsonNode& node : list.items()) {
    SceneObstacle obstacle;
    obstacle.shape = ReadShape(node, folder);
    if (const auto mu = node.Find("mu")) obstacle.friction_coefficient = mu->NonNegativeNumber();
    if (const auto distance = node.Find("contact_distance")) obstacle.contact_distance = distance->NonNegativeNumber();
    const auto name = node.Find("name");
    obstacle.name = name ? name->String() : UniqueName(node.Find("type")->String(), &names);
    obstacles.push_back(std::move(obstacle));
  }
  return obstacles;
}

}  // namespace clothid
