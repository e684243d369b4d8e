#include "sim/scene/shape_json.h"

#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <vector>

#include "sim/base/error.h"
#include "sim/base/text_file.h"
#include "sim/mesh/mesh.h"
#include "sim/mesh/obj_file.h"
#include "sim/obstacle/box.h"
#include "sim/obstacle/round_shapes.h"
#include "sim/obstacle/triangulated_surface.h"

namespace clothid {
namespace {

Eigen::Vector3d RequireVector(const JsonNode& node, const char* key) {
  return node.Require(key, "an array of three numbers").Vector3();
}

double RequireLength(const JsonNode& node, const char* key) {
  return node.Require(key, "a number > 0 (m)").PositiveNumber();
}

std::vector<JsonNode> RequireItems(const JsonNode& node, std::size_t count, const char* expected) {
  if (!node.is(JsonValue::Kind::kArray) || node.items().size() != count) node.Fail(std::string("expected ") + expected);
  return node.items();
}

// A constructor that refuses its arguments knows no key: `node` gives it.
template <typename Make>
std::shared_ptr<const Obstacle> TryToMake(const JsonNode& node, const Make& make) {
  std::string problem;
  try {
    return make();
  } catch (const Error& error) {
    problem = error.what();
  }
  node.Fail(problem);
}

template <typename Shape, typename... Arguments>
std::shared_ptr<const Obstacle> MakeShape(const JsonNode& node, const Arguments&... arguments) {
  return TryToMake(node, [&] { return std::make_shared<Shape>(arguments...); });
}

// The errors of a surface name the face that is at fault: its line in the file `path`, or without one the item of
// `node`, the list of faces.
std::shared_ptr<const Obstacle> MakeSurface(const JsonNode& node, const std::string& path,
                                            const Eigen::Matrix3Xd& vertices, const Eigen::Matrix3Xi& faces) {
  std::string problem;
  MeshPart part;
  try {
    return std::make_shared<TriangulatedSurface>(vertices, faces);
  } catch (const MeshError& error) {
    problem = error.what();
    part = error.part();
  } catch (const Error& error) {
    problem = error.what();
  }
  if (!path.empty()) node.Fail(PlaceInObj(path, part) + ": " + problem);
  if (part.face >= 0) node.items()[part.face].Fail(problem);
  node.Fail(problem);
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
  return MakeShape<Plane>(node, RequireVector(node, "point"), RequireVector(node, "normal"));
}

std::shared_ptr<const Obstacle> ReadSphere(const JsonNode& node, const std::string&) {
  return MakeShape<Sphere>(node, RequireVector(node, "center"), RequireLength(node, "radius"));
}

std::shared_ptr<const Obstacle> ReadCapsule(const JsonNode& node, const std::string&) {
  return MakeShape<Capsule>(node, RequireVector(node, "from"), RequireVector(node, "to"),
                            RequireLength(node, "radius"));
}

std::shared_ptr<const Obstacle> ReadBox(const JsonNode& node, const std::string&) {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  if (const auto given = node.Find("rotation")) {
    const std::vector<JsonNode> numbers = RequireItems(*given, 4, "a quaternion, [x, y, z, w]");
    for (std::size_t k = 0; k < 4; ++k) rotation.coeffs()[static_cast<Eigen::Index>(k)] = numbers[k].Number();
  }
  const auto radius = node.Find("radius");
  return MakeShape<Box>(node, RequireVector(node, "center"), RequireVector(node, "size"), rotation,
                        radius ? radius->NonNegativeNumber() : 0.0);
}

// Its edges are as round as its thickness lets them be, unless it says otherwise.
std::shared_ptr<const Obstacle> ReadTable(const JsonNode& node, const std::string&) {
  const Eigen::Vector3d center = RequireVector(node, "center"), normal = RequireVector(node, "normal");
  const char* const expected = "two numbers > 0 (m)";
  const std::vector<JsonNode> lengths = RequireItems(node.Require("size", expected), 2, expected);
  const Eigen::Vector2d size(lengths[0].PositiveNumber(), lengths[1].PositiveNumber());
  const double thickness = RequireLength(node, "thickness");
  const auto along = node.Find("along"), radius = node.Find("radius");
  return TryToMake(node, [&] {
    return std::make_shared<Box>(Box::Table(center, normal, along ? along->Vector3() : Eigen::Vector3d::UnitX(), size,
                                            thickness, radius ? radius->NonNegativeNumber() : 0.5 * thickness));
  });
}

std::shared_ptr<const Obstacle> ReadCylinder(const JsonNode& node, const std::string&) {
  return MakeShape<Cylinder>(node, RequireVector(node, "from"), RequireVector(node, "to"),
                             RequireLength(node, "radius"));
}

std::shared_ptr<const Obstacle> ReadTorus(const JsonNode& node, const std::string&) {
  return MakeShape<Torus>(node, RequireVector(node, "center"), RequireVector(node, "axis"),
                          RequireLength(node, "radius"), RequireLength(node, "tube_radius"));
}

std::shared_ptr<const Obstacle> ReadBowl(const JsonNode& node, const std::string&) {
  const double degrees = node.Require("angle", "a number > 0 and < 180 (degrees)").PositiveNumber();
  return MakeShape<Bowl>(node, RequireVector(node, "center"), RequireVector(node, "axis"),
                         RequireLength(node, "radius"), degrees * (M_PI / 180.0), RequireLength(node, "thickness"));
}

std::shared_ptr<const Obstacle> ReadSurface(const JsonNode& node, const std::string& folder) {
  const auto obj = node.Find("obj");
  if (obj.has_value() == (node.Find("vertices") || node.Find("faces"))) {
    node.Fail("expected either \"obj\" or \"vertices\" and \"faces\"");
  }
  if (obj) {
    const std::string path = obj->Path(folder);
    const Mesh mesh = ReadObj(path);
    return MakeSurface(*obj, path, mesh.rest_positions, mesh.faces);
  }
  const Eigen::Matrix3Xd vertices = ReadVertices(node.Require("vertices", "a list of [x, y, z] (m)"));
  const JsonNode faces = node.Require("faces", "a list of [i, j, k]");
  return MakeSurface(faces, "", vertices, ReadFaces(faces, static_cast<int>(vertices.cols())));
}

struct ShapeType {
  const char* name;
  std::vector<const char*> keys;
  std::shared_ptr<const Obstacle> (*read)(const JsonNode& node, const std::string& folder);
};

// What every obstacle may have beside the keys of its type.
constexpr const char* kCommonKeys[] = {"name", "type", "mu", "contact_distance", "path"};

const std::vector<ShapeType>& ShapeTypes() {
  static const std::vector<ShapeType> types = {
      {"plane", {"point", "normal"}, ReadPlane},
      {"sphere", {"center", "radius"}, ReadSphere},
      {"capsule", {"from", "to", "radius"}, ReadCapsule},
      {"box", {"center", "size", "rotation", "radius"}, ReadBox},
      {"table", {"center", "normal", "along", "size", "thickness", "radius"}, ReadTable},
      {"cylinder", {"from", "to", "radius"}, ReadCylinder},
      {"torus", {"center", "axis", "radius", "tube_radius"}, ReadTorus},
      {"bowl", {"center", "axis", "radius", "angle", "thickness"}, ReadBowl},
      {"mesh", {"obj", "vertices", "faces", "sequence"}, ReadSurface},
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
