#include "sim/obstacle/triangulated_surface.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "sim/rollout/simulator.h"
#include "tests/expect_error.h"
#include "tests/sim/plain_scenes.h"
#include "tests/sim/scene/triangle_meshes.h"

namespace clothid::triangulated_surface_test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

TriangulatedSurface MakeSurface(const TriangleMesh& mesh) { return TriangulatedSurface(mesh.vertices, mesh.faces); }

// A sphere of radius 0.5 that is uneven and has twelve pits: its edges and vertices are convex, concave and saddles.
TriangleMesh DentedMesh(int levels) {
  TriangleMesh mesh = IcosphereMesh(levels, 0.5);
  std::mt19937 generator(3);
  std::uniform_real_distribution<double> scale(0.8, 1.0);
  for (Eigen::Index i = 0; i < mesh.vertices.cols(); ++i)
    mesh.vertices.col(i) *= scale(generator) * (i < 12 ? 0.5 : 1.0);
  return mesh;
}

// Uniform in [-0.8, 0.8]^3.
std::vector<Vector3d> RandomPoints(int count) {
  std::mt19937 generator(7);
  std::uniform_real_distribution<double> uniform(-0.8, 0.8);
  std::vector<Vector3d> points(count);
  for (Vector3d& x : points) x << uniform(generator), uniform(generator), uniform(generator);
  return points;
}

std::array<Vector3d, 3> Corners(const TriangleMesh& mesh, Eigen::Index face) {
  return {mesh.vertices.col(mesh.faces(0, face)), mesh.vertices.col(mesh.faces(1, face)),
          mesh.vertices.col(mesh.faces(2, face))};
}

double DistanceToSegment(const Vector3d& x, const Vector3d& from, const Vector3d& to) {
  const double along = std::clamp((x - from).dot(to - from) / (to - from).squaredNorm(), 0.0, 1.0);
  return (x - from - along * (to - from)).norm();
}

// To the plane where x is above or below the triangle, else to the nearest of all sides.
double DistanceToTriangle(const Vector3d& x, const std::array<Vector3d, 3>& corners) {
  const Vector3d normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
  bool is_above = true;
  double distance = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector3d &from = corners[k], &to = corners[(k + 1) % 3];
    is_above = is_above && normal.dot((to - from).cross(x - from)) >= 0.0;
    distance = std::min(distance, DistanceToSegment(x, from, to));
  }
  return is_above ? std::abs(normal.dot(x - corners[0])) : distance;
}

// Without tree and pseudonormals: all triangles one by one, and the sign from their solid angles, which add up to 4 pi
// inside and to 0 outside (Van Oosterom and Strackee 1983).
double BruteForceGap(const TriangleMesh& mesh, const Vector3d& x) {
  double distance = std::numeric_limits<double>::infinity(), solid_angle = 0.0;
  for (Eigen::Index face = 0; face < mesh.faces.cols(); ++face) {
    const std::array<Vector3d, 3> corners = Corners(mesh, face);
    distance = std::min(distance, DistanceToTriangle(x, corners));
    const Vector3d a = (corners[0] - x).normalized(), b = (corners[1] - x).normalized(),
                   c = (corners[2] - x).normalized();
    solid_angle += 2.0 * std::atan2(a.dot(b.cross(c)), 1.0 + a.dot(b) + b.dot(c) + c.dot(a));
  }
  return solid_angle > 2.0 * kPi ? -distance : distance;
}

TEST(TriangulatedSurface, EqualsBruteForceOverAllTriangles) {
  for (const TriangleMesh& mesh : {CubeMesh(0.5), Split(CubeMesh(0.5)), IcosphereMesh(2, 0.5), DentedMesh(2)}) {
    const TriangulatedSurface surface = MakeSurface(mesh);
    int num_inside = 0;
    for (const Vector3d& x : RandomPoints(1000)) {
      const SurfacePoint point = surface.Closest(x);
      ASSERT_NEAR(point.gap, BruteForceGap(mesh, x), 1e-12) << x.transpose();
      ASSERT_NEAR(point.normal.norm(), 1.0, 1e-12);
      ASSERT_NEAR(BruteForceGap(mesh, x - point.gap * point.normal), 0.0, 1e-12);
      num_inside += point.gap < 0.0;
    }
    EXPECT_GT(num_inside, 50);
    EXPECT_LT(num_inside, 500);
  }
}

