#include "sim/scene/shape_json.h"

#include <cstddef>
#include <iterator>
#include <vector>

#include "sim/base/error.h"
#include "sim/base/text_file.h"
#include "sim/mesh/mesh.h"
#include "sim/mesh/obj_file.h"
#include "sim/obstacle/triangulated_surface.h"

namespace clothid {
namespace {

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

std::shared_ptr<const Obstacle> ReadPlane(const JsonNode& node, const std::string&) {
  return MakeShape<Plane>(node, "", RequireVector(node, "point"), RequireVector(node, "normal"));
}

std::shared_ptr<const Obstacle> ReadSphere(const JsonNode& node, const std::string&) {
  return MakeShape<Sphere>(node, "", RequireVector(node, "center"), RequireRadius(node));
}

std::shared_ptr<const Obstacle> ReadCapsule(const JsonNode& node, const std::string&) {
  return MakeShape<Capsule>(node, "", RequireVector(node, "from"), RequireVector(node, "to"), RequireRadius(node));
}

std::shared_ptr<const Obstacle> ReadSurface(const JsonNode& node, const std::string& folder) {
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

struct ShapeType {
  const char* name;
  std::vector<const char*> keys;
  std::shared_ptr<const Obstacle> (*read)(const JsonNode& node, const std::string& folder);
};

// What every obstacle may have beside the keys of its type.
constexpr const char* kCommonKeys[] = {"name", "type", "mu", "contact_distance"};

const std::vector<ShapeType>& ShapeTypes() {
  static const std::vector<ShapeType> types = {
      {"plane", {"point", "normal"}, ReadPlane},
      {"sphere", {"center", "radius"}, ReadSphere},
      {"capsule", {"from", "to", "radius"}, ReadCapsule},
      {"mesh", {"obj", "vertices", "faces"}, ReadSurface},
  };
  return types;
}

// "\"plane\", \"sphere\" or \"mesh\"".
std::string TypeNames() {
  const std::vector<ShapeType>& types = ShapeTypes();
  std::string names;
  for (std::size_t i = 0; i < types.size(); ++i) {
    names += i == 0 ? "" : i + 1 < types.size() ? ", " : " or ";
    names += std::string("\"") + types[i].name + "\"";
  }
  return names;
}

}  // namespace

std::shared_ptr<const Obstacle> ReadShape(const JsonNode& node, const std::string& folder) {
  const JsonNode name = node.Require("type", TypeNames());
  for (const ShapeType& type : ShapeTypes()) {
    if (name.String() != type.name) continue;
    std::vector<const char*> keys = type.keys;
    keys.insert(keys.end(), std::begin(kCommonKeys), std::end(kCommonKeys));
    node.ExpectKeys(keys);
    return type.read(node, folder);
  }
  name.Fail("obstacles of type '" + Printable(name.String()) + "' are not supported; expected " + TypeNames());
}

}  // namespace clothid
