// Closed triangle meshes for tests of triangulated obstacles.
#ifndef CLOTHID_TESTS_SIM_SCENE_TRIANGLE_MESHES_H_
#define CLOTHID_TESTS_SIM_SCENE_TRIANGLE_MESHES_H_

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

namespace clothid {

struct TriangleMesh {
  Eigen::Matrix3Xd vertices;  // m
  Eigen::Matrix3Xi faces;     // counter-clockwise seen from outside
};

// The cube [-half, half]^3: 8 vertices (bit k of the index: the sign of axis k), 12 faces.
inline TriangleMesh CubeMesh(double half) {
  TriangleMesh mesh;
  mesh.vertices.resize(3, 8);
  for (int i = 0; i < 8; ++i) {
    for (int k = 0; k < 3; ++k) mesh.vertices(k, i) = (i >> k & 1) == 1 ? half : -half;
  }
  mesh.faces.resize(3, 12);
  mesh.faces << 0, 0, 4, 4, 0, 0, 2, 2, 0, 0, 1, 1,  //
      2, 3, 5, 7, 1, 5, 6, 7, 4, 6, 3, 7,            //
      3, 1, 7, 6, 5, 4, 7, 3, 6, 2, 7, 5;
  return mesh;
}

// Every face split in four at the middles of its edges.
inline TriangleMesh Split(const TriangleMesh& mesh) {
  std::vector<Eigen::Vector3d> vertices;
  for (Eigen::Index i = 0; i < mesh.vertices.cols(); ++i) vertices.push_back(mesh.vertices.col(i));
  std::map<std::pair<int, int>, int> middles;
  const auto middle = [&](int a, int b) {
    const auto [entry, is_new] = middles.insert({std::minmax(a, b), static_cast<int>(vertices.size())});
    if (is_new) vertices.push_back(0.5 * (vertices[a] + vertices[b]));
    return entry->second;
  };
  TriangleMesh result;
  result.faces.resize(3, 4 * mesh.faces.cols());
  for (Eigen::Index i = 0; i < mesh.faces.cols(); ++i) {
    const Eigen::Vector3i f = mesh.faces.col(i);
    const int ab = middle(f[0], f[1]), bc = middle(f[1], f[2]), ca = middle(f[2], f[0]);
    result.faces.middleCols<4>(4 * i) << f[0], f[1], f[2], ab,  //
        ab, bc, ca, bc,                                         //
        ca, ab, bc, ca;
  }
  result.vertices.resize(3, static_cast<Eigen::Index>(vertices.size()));
  for (std::size_t i = 0; i < vertices.size(); ++i) result.vertices.col(i) = vertices[i];
  return result;
}

// An icosahedron whose faces are split in four `levels` times, all vertices on the sphere: 20 * 4^levels faces.
inline TriangleMesh IcosphereMesh(int levels, double radius) {
  const double t = (1.0 + std::sqrt(5.0)) / 2.0;
  TriangleMesh mesh;
  mesh.vertices.resize(3, 12);
  mesh.vertices << -1, 1, -1, 1, 0, 0, 0, 0, t, t, -t, -t,  //
      t, t, -t, -t, -1, 1, -1, 1, 0, 0, 0, 0,               //
      0, 0, 0, 0, t, t, -t, -t, -1, 1, -1, 1;
  mesh.faces.resize(3, 20);
  mesh.faces << 0, 0, 0, 0, 0, 1, 5, 11, 10, 7, 3, 3, 3, 3, 3, 4, 2, 6, 8, 9,  //
      11, 5, 1, 7, 10, 5, 11, 10, 7, 1, 9, 4, 2, 6, 8, 9, 4, 2, 6, 8,          //
      5, 1, 7, 10, 11, 9, 4, 2, 6, 8, 4, 2, 6, 8, 9, 5, 11, 10, 7, 1;
  for (int level = 0; level < levels; ++level) {
    mesh = Split(mesh);
    mesh.vertices.colwise().normalize();
  }
  mesh.vertices.colwise().normalize();
  mesh.vertices *= radius;
  return mesh;
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_SIM_SCENE_TRIANGLE_MESHES_H_
