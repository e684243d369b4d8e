#include "sim/mesh/mesh_json.h"

#include <Eigen/Geometry>
#include <cstddef>
#include <sstream>
#include <utility>
#include <vector>

#include "sim/base/error.h"
#include "sim/base/npy_file.h"
#include "sim/base/text_file.h"
#include "sim/mesh/obj_file.h"
#include "sim/mesh/sewing.h"

namespace clothid {
namespace {

std::vector<JsonNode> Pair(const JsonNode& node, const std::string& expected) {
  if (!node.is(JsonValue::Kind::kArray) || node.items().size() != 2) node.Fail("expected " + expected);
  return node.items();
}

GridOptions ReadGrid(const JsonNode& grid) {
  GridOptions options;
  grid.ExpectKeys({"nodes", "size", "origin", "axes"});
  const auto nodes = Pair(grid.Require("nodes", "two integers >= 2"), "two integers >= 2");
  const auto size = Pair(grid.Require("size", "two numbers > 0 (m)"), "two numbers > 0 (m)");
  for (std::size_t k = 0; k < 2; ++k) {
    options.nodes[k] = nodes[k].Integer(2, kMaxNodes);
    options.size[k] = size[k].PositiveNumber();
  }
  if (options.nodes[0] > kMaxNodes / options.nodes[1]) {
    grid.Fail("expected at most " + std::to_string(kMaxNodes) + " nodes");
  }
  if (const auto origin = grid.Find("origin")) options.origin = origin->Vector3();
  const auto axes = grid.Find("axes");
  if (!axes) return options;
  const auto axis = Pair(*axes, "two directions");
  options.axes = {axis[0].Vector3(), axis[1].Vector3()};
  // Axes closer to parallel than this are a slip of the pen, not a sheared cloth.
  constexpr double kLeastSine = 1e-3;
  const double sine = options.axes[0].stableNormalized().cross(options.axes[1].stableNormalized()).norm();
  if (!(sine > kLeastSine)) axes->Fail("expected two directions that are not parallel");
  return options;
}

// The mesh that a recording brings; of `grid` it has to have the size.
Mesh RecordedGrid(const JsonNode& grid, const GridOptions& options, const Mesh& recorded) {
  const int num_nodes = options.nodes[0] * options.nodes[1];
  if (num_nodes != recorded.num_nodes()) {
    grid.Fail("expected the " + std::to_string(recorded.num_nodes()) + " nodes of the recording, found " +
              std::to_string(num_nodes));
  }
  return recorded;
}

Mesh ReadFile(const JsonNode& obj, const std::string& path, const Mesh* recorded, Eigen::Matrix3Xd* along_u,
              FaceGroups* groups) {
  Mesh mesh = along_u != nullptr ? ReadObjWithUv(path, along_u, groups) : ReadObjWithGroups(path, groups);
  ValidateObjMesh(mesh, path);
  if (recorded == nullptr) return mesh;
  if (mesh.num_faces() != recorded->num_faces() || mesh.faces != recorded->faces) {
    const std::string purpose = along_u != nullptr ? "whose warp is to follow u" : "whose pieces are to be groups";
    obj.Fail("expected the triangles of the recording, " + purpose + " in " + Printable(path));
  }
  return *recorded;
}

std::vector<int> ReadChain(const JsonNode& seam, const char* key) {
  std::vector<int> nodes;
  for (const JsonNode& item : seam.Require(key, "a list of nodes along the border").items()) {
    nodes.push_back(item.Integer(0, kMaxNodes - 1));
  }
  return nodes;
}

Seam ReadSeam(const JsonNode& node) {
  node.ExpectKeys({"a", "b", "fold", "closes", "stiffness", "ease"});
  Seam seam;
  seam.a = ReadChain(node, "a");
  seam.b = ReadChain(node, "b");
  if (const auto fold = node.Find("fold")) seam.is_fold = fold->Boolean();
  if (const auto ease = node.Find("ease")) seam.is_eased = ease->Boolean();
  const auto closes = node.Find("closes"), stiffness = node.Find("stiffness");
  seam.is_drawn = closes.has_value();
  if (closes) seam.closing_time = closes->NonNegativeNumber();
  if (stiffness) seam.stiffness = stiffness->PositiveNumber();
  const bool is_joined = !seam.is_drawn && seam.a.size() == seam.b.size();
  if (stiffness && is_joined) stiffness->Fail("expected \"closes\" beside it; a seam that joins has no stiffness");
  return seam;
}

// Errors of `sew` as those of the key.
template <typename Function>
void SewAt(const JsonNode& node, const Function& sew) {
  std::string problem;
  try {
    return sew();
  } catch (const Error& error) {
    problem = error.what();
  }
  node.Fail(problem);
}

// By the seams and buttons of the object `node`; they count the nodes of `mesh`.
void SewMesh(const JsonNode& node, const std::string& source, Mesh* mesh) {
  const auto seams = node.Find("seams"), buttons = node.Find("buttons");
  if (!seams && !buttons) return;
  Sewing sewing(mesh);
  for (const JsonNode& item : seams ? seams->items() : std::vector<JsonNode>()) {
    SewAt(item, [&] { sewing.Add(ReadSeam(item)); });
  }
  for (const JsonNode& item : buttons ? buttons->items() : std::vector<JsonNode>()) {
    const std::vector<JsonNode> nodes = Pair(item, "two nodes");
    SewAt(item, [&] { sewing.AddButton(nodes[0].Integer(0, kMaxNodes - 1), nodes[1].Integer(0, kMaxNodes - 1)); });
  }
  sewing.Finish();
  ValidateMesh(*mesh, source + ": sewn");
}

// A map that is this much larger or smaller than the surface has another unit: nobody starts with such a strain.
constexpr double kMostScale = 2.0;

void ExpectScale(const JsonNode& obj, const Mesh& mesh, double scale) {
  Mesh surface = mesh;
  surface.corner_rest.resize(2, 0);
  const double ratio = ClothSize(surface) / ClothSize(mesh);
  if (ratio <= kMostScale && ratio >= 1.0 / kMostScale) return;
  std::ostringstream text;
  text << "expected a UV map as large as the surface, which is " << ratio
       << " times its size; is \"uv_scale\": " << ratio * scale << " meant?";
  obj.Fail(text.str());
}

// Whether the UV map is the rest shape, and with how many m per unit.
bool RestIsUv(const JsonNode& node, double* scale) {
  const auto rest = node.Find("rest"), uv_scale = node.Find("uv_scale");
  if (uv_scale) *scale = uv_scale->PositiveNumber();
  if (!rest) {
    const auto ease = node.Find("ease");
    if (uv_scale || ease) (uv_scale ? uv_scale : ease)->Fail("expected \"rest\": \"uv\" beside it");
    return false;
  }
  if (!rest->is(JsonValue::Kind::kString) || rest->String() != "uv") rest->Fail("expected \"uv\"");
  if (!node.Find("obj")) rest->Fail("expected a mesh from an OBJ file beside it, whose UV map it is");
  return true;
}

// A mesh whose rest shape is its UV map. That of a recording brings it, or has to have the triangles of the file.
Mesh ReadGarment(const JsonNode& node, const JsonNode& obj, const std::string& path, double scale, const Mesh* recorded,
                 FaceGroups* groups) {
  if (recorded != nullptr && recorded->has_corner_rest() && groups == nullptr) return *recorded;
  Mesh mesh = ReadObjWithUvRest(path, scale, groups);
  ValidateObjMesh(mesh, path);
  const auto ease = node.Find("ease");
  if (!ease || !ease->Boolean()) ExpectEvenSeams(mesh, path);
  ExpectScale(obj, mesh, scale);
  SewMesh(node, path, &mesh);
  if (recorded == nullptr) return mesh;
  if (mesh.num_faces() != recorded->num_faces() || mesh.faces != recorded->faces) {
    obj.Fail("expected the triangles of the recording, whose rest shape is to be the UV map of " + Printable(path));
  }
  mesh.rest_positions = recorded->rest_positions;
  return mesh;
}

// `mesh`, and where it has no seams yet those of the object `node`.
Mesh WithSeams(Mesh mesh, const JsonNode& node, const std::string& source) {
  if (mesh.links.empty()) SewMesh(node, source, &mesh);
  return mesh;
}

}  // namespace

Mesh ReadMesh(const JsonNode& node, const std::string& folder, const Mesh* recorded, Eigen::Matrix3Xd* along_u,
              FaceGroups* groups) {
  node.ExpectKeys({"grid", "obj", "rest", "uv_scale", "ease", "seams", "buttons"});
  const auto grid = node.Find("grid"), obj = node.Find("obj");
  if (grid.has_value() == obj.has_value()) node.Fail(std::string("expected either ") + kMeshForms);
  double uv_scale = 1.0;
  const bool rest_is_uv = RestIsUv(node, &uv_scale);
  if (grid) {
    const GridOptions options = ReadGrid(*grid);
    return WithSeams(recorded == nullptr ? MakeGrid(options) : RecordedGrid(*grid, options, *recorded), node, "grid");
  }
  const std::string path = obj->Path(folder);
  if (rest_is_uv) return ReadGarment(node, *obj, path, uv_scale, recorded, groups);
  if (recorded != nullptr && along_u == nullptr && groups == nullptr) return WithSeams(*recorded, node, path);
  return WithSeams(ReadFile(*obj, path, recorded, along_u, groups), node, path);
}

Eigen::Matrix3Xd ReadNpyVectors(const JsonNode& node, const std::string& folder, int count) {
  const std::string path = node.Path(folder);
  const NpyArray array = ReadNpy(path);
  if (array.shape != std::vector<long long>{count, 3}) {
    node.Fail("expected " + path + " to hold an array of shape (" + std::to_string(count) + ", 3)");
  }
  const Eigen::Map<const Eigen::Matrix3Xd> vectors(array.values.data(), 3, count);
  if (!vectors.allFinite()) node.Fail("expected " + path + " to hold finite numbers");
  return vectors;
}

}  // namespace clothid
