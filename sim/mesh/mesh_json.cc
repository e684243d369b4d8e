#include "sim/mesh/mesh_json.h"

#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

#include "sim/base/npy_file.h"
#include "sim/base/text_file.h"

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
  ValidateMesh(mesh, path);
  if (recorded == nullptr) return mesh;
  if (mesh.num_faces() != recorded->num_faces() || mesh.faces != recorded->faces) {
    const std::string purpose = along_u != nullptr ? "whose warp is to follow u" : "whose pieces are to be groups";
    obj.Fail("expected the triangles of the recording, " + purpose + " in " + Printable(path));
  }
  return *recorded;
}

}  // namespace

Mesh ReadMesh(const JsonNode& node, const std::string& folder, const Mesh* recorded, Eigen::Matrix3Xd* along_u,
              FaceGroups* groups) {
  node.ExpectKeys({"grid", "obj"});
  const auto grid = node.Find("grid"), obj = node.Find("obj");
  if (grid.has_value() == obj.has_value()) node.Fail(std::string("expected either ") + kMeshForms);
  if (grid) {
    const GridOptions options = ReadGrid(*grid);
    return recorded == nullptr ? MakeGrid(options) : RecordedGrid(*grid, options, *recorded);
  }
  const std::string path = obj->Path(folder);
  if (recorded != nullptr && along_u == nullptr && groups == nullptr) return *recorded;
  return ReadFile(*obj, path, recorded, along_u, groups);
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
