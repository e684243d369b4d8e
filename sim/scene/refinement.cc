#include "sim/scene/refinement.h"

#include <algorithm>

#include "sim/base/error.h"

namespace clothid {
namespace {

std::array<int, 2> Edge(int a, int b) { return {std::min(a, b), std::max(a, b)}; }

std::vector<std::array<int, 2>> EdgesOf(const Mesh& mesh) {
  std::vector<std::array<int, 2>> edges;
  edges.reserve(3 * static_cast<std::size_t>(mesh.num_faces()));
  for (int f = 0; f < mesh.num_faces(); ++f) {
    for (int k = 0; k < 3; ++k) edges.push_back(Edge(mesh.faces(k, f), mesh.faces((k + 1) % 3, f)));
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

Handles RefineHandles(const Handles& handles, const RefinedMesh& refined) {
  std::vector<int> place(static_cast<std::size_t>(refined.num_coarse_nodes()), -1);
  for (std::size_t i = 0; i < handles.nodes.size(); ++i) place[handles.nodes[i]] = static_cast<int>(i);
  Handles result;
  result.nodes = handles.nodes;
  std::vector<std::array<int, 2>> held;  // the handles on both sides of the new ones
  for (std::size_t e = 0; e < refined.edges.size(); ++e) {
    const auto [a, b] = refined.edges[e];
    if (place[a] < 0 || place[b] < 0) continue;
    result.nodes.push_back(refined.num_coarse_nodes() + static_cast<int>(e));
    held.push_back({place[a], place[b]});
  }
  const HandlePath& path = handles.path;
  if (path.times().size() == 0) return result;
  Eigen::MatrixXd positions(3 * static_cast<Eigen::Index>(result.nodes.size()), path.times().size());
  Eigen::Index row = path.positions().rows();
  positions.topRows(row) = path.positions();
  for (const auto& [a, b] : held) {
    positions.middleRows<3>(row) =
        0.5 * (path.positions().middleRows<3>(3 * a) + path.positions().middleRows<3>(3 * b));
    row += 3;
  }
  result.path = HandlePath(path.times(), positions);
  return result;
}

// Of every clamped edge both halves, with its slope.
void RefineClamps(const Handles& handles, const RefinedMesh& refined, Handles* result) {
  if (handles.clamped.empty()) return;
  const Eigen::MatrixXd& coarse = handles.slopes.positions();
  Eigen::MatrixXd slopes(2 * coarse.rows(), coarse.cols());
  for (std::size_t i = 0; i < handles.clamped.size(); ++i) {
    const ClampedEdge& edge = handles.clamped[i];
    const int middle = refined.Midpoint(edge.nodes[0], edge.nodes[1]);
    for (int half = 0; half < 2; ++half) {
      // The triangle at a corner is the one that still has it.
      int face = 4 * edge.face;
      while ((refined.mesh.faces.col(face).array() != edge.nodes[static_cast<std::size_t>(half)]).all()) ++face;
      result->clamped.push_back(
          {half == 0 ? std::array<int, 2>{edge.nodes[0], middle} : std::array<int, 2>{middle, edge.nodes[1]}, face});
      slopes.middleRows<3>(6 * static_cast<Eigen::Index>(i) + 3 * half) =
          coarse.middleRows<3>(3 * static_cast<Eigen::Index>(i));
    }
  }
  result->slopes = HandlePath(handles.slopes.times(), slopes);
}

// The corners of the four triangles that follow in the place of one, as sums of two corners of it: the four of
// RefineMesh, in their order.
constexpr int kParts[4][3][2] = {
    {{0, 0}, {0, 1}, {2, 0}}, {{0, 1}, {1, 1}, {1, 2}}, {{2, 0}, {1, 2}, {2, 2}}, {{0, 1}, {1, 2}, {2, 0}}};

Eigen::Matrix2Xd RefineCornerRest(const Eigen::Matrix2Xd& places) {
  Eigen::Matrix2Xd result(2, 4 * places.cols());
  Eigen::Index column = 0;
  for (Eigen::Index f = 0; f < places.cols(); f += 3) {
    for (const auto& part : kParts) {
      for (const auto& [i, k] : part) result.col(column++) = 0.5 * (places.col(f + i) + places.col(f + k));
    }
  }
  return result;
}

// [3 x F], or none: every triangle lends its own to the four that follow in its place.
Eigen::Matrix3Xd RefineDirections(const Eigen::Matrix3Xd& directions) {
  Eigen::Matrix3Xd result(3, 4 * directions.cols());
  for (Eigen::Index f = 0; f < directions.cols(); ++f) result.middleCols<4>(4 * f).colwise() = directions.col(f);
  return result;
}

}  // namespace

int RefinedMesh::Midpoint(int a, int b) const {
  const auto edge = std::lower_bound(edges.begin(), edges.end(), Edge(a, b));
  if (edge == edges.end() || *edge != Edge(a, b)) return -1;
  return num_coarse_nodes() + static_cast<int>(edge - edges.begin());
}

Eigen::MatrixXd RefinedMesh::Interpolate(const Eigen::MatrixXd& values) const {
  Eigen::MatrixXd result(3 * static_cast<Eigen::Index>(mesh.num_nodes()), values.cols());
  result.topRows(values.rows()) = values;
  Eigen::Index row = values.rows();
  for (const auto& [a, b] : edges) {
    result.middleRows<3>(row) = 0.5 * (values.middleRows<3>(3 * a) + values.middleRows<3>(3 * b));
    row += 3;
  }
  return result;
}

RefinedMesh RefineMesh(const Mesh& mesh) {
  RefinedMesh refined;
  refined.edges = EdgesOf(mesh);
  const auto num_edges = static_cast<Eigen::Index>(refined.edges.size());
  refined.mesh.rest_positions.resize(3, mesh.num_nodes() + num_edges);
  refined.mesh.rest_positions = refined.Interpolate(mesh.rest_positions.reshaped()).reshaped(3, Eigen::AutoSize);
  refined.mesh.faces.resize(3, 4 * static_cast<Eigen::Index>(mesh.num_faces()));
  for (int f = 0; f < mesh.num_faces(); ++f) {
    const int a = mesh.faces(0, f), b = mesh.faces(1, f), c = mesh.faces(2, f);
    const int ab = refined.Midpoint(a, b), bc = refined.Midpoint(b, c), ca = refined.Midpoint(c, a);
    refined.mesh.faces.middleCols<4>(4 * static_cast<Eigen::Index>(f)) <<  //
        a,
        ab, ca, ab,     //
        ab, b, bc, bc,  //
        ca, bc, c, ca;
  }
  refined.mesh.piece_names = mesh.piece_names;
  for (const int piece : mesh.face_pieces) refined.mesh.face_pieces.insert(refined.mesh.face_pieces.end(), 4, piece);
  refined.mesh.corner_rest = RefineCornerRest(mesh.corner_rest);
  for (const auto& [low, high] : mesh.folds) {
    const int middle = refined.Midpoint(low, high);
    refined.mesh.folds.push_back({low, middle});
    refined.mesh.folds.push_back({high, middle});
  }
  return refined;
}

Scene RefineScene(const Scene& scene, const RefinedMesh& refined) {
  Scene result = scene;
  result.mesh = refined.mesh;
  result.initial_positions = refined.Interpolate(scene.initial_positions);
  result.initial_velocities = refined.Interpolate(scene.initial_velocities);
  result.handles = RefineHandles(scene.handles, refined);
  RefineClamps(scene.handles, refined, &result.handles);
  result.warp.directions = RefineDirections(scene.warp.directions);
  return result;
}

void ExpectRefinable(const Scene& scene, const std::string& source) {
  if (!scene.node_force.isZero(0.0)) {
    throw Error(ErrorKind::kUsage,
                source + ": key 'node_force': expected none; on a finer mesh it would be another force");
  }
  if (!scene.mesh.links.empty()) {
    throw Error(
        ErrorKind::kUsage,
        source + ": key 'mesh': expected no seams that close and no buttons; they are drawn at their nodes alone");
  }
  // A mesh has at most three edges per triangle.
  if (scene.mesh.num_nodes() + 3LL * scene.mesh.num_faces() > kMaxNodes) {
    throw Error(ErrorKind::kUsage, source + ": the mesh is too large to be refined: expected at most " +
                                       std::to_string(kMaxNodes) + " nodes and edges");
  }
}

}  // namespace clothid
