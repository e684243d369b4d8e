#include "sim/contact/intersections.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "tests/sim/random_numbers.h"
#include "tests/sim/sheet_meshes.h"

namespace clothid::intersections_test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Two triangles of their own nodes.
Mesh TwoTriangles(const Matrix3d& a, const Matrix3d& b) {
  Mesh mesh;
  mesh.rest_positions.resize(3, 6);
  mesh.rest_positions << a, b;
  mesh.faces.resize(3, 2);
  mesh.faces << 0, 3, 1, 4, 2, 5;
  return mesh;
}

int Count(const Mesh& mesh) { return IntersectionCounter(mesh).Count(mesh.rest_positions.reshaped()).count; }

Matrix3d Triangle(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  Matrix3d result;
  result << a, b, c;
  return result;
}

// Whether p + s (q - p), 0 < s < 1, is inside the triangle, by solving for s and the weights.
bool CutsBySolving(const Vector3d& p, const Vector3d& q, const Matrix3d& face) {
  Matrix3d matrix;
  matrix << q - p, face.col(0) - face.col(1), face.col(0) - face.col(2);
  const Vector3d solution = matrix.inverse() * (face.col(0) - p);
  return solution.minCoeff() > 0.0 && solution[0] < 1.0 && solution[1] + solution[2] < 1.0;
}

bool IntersectBySolving(const Matrix3d& a, const Matrix3d& b) {
  for (int k = 0; k < 3; ++k) {
    if (CutsBySolving(a.col(k), a.col((k + 1) % 3), b) || CutsBySolving(b.col(k), b.col((k + 1) % 3), a)) return true;
  }
  return false;
}

TEST(Intersections, OfRandomSheetsAreThoseOfAllPairs) {
  RandomNumbers random(3);
  int num_found = 0;
  for (int trial = 0; trial < 10; ++trial) {
    GridOptions grid;
    grid.nodes = {random.Integer(3, 9), random.Integer(3, 9)};
    const Mesh mesh = MakeSheet(SheetKind::kIrregular, grid);
    const Eigen::VectorXd positions =
        mesh.rest_positions.reshaped() + 0.1 * random.InCube(3 * static_cast<Eigen::Index>(mesh.num_nodes()));
    Intersections expected;
    const auto nodes = positions.reshaped(3, mesh.num_nodes());
    for (int f = 0; f < mesh.num_faces(); ++f) {
      for (int g = f + 1; g < mesh.num_faces(); ++g) {
        bool are_apart = true;
        for (int k = 0; k < 3; ++k) are_apart = are_apart && (mesh.faces.col(g).array() != mesh.faces(k, f)).all();
        const Matrix3d a = nodes(Eigen::all, mesh.faces.col(f)), b = nodes(Eigen::all, mesh.faces.col(g));
        if (!are_apart || !IntersectBySolving(a, b)) continue;
        if (expected.count++ == 0) expected.first = {f, g};
      }
    }
    IntersectionCounter counter(mesh);
    const Intersections found = counter.Count(positions);
    num_found += found.count;
    EXPECT_EQ(found.count, expected.count);
    EXPECT_EQ(found.first, expected.first);
    EXPECT_EQ(counter.Count(mesh.rest_positions.reshaped()).count, 0);
  }
  EXPECT_GT(num_found, 100);
}

TEST(Intersections, OfTrianglesThatTouchDoNotCount) {
  const Vector3d x = Vector3d::UnitX(), y = Vector3d::UnitY(), z = Vector3d::UnitZ(), o = Vector3d::Zero();
  const Matrix3d base = Triangle(o, x, y);
  EXPECT_EQ(Count(TwoTriangles(base, Triangle(0.2 * x + 0.2 * y - z, 0.2 * x + 0.3 * y + z, 3.0 * x + z))), 1);
  EXPECT_EQ(Count(TwoTriangles(base, base)), 0);                                         // the same place
  EXPECT_EQ(Count(TwoTriangles(base, Triangle(0.2 * x + 0.2 * y, x + y, 2.0 * x))), 0);  // overlap in the plane
  EXPECT_EQ(Count(TwoTriangles(base, Triangle(0.2 * x + 0.2 * y, z, x + z))), 0);        // a corner on a face
  EXPECT_EQ(Count(TwoTriangles(base, Triangle(o, x, x - y + z))), 0);                    // an edge on an edge
  EXPECT_EQ(Count(TwoTriangles(base, Triangle(0.5 * x - z, 0.5 * x + z, -y))), 0);       // edges cross
  EXPECT_EQ(Count(TwoTriangles(base, Triangle(x + y - z, x + y + z, 2.0 * x + y))), 0);  // beside it
}

// Of numbers with 30 digits the sum is exact, so that points are in the plane z = x + y, but volumes are rounded.
TEST(Intersections, OfTrianglesInAnObliquePlaneDoNotCount) {
  RandomNumbers random(4);
  for (int trial = 0; trial < 2000; ++trial) {
    Eigen::Matrix<double, 3, 6> corners;
    for (auto corner : corners.colwise()) {
      for (int k = 0; k < 2; ++k) corner[k] = std::ldexp(std::round(std::ldexp(random.Uniform(-1.0, 1.0), 30)), -30);
      corner[2] = corner[0] + corner[1];
    }
    EXPECT_EQ(Count(TwoTriangles(corners.leftCols(3), corners.rightCols(3))), 0);
  }
}

TEST(Intersections, OfASheetPulledThroughAnotherGrowWithTheirCommonLine) {
  GridOptions grid;
  grid.nodes = {11, 11};
  const Mesh lower = MakeSheet(SheetKind::kIrregular, grid);
  grid.axes = {Vector3d::UnitX(), Vector3d::UnitZ()};
  grid.origin = {0.0123, 0.1477, -0.1511};
  const Mesh upper = MakeGrid(grid);
  Mesh mesh;
  mesh.rest_positions.resize(3, 242);
  mesh.rest_positions << lower.rest_positions, upper.rest_positions;
  mesh.faces.resize(3, 400);
  mesh.faces << lower.faces, upper.faces.array() + 121;
  IntersectionCounter counter(mesh);
  Eigen::VectorXd positions = mesh.rest_positions.reshaped();
  const Intersections crossed = counter.Count(positions);
  EXPECT_GE(crossed.count, 40);  // 10 squares of both, two triangles each
  EXPECT_LT(crossed.count, 120);
  EXPECT_LT(crossed.first[0], 200);
  EXPECT_GE(crossed.first[1], 200);
  for (int node = 121; node < 242; ++node) positions[3 * node + 2] += 0.16;
  EXPECT_EQ(counter.Count(positions).count, 0);
}

}  // namespace
}  // namespace clothid::intersections_test
