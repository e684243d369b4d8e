#include "tools/benchmark/continuity/icosphere.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

namespace clothid {
namespace {

struct Triangles {
  std::vector<Eigen::Vector3d> nodes;
  std::vector<Eigen::Vector3i> faces;
};

// Corners are the cyclic permutations of (0, +-1, +-golden ratio).
Triangles MakeIcosahedron() {
  const double p = 0.5 * (1.0 + std::sqrt(5.0));
  Triangles sphere;
  sphere.nodes = {{-1, p, 0},  {1, p, 0},  {-1, -p, 0}, {1, -p, 0}, {0, -1, p},  {0, 1, p},
                  {0, -1, -p}, {0, 1, -p}, {p, 0, -1},  {p, 0, 1},  {-p, 0, -1}, {-p, 0, 1}};
  for (Eigen::Vector3d& node : sphere.nodes) node.normalize();
  sphere.faces = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                  {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                  {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  return sphere;
}

// Every triangle into four at the middles of its edges, which move out to the sphere.
Triangles Split(Triangles sphere) {
  std::map<std::pair<int, int>, int> middles;
  const auto middle = [&](int a, int b) {
    const auto [entry, is_new] = middles.try_emplace(std::minmax(a, b), static_cast<int>(sphere.nodes.size()));
    if (is_new) sphere.nodes.push_back((sphere.nodes[a] + sphere.nodes[b]).normalized());
    return entry->second;
  };
  std::vector<Eigen::Vector3i> faces;
  for (const Eigen::Vector3i& f : sphere.faces) {
    const int a = middle(f[1], f[2]), b = middle(f[2], f[0]), c = middle(f[0], f[1]);
    faces.insert(faces.end(), {{f[0], c, b}, {f[1], a, c}, {f[2], b, a}, {a, b, c}});
  }
  sphere.faces = std::move(faces);
  return sphere;
}

}  // namespace

Mesh MakeIcosphere(int num_splits) {
  Triangles sphere = MakeIcosahedron();
  for (int i = 0; i < num_splits; ++i) sphere = Split(std::move(sphere));
  Mesh mesh;
  mesh.rest_positions.resize(3, static_cast<Eigen::Index>(sphere.nodes.size()));
  mesh.faces.resize(3, static_cast<Eigen::Index>(sphere.faces.size()));
  for (std::size_t i = 0; i < sphere.nodes.size(); ++i) mesh.rest_positions.col(i) = sphere.nodes[i];
  for (std::size_t i = 0; i < sphere.faces.size(); ++i) mesh.faces.col(i) = sphere.faces[i];
  return mesh;
}

}  // namespace clothid