TEST(TriangulatedSurface, MeasuresACube) {
  const TriangulatedSurface cube = MakeSurface(CubeMesh(0.5));
  EXPECT_DOUBLE_EQ(cube.Closest({0.1, 0.2, 0.75}).gap, 0.25);
  EXPECT_EQ(cube.Closest({0.1, 0.2, 0.75}).normal, Vector3d::UnitZ());
  EXPECT_DOUBLE_EQ(cube.Closest({0.1, 0.2, 0.4}).gap, -0.1);
  EXPECT_EQ(cube.Closest({0.1, 0.2, 0.4}).normal, Vector3d::UnitZ());
  EXPECT_DOUBLE_EQ(cube.Closest({0.8, 0.2, 0.9}).gap, 0.5);
  EXPECT_DOUBLE_EQ(cube.Closest({1.5, -2.5, 2.5}).gap, 3.0);
}

// Four times as many triangles, a quarter of the error, inside and outside.
TEST(TriangulatedSurface, ApproachesASphereAtSecondOrder) {
  const std::vector<Vector3d> points = RandomPoints(1000);
  double previous_inside = 0.0, previous_outside = 0.0;
  for (int levels = 2; levels <= 4; ++levels) {
    const TriangulatedSurface surface = MakeSurface(IcosphereMesh(levels, 0.5));
    double inside = 0.0, outside = 0.0;
    for (const Vector3d& x : points) {
      const double gap = x.norm() - 0.5;
      double& error = gap < 0.0 ? inside : outside;
      error = std::max(error, std::abs(surface.Closest(x).gap - gap));
    }
    if (levels > 2) {
      EXPECT_NEAR(previous_inside / inside, 4.0, 0.4);
      EXPECT_NEAR(previous_outside / outside, 4.0, 0.4);
    }
    previous_inside = inside;
    previous_outside = outside;
  }
}

// dn/dx has no positive part on a face, one direction at an edge, two at a vertex.
int FeatureKind(const SurfacePoint& point) {
  return static_cast<int>(std::lround(std::abs(point.normal_gradient.trace() * point.gap)));
}

// Central differences, unless the closest point leaves its feature within twice their step: then false.
bool ExpectDerivatives(const TriangulatedSurface& surface, const Vector3d& x) {
  constexpr double kStep = 1e-6;  // m
  const SurfacePoint point = surface.Closest(x);
  Vector3d normal;
  Matrix3d normal_gradient;
  for (int k = 0; k < 3; ++k) {
    const Vector3d offset = kStep * Vector3d::Unit(k);
    for (const Vector3d& far : {Vector3d(x + 2.0 * offset), Vector3d(x - 2.0 * offset)}) {
      const SurfacePoint other = surface.Closest(far);
      const Vector3d moved = far - other.gap * other.normal - (x - point.gap * point.normal);
      if (FeatureKind(other) != FeatureKind(point) || moved.norm() > 10.0 * kStep) return false;
    }
    const SurfacePoint ahead = surface.Closest(x + offset), behind = surface.Closest(x - offset);
    normal[k] = (ahead.gap - behind.gap) / (2.0 * kStep);
    normal_gradient.col(k) = (ahead.normal - behind.normal) / (2.0 * kStep);
  }
  EXPECT_LT((point.normal - normal).norm(), 1e-8) << x.transpose();
  EXPECT_LT((point.normal_gradient - normal_gradient).norm(), 1e-6) << x.transpose();
  EXPECT_LT((point.normal_gradient - point.normal_gradient.transpose()).norm(), 1e-12);
  EXPECT_LT((point.normal_gradient * point.normal).norm(), 1e-12);
  return true;
}

TEST(TriangulatedSurface, HasItsDerivativesOnEveryKindOfFeature) {
  const TriangulatedSurface surface = MakeSurface(DentedMesh(1));
  std::array<std::array<int, 3>, 2> checked = {};  // [inside] [face, edge, vertex]
  for (const Vector3d& x : RandomPoints(20000)) {
    const SurfacePoint point = surface.Closest(x);
    if (std::abs(point.gap) < 0.03) continue;  // the differences are of second order in step / distance
    if (ExpectDerivatives(surface, x)) ++checked[point.gap < 0.0][FeatureKind(point)];
  }
  for (const auto& side : checked) {
    for (const int count : side) EXPECT_GT(count, 50);
  }
}

