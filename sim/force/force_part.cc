#include "sim/force/force_part.h"

#include <cstddef>
#include <numeric>

#include "sim/scene/warp.h"

namespace clothid {
namespace {

// The triangles `part.faces` as a mesh of its own.
Mesh PartOfMesh(const Mesh& whole, const ForcePart& part) {
  Mesh mesh;
  mesh.rest_positions = whole.rest_positions(Eigen::all, part.nodes);
  mesh.faces = whole.faces(Eigen::all, part.faces);
  for (int& node : mesh.faces.reshaped()) node = part.index[node];
  if (!whole.has_corner_rest()) return mesh;
  mesh.corner_rest.resize(2, 3 * mesh.faces.cols());
  for (int f = 0; f < mesh.num_faces(); ++f) {
    mesh.corner_rest.middleCols<3>(3 * f) = whole.corner_rest.middleCols<3>(3 * part.faces[f]);
  }
  return mesh;
}

// Adds all pairs of `nodes`.
template <typename Nodes>
void Join(const Nodes& nodes, const ForcePart& part, std::vector<std::vector<int>>* neighbours) {
  for (const int node : nodes) {
    for (const int other : nodes) {
      if (node != other) (*neighbours)[part.index[node]].push_back(part.index[other]);
    }
  }
}

}  // namespace

ForcePart MakeForcePart(const Scene& scene, const std::vector<int>& chosen,
                        const std::vector<std::vector<int>>& coupled) {
  const Mesh& whole = scene.mesh;
  ForcePart part;
  part.is_chosen.assign(static_cast<std::size_t>(whole.num_nodes()), false);
  for (const int node : chosen) part.is_chosen[node] = true;
  std::vector<bool> is_near = part.is_chosen;
  for (int f = 0; f < whole.num_faces(); ++f) {
    const Eigen::Vector3i corners = whole.faces.col(f);
    if (!part.Touches(corners)) continue;
    part.faces.push_back(f);
    for (const int node : corners) is_near[node] = true;
  }
  for (const std::vector<int>& nodes : coupled) {
    for (const int node : nodes) is_near[node] = true;
  }
  part.index.assign(is_near.size(), -1);
  for (int node = 0; node < whole.num_nodes(); ++node) {
    if (!is_near[node]) continue;
    part.index[node] = static_cast<int>(part.nodes.size());
    part.nodes.push_back(node);
  }
  std::vector<std::vector<int>> neighbours(part.nodes.size());
  for (const int face : part.faces) Join(Eigen::Vector3i(whole.faces.col(face)), part, &neighbours);
  for (const std::vector<int>& nodes : coupled) Join(nodes, part, &neighbours);
  part.pattern = std::make_shared<const BlockPattern>(neighbours);
  part.blocks.resize(part.nodes.size());
  std::iota(part.blocks.begin(), part.blocks.end(), 0);
  Eigen::Matrix3Xd warp;
  const bool has_axes = scene.membrane != MembraneLaw::kArap;
  if (has_axes) warp = WarpDirections(scene.warp, whole)(Eigen::all, part.faces);
  part.triangles = std::make_shared<const TriangleElements>(
      MakeTriangleElements(PartOfMesh(whole, part), part.blocks, *part.pattern, has_axes ? &warp : nullptr));
  return part;
}

Eigen::SparseMatrix<double> PartOfMatrix(const Eigen::SparseMatrix<double>& matrix, const ForcePart& part) {
  std::vector<Eigen::Triplet<double>> entries;
  for (const int node : part.nodes) {
    for (Eigen::SparseMatrix<double>::InnerIterator it(matrix, node); it; ++it) {
      if (part.is_chosen[node] || part.is_chosen[it.row()]) {
        entries.emplace_back(part.index[it.row()], part.index[node], it.value());
      }
    }
  }
  const auto size = static_cast<Eigen::Index>(part.nodes.size());
  Eigen::SparseMatrix<double> rows(size, size);
  rows.setFromTriplets(entries.begin(), entries.end());
  return rows;
}

}  // namespace clothid
