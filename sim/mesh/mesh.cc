#include "sim/mesh/mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <sstream>
#include <vector>

namespace clothid {
namespace {

[[noreturn]] void FailOnMesh(const std::string& source, const std::string& fault) {
  throw MeshError(source, fault, {});
}
[[noreturn]] void FailOnFace(const std::string& source, int face, const std::string& fault) {
  throw MeshError(source, fault, {face, -1});
}
[[noreturn]] void FailOnNode(const std::string& source, int node, const std::string& fault) {
  throw MeshError(source, fault, {-1, node});
}

// An edge of a triangle, from its smaller to its larger node.
struct HalfEdge {
  int low, high;
  int face, side;
  bool forward;  // the triangle runs from low to high

  bool SameEdge(const HalfEdge& other) const { return low == other.low && high == other.high; }
};

std::string Triangle(int face) { return "triangle " + std::to_string(face); }

Eigen::Vector3d AreaVector(const Eigen::Matrix3d& corners) {
  return 0.5 * (corners.col(1) - corners.col(0)).cross(corners.col(2) - corners.col(0));
}

Eigen::Matrix3d RestCorners(const Mesh& mesh, int face) {
  Eigen::Matrix3d corners;
  for (int k = 0; k < 3; ++k) corners.col(k) = RestCorner(mesh, face, k);
  return corners;
}

// Of triangle `face`; in the UV map where `map` says so.
void ValidateArea(const Eigen::Matrix3d& corners, const std::string& source, int face, const char* map = "") {
  double longest = 0.0;  // squared
  for (int k = 0; k < 3; ++k) longest = std::max(longest, (corners.col((k + 1) % 3) - corners.col(k)).squaredNorm());
  const double area = AreaVector(corners).norm();
  if (!(2.0 * area > kDegenerate * longest)) FailOnFace(source, face, Triangle(face) + map + " has no area");
  if (!std::isfinite(area))
    FailOnFace(source, face, Triangle(face) + map + " is too large for its area to be a number");
}

void ValidateFaces(const Mesh& mesh, const std::string& source) {
  for (int f = 0; f < mesh.num_faces(); ++f) {
    const Eigen::Vector3i face = mesh.faces.col(f);
    for (int k = 0; k < 3; ++k) {
      if (face[k] < 0 || face[k] >= mesh.num_nodes()) {
        FailOnFace(source, f,
                   Triangle(f) + " refers to node " + std::to_string(face[k]) + "; expected 0 to " +
                       std::to_string(mesh.num_nodes() - 1));
      }
    }
    if (face[0] == face[1] || face[1] == face[2] || face[2] == face[0]) {
      FailOnFace(source, f, Triangle(f) + " has the same node at two corners");
    }
    ValidateArea(mesh.rest_positions(Eigen::all, face), source, f);
    if (mesh.has_corner_rest()) ValidateArea(RestCorners(mesh, f), source, f, " of the UV map");
  }
}

std::vector<HalfEdge> SortedHalfEdges(const Mesh& mesh) {
  std::vector<HalfEdge> edges;
  edges.reserve(3 * static_cast<std::size_t>(mesh.num_faces()));
  for (int f = 0; f < mesh.num_faces(); ++f) {
    for (int k = 0; k < 3; ++k) {
      const int from = mesh.faces(k, f);
      const int to = mesh.faces((k + 1) % 3, f);
      edges.push_back({std::min(from, to), std::max(from, to), f, k, from < to});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const HalfEdge& a, const HalfEdge& b) {
    if (a.low != b.low) return a.low < b.low;
    return a.high != b.high ? a.high < b.high : a.face < b.face;
  });
  return edges;
}

std::string Place(const Mesh& mesh, const HalfEdge& edge) {
  const Eigen::Vector3d middle = 0.5 * (mesh.rest_positions.col(edge.low) + mesh.rest_positions.col(edge.high));
  std::ostringstream text;
  text << " at (" << middle.x() << ", " << middle.y() << ", " << middle.z() << ") m";
  return text.str();
}

// Of two triangles that share an edge, the places of its corners too: they must not lie on the same side of it there.
void ValidateUnfolded(const Mesh& mesh, const HalfEdge& a, const HalfEdge& b, const std::string& source) {
  const auto start = [&](const HalfEdge& edge) { return RestCorner(mesh, edge.face, edge.side); };
  const auto end = [&](const HalfEdge& edge) { return RestCorner(mesh, edge.face, (edge.side + 1) % 3); };
  if (start(a) != end(b) || end(a) != start(b)) return;
  const auto area = [&](const HalfEdge& edge) { return AreaVector(RestCorners(mesh, edge.face)).z(); };
  if (area(a) * area(b) > 0.0) return;
  FailOnFace(source, a.face,
             Triangle(a.face) + " and " + Triangle(b.face) + " lie on each other in the UV map, which is folded" +
                 " along their edge " + std::to_string(a.low) + "-" + std::to_string(a.high));
}

void ValidateEdges(const Mesh& mesh, const std::vector<HalfEdge>& edges, const std::string& source) {
  for (std::size_t i = 1; i < edges.size(); ++i) {
    if (!edges[i].SameEdge(edges[i - 1])) continue;
    const std::string edge = "edge " + std::to_string(edges[i].low) + "-" + std::to_string(edges[i].high);
    if (i >= 2 && edges[i].SameEdge(edges[i - 2])) {
      FailOnFace(source, edges[i].face,
                 edge + " belongs to more than two triangles (" + std::to_string(edges[i - 2].face) + ", " +
                     std::to_string(edges[i - 1].face) + ", " + std::to_string(edges[i].face) + ")" +
                     Place(mesh, edges[i]));
    }
    if (edges[i].forward == edges[i - 1].forward) {
      FailOnFace(source, edges[i].face,
                 Triangle(edges[i].face) + " is inverted relative to " + Triangle(edges[i - 1].face) +
                     " (both run along " + edge + " in the same direction)");
    }
    if (mesh.has_corner_rest()) ValidateUnfolded(mesh, edges[i - 1], edges[i], source);
  }
}

void ValidateNodes(const Mesh& mesh, const std::string& source) {
  std::vector<bool> used(static_cast<std::size_t>(mesh.num_nodes()), false);
  for (int f = 0; f < mesh.num_faces(); ++f) {
    for (int k = 0; k < 3; ++k) used[static_cast<std::size_t>(mesh.faces(k, f))] = true;
  }
  const auto unused = std::find(used.begin(), used.end(), false);
  if (unused != used.end()) {
    const auto node = static_cast<int>(unused - used.begin());
    FailOnNode(source, node, "node " + std::to_string(node) + " belongs to no triangle");
  }
}

void ValidateFolds(const Mesh& mesh, const std::vector<HalfEdge>& edges, const std::string& source) {
  for (const auto& [low, high] : mesh.folds) {
    const HalfEdge fold{low, high, 0, 0, true};
    const auto [first, last] = std::equal_range(edges.begin(), edges.end(), fold, [](const auto& a, const auto& b) {
      return a.low != b.low ? a.low < b.low : a.high < b.high;
    });
    if (last - first == 2) continue;
    FailOnMesh(source, "fold " + std::to_string(low) + "-" + std::to_string(high) + " is no edge of two triangles");
  }
}

void ValidateLinks(const Mesh& mesh, const std::string& source) {
  const auto is_node = [&](int node) { return node >= 0 && node < mesh.num_nodes(); };
  for (std::size_t i = 0; i < mesh.links.size(); ++i) {
    const SeamLink& link = mesh.links[i];
    const bool nodes_fit = is_node(link.node) && is_node(link.edge[0]) && is_node(link.edge[1]) &&
                           link.node != link.edge[0] && link.node != link.edge[1];
    const std::string name = "link " + std::to_string(i) + " of a seam: expected ";
    if (!nodes_fit)
      FailOnMesh(source, name + "two other nodes than its first, from 0 to " + std::to_string(mesh.num_nodes() - 1));
    if (!(link.share >= 0.0 && link.share <= 1.0)) FailOnMesh(source, name + "a share between 0 and 1");
    if (!(link.stiffness > 0.0 && std::isfinite(link.stiffness))) FailOnMesh(source, name + "a stiffness > 0");
    if (!(link.closing_time >= 0.0 && std::isfinite(link.closing_time))) FailOnMesh(source, name + "a time >= 0");
  }
}

void ValidateCornerRest(const Mesh& mesh, const std::string& source) {
  if (!mesh.has_corner_rest()) return;
  if (mesh.corner_rest.cols() != 3 * static_cast<Eigen::Index>(mesh.num_faces())) {
    FailOnMesh(source, "expected a place in the UV map for each of the " + std::to_string(mesh.num_faces()) +
                           " triangles' corners");
  }
  for (Eigen::Index c = 0; c < mesh.corner_rest.cols(); ++c) {
    if (mesh.corner_rest.col(c).allFinite()) continue;
    FailOnFace(source, static_cast<int>(c / 3),
               Triangle(static_cast<int>(c / 3)) + " has a place in the UV map that is not finite");
  }
}

}  // namespace

double RestLength(const Mesh& mesh, int face, int side) {
  return (RestCorner(mesh, face, (side + 1) % 3) - RestCorner(mesh, face, side)).norm();
}

Mesh MakeGrid(const GridOptions& options) {
  const auto [columns, rows] = options.nodes;
  const Eigen::Vector3d across = options.axes[0].normalized() * (options.size[0] / (columns - 1));
  const Eigen::Vector3d along = options.axes[1].normalized() * (options.size[1] / (rows - 1));
  Mesh mesh;
  mesh.rest_positions.resize(3, static_cast<Eigen::Index>(columns) * rows);
  mesh.faces.resize(3, 2 * static_cast<Eigen::Index>(columns - 1) * (rows - 1));
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      mesh.rest_positions.col(i + columns * j) = options.origin + i * across + j * along;
    }
  }
  Eigen::Index face = 0;
  for (int j = 0; j + 1 < rows; ++j) {
    for (int i = 0; i + 1 < columns; ++i) {
      const int a = i + columns * j, b = a + 1, c = a + columns, d = c + 1;
      const bool rising = (i + j) % 2 == 0;
      mesh.faces.col(face++) = rising ? Eigen::Vector3i(a, b, d) : Eigen::Vector3i(a, b, c);
      mesh.faces.col(face++) = rising ? Eigen::Vector3i(a, d, c) : Eigen::Vector3i(b, d, c);
    }
  }
  return mesh;
}