// Where the faces at an edge or vertex lie in one plane, or all along one line, there is nothing to turn about.
TEST(TriangulatedSurface, FeaturesWithinAPlaneOrALineAreNone) {
  const TriangulatedSurface cube = MakeSurface(Split(CubeMesh(0.5)));
  for (const Vector3d& x : {Vector3d(0.1, 0.1, 0.75), Vector3d(0.1, -0.1, 0.75), Vector3d(0.0, 0.0, 0.75),
                            Vector3d(0.0, 0.3, 0.75), Vector3d(0.25, 0.25, 0.45)}) {
    const SurfacePoint point = cube.Closest(x);
    EXPECT_EQ(point.normal, Vector3d::UnitZ());
    EXPECT_TRUE(point.normal_gradient.isZero(0.0)) << x.transpose();
  }
  const double c = std::sqrt(0.5), distance = 0.1 / c;
  const SurfacePoint point = cube.Closest({0.6, 0.6, 0.0});  // beside the vertex in the middle of an edge
  const Vector3d across(c, -c, 0.0);
  EXPECT_NEAR(point.gap, distance, 1e-15);
  EXPECT_LT((point.normal - Vector3d(c, c, 0.0)).norm(), 1e-15);
  EXPECT_LT((point.normal_gradient - across * across.transpose() / distance).norm(), 1e-13);
}

TEST(TriangulatedSurface, HasThePseudonormalOnItsEdgesAndVertices) {
  const TriangulatedSurface cube = MakeSurface(CubeMesh(0.5));
  const auto expect = [&](const Vector3d& x, const Vector3d& direction) {
    for (const double scale : {1.0, 1.0 + 1e-14, 1.0 + 1e-13}) {
      const SurfacePoint point = cube.Closest(scale * x);
      EXPECT_NEAR(point.gap, 0.0, 1e-12);
      EXPECT_LT((point.normal - direction.normalized()).norm(), 1e-12) << x.transpose();
      EXPECT_TRUE(point.normal_gradient.isZero(0.0));
    }
  };
  expect({0.5, 0.5, 0.5}, {1.0, 1.0, 1.0});
  expect({-0.5, 0.5, -0.5}, {-1.0, 1.0, -1.0});
  expect({0.5, 0.1, 0.5}, {1.0, 0.0, 1.0});
  expect({0.0, 0.5, -0.5}, {0.0, 1.0, -1.0});
  expect({0.1, 0.2, 0.5}, {0.0, 0.0, 1.0});
}

void ExpectFinite(const SurfacePoint& point, const Vector3d& x) {
  EXPECT_TRUE(std::isfinite(point.gap)) << x.transpose();
  EXPECT_NEAR(point.normal.norm(), 1.0, 1e-15) << x.transpose();
  EXPECT_TRUE(point.normal_gradient.allFinite()) << x.transpose();
}

TEST(TriangulatedSurface, IsFiniteOnAroundAndFarFromEveryFeature) {
  const TriangleMesh mesh = DentedMesh(1);
  const TriangulatedSurface surface = MakeSurface(mesh);
  std::vector<Vector3d> points = {Vector3d::Zero(), Vector3d(1e100, 1.0, -1e100), Vector3d(1e200, -1e200, 0.0)};
  for (Eigen::Index face = 0; face < mesh.faces.cols(); ++face) {
    const std::array<Vector3d, 3> corners = Corners(mesh, face);
    points.insert(points.end(),
                  {corners[0], 0.5 * (corners[0] + corners[1]), (corners[0] + corners[1] + corners[2]) / 3.0});
  }
  for (const Vector3d& x : points) {
    for (const double distance : {0.0, 1e-300, 1e-17, 1e-13, 1e-11, 1e-8}) {
      for (const Vector3d& direction : {Vector3d(1.0, 0.0, 0.0), Vector3d(-0.3, 0.4, -0.5)}) {
        const Vector3d moved = x + distance * direction;
        ExpectFinite(surface.Closest(moved), moved);
      }
    }
  }
}

bool SameBits(const SurfacePoint& a, const SurfacePoint& b) {
  return a.gap == b.gap && a.normal == b.normal && a.normal_gradient == b.normal_gradient;
}

// Ties included: the middle of the cube is as far from all faces, its diagonals from three.
TEST(TriangulatedSurface, IsAFunctionOfThePositionAlone) {
  const TriangulatedSurface surface = MakeSurface(CubeMesh(0.5)), again = MakeSurface(CubeMesh(0.5));
  std::vector<Vector3d> points = RandomPoints(500);
  for (const double t : {0.0, 0.1, -0.2, 0.3, 0.5, 0.7}) {
    points.insert(points.end(), {{t, t, t}, {t, -t, t}, {t, t, 0.0}, {t, 0.0, 0.0}, {0.5, t, t}, {0.5, 0.5, t}});
  }
  std::vector<SurfacePoint> forwards(points.size()), backwards(points.size());
  std::thread other([&] {
    for (std::size_t i = points.size(); i-- > 0;) backwards[i] = surface.Closest(points[i]);
  });
  for (std::size_t i = 0; i < points.size(); ++i) forwards[i] = surface.Closest(points[i]);
  other.join();
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_TRUE(SameBits(forwards[i], backwards[i])) << points[i].transpose();
    EXPECT_TRUE(SameBits(forwards[i], again.Closest(points[i]))) << points[i].transpose();
  }
  EXPECT_EQ(surface.Closest(Vector3d::Zero()).normal, -Vector3d::UnitZ());  // of face 0, the first of the nearest
}

