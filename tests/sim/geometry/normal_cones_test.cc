#include "sim/geometry/normal_cones.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "sim/mesh/mesh.h"
#include "tests/sim/random_numbers.h"

namespace clothid::normal_cones_test {
namespace {

using Eigen::Vector3d;
using Box = BoxTree::Box;

// A sheet without a border, as far as the cones know, of normals that are its faces' alone.
struct Sheet {
  explicit Sheet(const Mesh& of) : mesh(of) {
    for (int f = 0; f < mesh.num_faces(); ++f) {
      const Vector3d a = Corner(f, 0), b = Corner(f, 1), c = Corner(f, 2);
      places.push_back(Box(a).extend(b).extend(c));
      normals.emplace_back(Vector3d((b - a).cross(c - a).normalized()));
    }
    tree = BoxTree(places);
    cones.Refit(tree, places, normals);
  }

  Vector3d Corner(int face, int corner) const { return mesh.rest_positions.col(mesh.faces(corner, face)); }

  std::vector<bool> Visited(const Vector3d& x) const {
    std::vector<bool> visited(places.size(), false);
    tree.VisitOverlaps(
        Box(Vector3d::Constant(-1e9), Vector3d::Constant(1e9)), [&](int node) { return cones.MayHoldClosest(node, x); },
        [&](int face) { visited[face] = true; });
    return visited;
  }

  Mesh mesh;
  std::vector<Box> places, normals;
  BoxTree tree;
  NormalCones cones;
};

Mesh WavySheet(int nodes, double height) {
  GridOptions grid;
  grid.nodes = {nodes, nodes};
  grid.size = {1.0, 1.0};
  Mesh mesh = MakeGrid(grid);
  for (auto x : mesh.rest_positions.colwise()) x[2] = height * std::sin(7.0 * x[0]) * std::cos(5.0 * x[1] + 1.0);
  return mesh;
}

// Whether the normal of the face through a point inside it goes through x.
TEST(NormalCones, LeaveOutNoFaceThatIsStraightBelow) {
  RandomNumbers random(1);
  for (const double height : {0.0, 0.02, 0.1, 0.5}) {
    const Sheet sheet(WavySheet(12, height));
    for (int trial = 0; trial < 500; ++trial) {
      const int face = random.Integer(0, sheet.mesh.num_faces() - 1);
      const double b = random.Uniform(0.0, 0.5), c = random.Uniform(0.0, 0.5);
      const Vector3d inside =
          (1.0 - b - c) * sheet.Corner(face, 0) + b * sheet.Corner(face, 1) + c * sheet.Corner(face, 2);
      EXPECT_TRUE(sheet.Visited(inside + random.Uniform(-2.0, 2.0) * sheet.normals[face].center())[face]);
    }
  }
}

TEST(NormalCones, LookAtAsManyFacesInLargerFlatSheets) {
  RandomNumbers random(2);
  for (const int nodes : {10, 20, 40, 80}) {
    const Sheet sheet(WavySheet(nodes, 0.0));
    for (int trial = 0; trial < 20; ++trial) {
      const std::vector<bool> visited = sheet.Visited({random.Uniform(0.0, 1.0), random.Uniform(0.0, 1.0), 0.3});
      EXPECT_LE(std::count(visited.begin(), visited.end(), true), 60);
    }
  }
}

TEST(NormalCones, LeaveOutNothingWhereNormalsPointEverywhere) {
  Sheet sheet(WavySheet(8, 0.0));
  sheet.normals.assign(sheet.normals.size(), Box(-Vector3d::Ones(), Vector3d::Ones()));
  sheet.cones.Refit(sheet.tree, sheet.places, sheet.normals);
  const std::vector<bool> visited = sheet.Visited({5.0, 3.0, 0.1});
  EXPECT_EQ(std::count(visited.begin(), visited.end(), true), sheet.mesh.num_faces());
}

}  // namespace
}  // namespace clothid::normal_cones_test
