#include "identify/export/flex_order.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

namespace clothid {
namespace {

constexpr int kNumDirections = 12;
constexpr double kEqualWeights = 1e-6;

double Cotangent(const Eigen::Vector3d& a, const Eigen::Vector3d& b) { return a.dot(b) / a.cross(b).norm(); }

// An inner edge and the nodes across it.
struct InnerEdge {
  int ends[2];
  int opposite[2];
  bool is_symmetric;  // both ends have the same weight
};

std::vector<InnerEdge> InnerEdges(const Mesh& mesh) {
  std::map<std::pair<int, int>, std::vector<int>> opposite;
  for (int f = 0; f < mesh.num_faces(); ++f) {
    for (int k = 0; k < 3; ++k) {
      const std::pair<int, int> ends = std::minmax({mesh.faces(k, f), mesh.faces((k + 1) % 3, f)});
      opposite[ends].push_back(mesh.faces((k + 2) % 3, f));
    }
  }
  const auto x = [&](int node) -> Eigen::Vector3d { return mesh.rest_positions.col(node); };
  std::vector<InnerEdge> edges;
  for (const auto& [ends, nodes] : opposite) {
    if (nodes.size() < 2) continue;
    double first = 0.0, second = 0.0;  // the weight of an end: the sum of the cotangents at the other
    for (const int node : nodes) {
      first += Cotangent(x(ends.first) - x(ends.second), x(node) - x(ends.second));
      second += Cotangent(x(ends.second) - x(ends.first), x(node) - x(ends.first));
    }
    const bool is_symmetric = std::abs(first - second) < kEqualWeights * (1.0 + std::abs(first) + std::abs(second));
    edges.push_back({{ends.first, ends.second}, {nodes[0], nodes[1]}, is_symmetric});
  }
  return edges;
}

int CountSwapped(const std::vector<InnerEdge>& edges, const std::vector<int>& numbers) {
  return static_cast<int>(std::count_if(edges.begin(), edges.end(), [&](const InnerEdge& edge) {
    const auto [low, high] = std::minmax({numbers[edge.ends[0]], numbers[edge.ends[1]]});
    const auto lies_between = [&, low = low, high = high](int node) {
      return numbers[node] > low && numbers[node] < high;
    };
    return !edge.is_symmetric && lies_between(edge.opposite[0]) && lies_between(edge.opposite[1]);
  }));
}

std::vector<int> NodesAlong(const Mesh& mesh, const Eigen::Vector3d& direction) {
  const Eigen::VectorXd heights = mesh.rest_positions.transpose() * direction;
  std::vector<int> nodes(static_cast<std::size_t>(mesh.num_nodes()));
  std::iota(nodes.begin(), nodes.end(), 0);
  std::stable_sort(nodes.begin(), nodes.end(), [&](int a, int b) { return heights[a] < heights[b]; });
  return nodes;
}

std::vector<int> Inverse(const std::vector<int>& nodes) {
  std::vector<int> numbers(nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) numbers[static_cast<std::size_t>(nodes[i])] = static_cast<int>(i);
  return numbers;
}

// Nodes rising in every triangle, triangles by falling span.
Eigen::Matrix3Xi OrderFaces(const Mesh& mesh, const std::vector<int>& numbers) {
  std::vector<Eigen::Vector3i> faces;
  for (int f = 0; f < mesh.num_faces(); ++f) {
    Eigen::Vector3i face = mesh.faces.col(f).unaryExpr([&](int node) { return numbers[node]; });
    std::sort(face.data(), face.data() + 3);
    faces.push_back(face);
  }
  std::stable_sort(faces.begin(), faces.end(),
                   [](const Eigen::Vector3i& a, const Eigen::Vector3i& b) { return a[2] - a[0] > b[2] - b[0]; });
  Eigen::Matrix3Xi result(3, mesh.num_faces());
  for (int f = 0; f < mesh.num_faces(); ++f) result.col(f) = faces[static_cast<std::size_t>(f)];
  return result;
}

}  // namespace

FlexOrder OrderFlex(const Mesh& mesh) {
  const std::vector<InnerEdge> edges = InnerEdges(mesh);
  FlexOrder best;
  best.nodes.resize(static_cast<std::size_t>(mesh.num_nodes()));
  std::iota(best.nodes.begin(), best.nodes.end(), 0);
  best.num_swapped = CountSwapped(edges, best.nodes);
  const Eigen::Vector3d first = mesh.rest_positions.col(mesh.faces(1, 0)) - mesh.rest_positions.col(mesh.faces(0, 0));
  const Eigen::Vector3d other = mesh.rest_positions.col(mesh.faces(2, 0)) - mesh.rest_positions.col(mesh.faces(0, 0));
  const Eigen::Vector3d u = first.normalized(), v = first.cross(other).cross(first).normalized();
  for (int i = 0; i < kNumDirections && best.num_swapped > 0; ++i) {
    const double angle = M_PI * (i + 0.25) / kNumDirections;  // along no edge of a grid
    const std::vector<int> nodes = NodesAlong(mesh, std::cos(angle) * u + std::sin(angle) * v);
    const int num_swapped = CountSwapped(edges, Inverse(nodes));
    if (num_swapped < best.num_swapped) best = {nodes, {}, num_swapped};
  }
  best.faces = OrderFaces(mesh, Inverse(best.nodes));
  return best;
}

}  // namespace clothid
