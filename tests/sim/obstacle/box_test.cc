#include "sim/obstacle/box.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "sim/obstacle/triangulated_surface.h"
#include "tests/expect_error.h"
#include "tests/sim/obstacle/region_checks.h"
#include "tests/sim/scene/triangle_meshes.h"

namespace clothid::box_test {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

const Vector3d kCenter(0.05, -0.1, 0.1), kSize(0.9, 0.6, 0.7);
const Quaterniond kRotation = Quaterniond(0.8, 0.3, -0.4, 0.2).normalized();

// Faces, edges and corners by the signs of their directions: one of them is not 0, two, or three.
Patch BoxPatch(const Eigen::Vector3i& signs, double radius) {
  return [signs, radius](double u, double v) {
    const Vector3d core = 0.5 * kSize - Vector3d::Constant(radius);
    Vector3d x, outward = Vector3d::Zero();
    double angles[] = {u, v};
    int next = 0;
    double rest = 1.0;  // of the direction's length
    const int num_round = static_cast<int>(signs.cwiseAbs().sum());
    for (int k = 0, round = 0; k < 3; ++k) {
      if (signs[k] == 0) {
        x[k] = core[k] * (2.0 * angles[1 - next++] - 1.0);
        continue;
      }
      x[k] = core[k] * signs[k];
      const double angle = ++round == num_round ? 0.0 : M_PI_2 * angles[round - 1];
      outward[k] = signs[k] * rest * std::cos(angle);
      rest *= std::sin(angle);
    }
    return PatchPoint{kCenter + kRotation * (x + radius * outward), kRotation * outward};
  };
}

std::vector<Patch> BoxSurface(double radius) {
  std::vector<Patch> patches;
  for (int i = 0; i < 27; ++i) {
    const Eigen::Vector3i signs(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    const bool is_face = signs.cwiseAbs().sum() == 1;
    if (is_face || (radius > 0.0 && !signs.isZero())) patches.push_back(BoxPatch(signs, radius));
  }
  return patches;
}

// By how many of the distances beyond the core's faces are positive.
std::string RegionOfBox(const Vector3d& x, double radius) {
  Vector3d beyond = (kRotation.conjugate() * (x - kCenter)).cwiseAbs() - 0.5 * kSize + Vector3d::Constant(radius);
  if (beyond.cwiseAbs().minCoeff() < 1e-3) return "";
  const int num_beyond = static_cast<int>((beyond.array() > 0.0).count());
  if (num_beyond > 0 && beyond.cwiseMax(0.0).norm() < 0.15) return "";
  std::sort(beyond.data(), beyond.data() + 3);
  if (num_beyond == 0) return beyond[2] - beyond[1] < 1e-3 ? "" : "inside";
  return num_beyond == 1 ? "face" : num_beyond == 2 ? "edge" : "corner";
}

TEST(Box, IsExactInEveryRegion) {
  for (const double radius : {0.0, 0.15}) {
    ExpectExactInRegions(Box(kCenter, kSize, kRotation, radius), BoxSurface(radius),
                         [radius](const Vector3d& x) { return RegionOfBox(x, radius); },
                         {"inside", "face", "edge", "corner"});
  }
}

// Within 0.15 m of the core, where only points of a round edge lie.
TEST(Box, IsExactWithinItsRoundEdges) {
  const Box box(kCenter, kSize, kRotation, 0.2);
  const std::vector<Patch> surface = BoxSurface(0.2);
  const Vector3d corner = kCenter + kRotation * (0.5 * kSize - Vector3d::Constant(0.2));
  for (const Vector3d& offset : {Vector3d(0.1, 0.1, 0.05), Vector3d(0.1, 0.1, -0.02), Vector3d(0.1, -0.02, -0.02)}) {
    const Vector3d x = corner + kRotation * offset;
    EXPECT_LT(box.Closest(x).gap, 0.0);
    EXPECT_NEAR(box.Closest(x).gap, ClosestOnPatches(surface, x).gap, 1e-9);
    EXPECT_NEAR(box.Closest(x).gap, offset.cwiseMax(0.0).norm() - 0.2, 1e-15);
    ExpectFinite(box.Closest(x));
    const SurfaceDifferences differences = CentralDifferences(box, x);
    EXPECT_LT((box.Closest(x).normal_gradient - differences.normal_gradient).norm(), 1e-5);
  }
}

TEST(Box, IsTheTriangulatedCube) {
  const TriangleMesh cube = CubeMesh(0.4);
  const TriangulatedSurface surface(cube.vertices, cube.faces);
  const Box box(Vector3d::Zero(), Vector3d::Constant(0.8));
  RandomPoints points;
  for (int i = 0; i < 200; ++i) {
    const Vector3d x = points.Next();
    const SurfacePoint one = box.Closest(x), other = surface.Closest(x);
    EXPECT_NEAR(one.gap, other.gap, 1e-15);
    EXPECT_LT((one.normal - other.normal).norm(), 1e-13);
    EXPECT_LT((one.normal_gradient - other.normal_gradient).norm(), 1e-11);
  }
}

TEST(Box, OfRoundEdgesAloneIsASphereOrACapsule) {
  const Box ball(kCenter, Vector3d::Constant(0.8), kRotation, 0.4), rod(kCenter, {0.8, 0.8, 1.2}, kRotation, 0.4);
  const Sphere sphere(kCenter, 0.4);
  const Capsule capsule(kCenter - kRotation * Vector3d(0, 0, 0.2), kCenter + kRotation * Vector3d(0, 0, 0.2), 0.4);
  RandomPoints points;
  for (int i = 0; i < 100; ++i) {
    const Vector3d x = points.Next();
    EXPECT_NEAR(ball.Closest(x).gap, sphere.Closest(x).gap, 1e-15);
    EXPECT_NEAR(rod.Closest(x).gap, capsule.Closest(x).gap, 1e-15);
    EXPECT_LT((rod.Closest(x).normal - capsule.Closest(x).normal).norm(), 1e-13);
  }
}

TEST(Box, MovesWithItsCentreAndRotation) {
  const Matrix3d rotation = Quaterniond(0.1, 0.7, 0.2, -0.5).normalized().toRotationMatrix();
  const Vector3d shift(0.3, -2.0, 1.0);
  for (const double radius : {0.0, 0.1}) {
    ExpectMoved(Box(kCenter, kSize, kRotation, radius),
                Box(rotation * kCenter + shift, kSize, Quaterniond(rotation) * kRotation, radius), rotation, shift);
  }
}

TEST(Box, HasTheFirstOfTheNearestFacesOnItsMedialSet) {
  const Box box(Vector3d::Zero(), Vector3d::Constant(2.0));
  EXPECT_EQ(box.Closest(Vector3d::Zero()).gap, -1.0);
  EXPECT_EQ(box.Closest(Vector3d::Zero()).normal, Vector3d::UnitX());
  EXPECT_EQ(box.Closest({-0.5, 0.5, 0.0}).normal, -Vector3d::UnitX());
  EXPECT_TRUE(box.Closest({-0.5, 0.5, 0.0}).normal_gradient.isZero(0.0));
  for (const Vector3d& edge : {Vector3d(1.0, 1.0, 0.3), Vector3d(1.0, -1.0, 1.0), Vector3d(1.0 + 1e-15, 1.0, 0.0)}) {
    ExpectFinite(box.Closest(edge));
    EXPECT_NEAR(box.Closest(edge).gap, 0.0, 2e-15);
    EXPECT_EQ(box.Closest(edge).normal, Vector3d::UnitX());
    EXPECT_TRUE(box.Closest(edge).normal_gradient.isZero(0.0));
  }
  ExpectFinite(Box(kCenter, kSize, kRotation, 0.3).Closest(kCenter));
  ExpectFinite(Box(kCenter, kSize, kRotation, 0.3).Closest({1e200, -1e200, 1e150}));
}

TEST(Table, IsABoxUnderItsTop) {
  const Vector3d top(0.1, 0.2, 0.5), normal(0.0, 0.6, 0.8), along(1.0, 5.0, 0.0);
  const Box table = Box::Table(top, 3.0 * normal, along, {1.0, 0.5}, 0.04, 0.02);
  const Vector3d side = (along - normal.dot(along) * normal).normalized(), across = normal.cross(side);
  EXPECT_NEAR(table.Closest(top + 0.3 * normal + 0.4 * side - 0.2 * across).gap, 0.3, 1e-15);
  EXPECT_NEAR(table.Closest(top - 0.02 * normal + 0.7 * side).gap, 0.2, 1e-15);
  EXPECT_NEAR(table.Closest(top - 0.02 * normal - 0.55 * across).gap, 0.3, 1e-15);
  EXPECT_NEAR(table.Closest(top - 0.14 * normal).gap, 0.1, 1e-15);
  EXPECT_LT((table.Closest(top).normal - normal).norm(), 1e-15);
  const Vector3d over_edge = top + 0.48 * side + 0.28 * normal + 0.4 * side;  // (0.4, 0.3) from the edge's centre
  EXPECT_NEAR(table.Closest(over_edge).gap, 0.5 - 0.02, 1e-15);
  EXPECT_LT((table.Closest(over_edge).normal - (0.8 * side + 0.6 * normal)).norm(), 1e-14);
}

TEST(Box, RefusesShapesThatAreNone) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Vector3d zero = Vector3d::Zero(), one = Vector3d::Ones();
  const Quaterniond same = Quaterniond::Identity();
  const auto expect = [](const char* word, const auto& make) { ExpectError(make, ErrorKind::kBadData, {word}); };
  expect("lengths", [&] { Box(zero, {1.0, 0.0, 1.0}); });
  expect("lengths", [&] { Box(zero, nan * one); });
  expect("position", [&] { Box(nan * one, one); });
  expect("rotation", [&] { Box(zero, one, Quaterniond(0, 0, 0, 0)); });
  expect("rotation", [&] { Box(zero, one, Quaterniond(nan, 0, 0, 0)); });
  expect("radius", [&] { Box(zero, one, same, -0.1); });
  expect("radius", [&] { Box(zero, {1.0, 2.0, 3.0}, same, 0.51); });
  expect("radius", [&] { Box(zero, one, same, nan); });
  const Vector3d up = Vector3d::UnitZ(), x = Vector3d::UnitX();
  expect("normal", [&] { Box::Table(zero, zero, x, {1.0, 1.0}, 0.1, 0.0); });
  expect("sides", [&] { Box::Table(zero, up, zero, {1.0, 1.0}, 0.1, 0.0); });
  expect("sides", [&] { Box::Table(zero, up, 2.0 * up, {1.0, 1.0}, 0.1, 0.0); });
  expect("lengths", [&] { Box::Table(zero, up, x, {1.0, 1.0}, 0.0, 0.0); });
  expect("radius", [&] { Box::Table(zero, up, x, {1.0, 1.0}, 0.1, 0.06); });
}

}  // namespace
}  // namespace clothid::box_test