void ValidateMesh(const Mesh& mesh, const std::string& source) {
  if (mesh.num_nodes() == 0 || mesh.num_faces() == 0) FailOnMesh(source, "the mesh has no triangle");
  if (mesh.num_nodes() > kMaxNodes) FailOnMesh(source, "more than " + std::to_string(kMaxNodes) + " nodes");
  if (mesh.num_faces() > kMaxFaces) FailOnMesh(source, "more than " + std::to_string(kMaxFaces) + " triangles");
  for (int i = 0; i < mesh.num_nodes(); ++i) {
    if (!mesh.rest_positions.col(i).allFinite()) {
      FailOnNode(source, i, "the rest position of node " + std::to_string(i) + " is not finite");
    }
  }
  ValidateCornerRest(mesh, source);
  ValidateFaces(mesh, source);
  const std::vector<HalfEdge> edges = SortedHalfEdges(mesh);
  ValidateEdges(mesh, edges, source);
  ValidateNodes(mesh, source);
  ValidateFolds(mesh, edges, source);
  ValidateLinks(mesh, source);
}

Eigen::VectorXd TriangleAreas(const Mesh& mesh) {
  Eigen::VectorXd areas(mesh.num_faces());
  for (int f = 0; f < mesh.num_faces(); ++f) areas[f] = AreaVector(RestCorners(mesh, f)).norm();
  return areas;
}

Eigen::VectorXd NodeAreas(const Mesh& mesh) {
  Eigen::VectorXd areas = Eigen::VectorXd::Zero(mesh.num_nodes());
  const Eigen::VectorXd triangles = TriangleAreas(mesh);
  for (int f = 0; f < mesh.num_faces(); ++f) {
    for (int k = 0; k < 3; ++k) areas[mesh.faces(k, f)] += triangles[f] / 3.0;
  }
  return areas;
}

double ClothSize(const Mesh& mesh) { return std::sqrt(TriangleAreas(mesh).sum()); }

}  // namespace clothid
