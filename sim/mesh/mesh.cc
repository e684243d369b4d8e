#include "sim/mesh/mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "sim/base/error.h"

namespace clothid {
namespace {

// Twice the area of a triangle that counts as having none, relative to its longest side squared: the rounding of
// coordinates given to seven digits.
constexpr double kDegenerate = 1e-7;

// An edge of a triangle, from its smaller to its larger node.
struct HalfEdge {
  int low, high;
  int face;
  bool forward;  // the triangle runs from low to high

  bool SameEdge(const HalfEdge& other) const { return low == other.low && high == other.high; }
};

std::string Triangle(int face) { return "triangle " + std::to_string(face); }

Eigen::Vector3d Corner(const Mesh& mesh, int face, int corner) {
  return mesh.rest_positions.col(mesh.faces(corner, face));
}

Eigen::Vector3d AreaVector(const Mesh& mesh, int face) {
  const Eigen::Vector3d origin = Corner(mesh, face, 0);
  return 0.5 * (Corner(mesh, face, 1) - origin).cross(Corner(mesh, face, 2) - origin);
}

double LongestSideSquared(const Mesh& mesh, int face) {
  double longest = 0.0;
  for (int k = 0; k < 3; ++k) {
    longest = std::max(longest, (Corner(mesh, face, (k + 1) % 3) - Corner(mesh, face, k)).squaredNorm());
  }
  return longest;
}

void ValidateFaces(const Mesh& mesh, const std::string& source) {
  for (int f = 0; f < mesh.num_faces(); ++f) {
    const Eigen::Vector3i face = mesh.faces.col(f);
    for (int k = 0; k < 3; ++k) {
      if (face[k] < 0 || face[k] >= mesh.num_nodes()) {
        FailOnData(source, Triangle(f) + " refers to node " + std::to_string(face[k]) + "; expected 0 to " +
                               std::to_string(mesh.num_nodes() - 1));
      }
    }
    if (face[0] == face[1] || face[1] == face[2] || face[2] == face[0]) {
      FailOnData(source, Triangle(f) + " has the same node at two corners");
    }
    const double area = AreaVector(mesh, f).norm();
    if (!(2.0 * area > kDegenerate * LongestSideSquared(mesh, f))) FailOnData(source, Triangle(f) + " has no area");
    if (!std::isfinite(area)) FailOnData(source, Triangle(f) + " is too large for its area to be a number");
  }
}

std::vector<HalfEdge> SortedHalfEdges(const Mesh& mesh) {
  std::vector<HalfEdge> edges;
  edges.reserve(3 * static_cast<std::size_t>(mesh.num_faces()));
  for (int f = 0; f < mesh.num_faces(); ++f) {
    for (int k = 0; k < 3; ++k) {
      const int from = mesh.faces(k, f);
      const int to = mesh.faces((k + 1) % 3, f);
      edges.push_back({std::min(from, to), std::max(from, to), f, from < to});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const HalfEdge& a, const HalfEdge& b) {
    if (a.low != b.low) return a.low < b.low;
    return a.high != b.high ? a.high < b.high : a.face < b.face;
  });
  return edges;
}

void ValidateEdges(const Mesh& mesh, const std::string& source) {
  const std::vector<HalfEdge> edges = SortedHalfEdges(mesh);
  for (std::size_t i = 1; i < edges.size(); ++i) {
    if (!edges[i].SameEdge(edges[i - 1])) continue;
    const std::string edge = "edge " + std::to_string(edges[i].low) + "-" + std::to_string(edges[i].high);
    if (i >= 2 && edges[i].SameEdge(edges[i - 2])) {
      FailOnData(source, edge + " belongs to more than two triangles (" + std::to_string(edges[i - 2].face) + ", " +
                             std::to_string(edges[i - 1].face) + ", " + std::to_string(edges[i].face) + ")");
    }
    if (edges[i].forward == edges[i - 1].forward) {
      FailOnData(source, Triangle(edges[i].face) + " is inverted relative to " + Triangle(edges[i - 1].face) +
                             " (both run along " + edge + " in the same direction)");
    }
  }
}

void ValidateNodes(const Mesh& mesh, const std::string& source) {
  std::vector<bool> used(static_cast<std::size_t>(mesh.num_nodes()), false);
  for (int f = 0; f < mesh.num_faces(); ++f) {
    for (int k = 0; k < 3; ++k) used[static_cast<std::size_t>(mesh.faces(k, f))] = true;
  }
  const auto unused = std::find(used.begin(), used.end(), false);
  if (unused != used.end()) {
    FailOnData(source, "node " + std::to_string(unused - used.begin()) + " belongs to no triangle");
  }
}

}  // namespace

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
  if (mesh.num_nodes() == 0 || mesh.num_faces() == 0) FailOnData(source, "the mesh has no triangle");
  if (mesh.num_nodes() > kMaxNodes) FailOnData(source, "more than " + std::to_string(kMaxNodes) + " nodes");
  if (mesh.num_faces() > kMaxFaces) FailOnData(source, "more than " + std::to_string(kMaxFaces) + " triangles");
  for (int i = 0; i < mesh.num_nodes(); ++i) {
    if (!mesh.rest_positions.col(i).allFinite()) {
      FailOnData(source, "the rest position of node " + std::to_string(i) + " is not finite");
    }
  }
  ValidateFaces(mesh, source);
  ValidateEdges(mesh, source);
  ValidateNodes(mesh, source);
}

Eigen::VectorXd TriangleAreas(const Mesh& mesh) {
  Eigen::VectorXd areas(mesh.num_faces());
  for (int f = 0; f < mesh.num_faces(); ++f) areas[f] = AreaVector(mesh, f).norm();
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