// Within a face nothing is smoothed: n jumps by the angle between the faces, the gap does not.
TEST(TriangulatedSurface, NormalsJumpFromFaceToFace) {
  const TriangulatedSurface surface = MakeSurface(IcosphereMesh(2, 0.5));
  double largest = 0.0, largest_gap = 0.0;
  SurfacePoint previous = surface.Closest({0.0, 0.01, 0.48});
  for (int i = 1; i <= 100000; ++i) {
    const double angle = 2e-5 * i;
    const SurfacePoint point = surface.Closest({0.48 * std::sin(angle), 0.01, 0.48 * std::cos(angle)});
    largest = std::max(largest, (point.normal - previous.normal).norm());
    largest_gap = std::max(largest_gap, std::abs(point.gap - previous.gap));
    previous = point;
  }
  EXPECT_GT(largest, 0.1);
  EXPECT_LT(largest_gap, 1e-5);
}

// A cloth larger than the cube: its middle lies on the top, the rest hangs over the edges.
TEST(TriangulatedSurface, AClothComesToRestOnACube) {
  constexpr double kHalf = 0.08, kThickness = 0.005;  // m
  GridOptions grid = SquareGrid(10, 0.3);
  grid.origin = Eigen::Vector3d(-0.15, -0.15, 0.1);
  Scene scene = ClothScene(grid, 0.01);
  scene.solver.step_tolerance = 1e-8;
  scene.material.bending_stiffness = 1e-5;
  scene.material.drag = 2.0;
  const TriangleMesh cube = CubeMesh(kHalf);
  scene.obstacles.push_back(
      {"cube", std::make_shared<TriangulatedSurface>(cube.vertices, cube.faces), 0.5, kThickness});
  const Rollout rollout = SimulateNominal(scene, 200);
  EXPECT_EQ(rollout.counts.failed_steps, 0);
  EXPECT_EQ(rollout.counts.substeps, 0);
  const StepRecord& last = rollout.records.back();
  EXPECT_LT(last.velocities.cwiseAbs().maxCoeff(), 1e-3);
  int num_hanging = 0;
  for (int node = 0; node < scene.mesh.num_nodes(); ++node) {
    const Vector3d x = last.positions.segment<3>(3 * node);
    EXPECT_GT(scene.obstacles[0].shape->Closest(x).gap, kThickness - 1e-6);
    num_hanging += x.z() < 0.5 * kHalf;
    if (x.head<2>().cwiseAbs().maxCoeff() < 0.5 * kHalf) {
      EXPECT_NEAR(x.z(), kHalf + kThickness, 1e-6);
    }
  }
  EXPECT_GT(num_hanging, 20);
}

TEST(TriangulatedSurface, RefusesWhatHasNoInside) {
  const auto expect = [](const TriangleMesh& mesh, std::initializer_list<const char*> fragments) {
    ExpectError([&] { MakeSurface(mesh); }, ErrorKind::kBadData, fragments);
  };
  const TriangleMesh cube = CubeMesh(0.5);
  TriangleMesh mesh = cube;
  mesh.faces.conservativeResize(3, 11);
  expect(mesh, {"triangulated surface: edge 1-5 belongs to one triangle only (4)", "closed"});
  mesh = cube;
  mesh.faces.row(0).swap(mesh.faces.row(1));
  expect(mesh, {"encloses no positive volume", "counter-clockwise"});
  mesh = cube;
  mesh.faces.col(3).reverseInPlace();
  expect(mesh, {"triangle 8 is inverted relative to triangle 3"});
  mesh = cube;
  mesh.faces(1, 4) = 8;
  expect(mesh, {"triangle 4", "expected 0 to 7"});
  mesh = cube;
  mesh.vertices(2, 6) = std::numeric_limits<double>::quiet_NaN();
  expect(mesh, {"node 6 is not finite"});
  mesh = cube;
  mesh.vertices.col(3) = mesh.vertices.col(2);
  expect(mesh, {"has no area"});
  expect({}, {"no triangle"});
  mesh.vertices = cube.vertices.leftCols<3>();  // a sheet of two sides
  mesh.faces.resize(3, 2);
  mesh.faces << 0, 0, 1, 2, 2, 1;
  expect(mesh, {"lie flat on each other"});
  mesh.faces = Eigen::Matrix3Xi::Zero(3, kMaxSurfaceFaces + 1);
  expect(mesh, {"100001 triangles; expected at most 100000"});
}

}  // namespace
}  // namespace clothid::triangulated_surface_test
