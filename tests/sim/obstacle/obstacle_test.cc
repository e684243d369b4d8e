#include "sim/obstacle/obstacle.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/expect_error.h"
#include "tests/sim/obstacle/surface_checks.h"

namespace clothid::obstacle_test {
namespace {

using Eigen::Vector3d;

TEST(Plane, HasItsDerivatives) {
  const Plane plane({0.1, -0.2, 0.3}, {1.0, 2.0, 3.0});
  RandomPoints points;
  for (int i = 0; i < 20; ++i) ExpectDerivatives(plane, points.Next());
}

TEST(Plane, MeasuresAlongItsNormalisedNormal) {
  const Plane plane({0.0, 0.0, 1.0}, {0.0, 0.0, 10.0});
  EXPECT_DOUBLE_EQ(plane.Closest({5.0, 6.0, 3.0}).gap, 2.0);
  EXPECT_DOUBLE_EQ(plane.Closest({5.0, 6.0, 0.0}).gap, -1.0);
}

TEST(Sphere, HasItsDerivativesInsideAndOutside) {
  const Sphere sphere({0.1, -0.2, 0.3}, 0.7);
  RandomPoints points;
  int num_inside = 0;
  for (int i = 0; i < 40; ++i) {
    const Vector3d x = points.Next();
    if ((x - Vector3d(0.1, -0.2, 0.3)).norm() < 0.1) continue;
    num_inside += sphere.Closest(x).gap < 0.0;
    ExpectDerivatives(sphere, x);
  }
  EXPECT_GT(num_inside, 0);
  EXPECT_LT(num_inside, 40);
}

TEST(Sphere, IsFiniteAtItsCentre) {
  const Sphere sphere({0.1, -0.2, 0.3}, 0.7);
  ExpectFinite(sphere.Closest({0.1, -0.2, 0.3}));
  ExpectFinite(sphere.Closest({0.1, -0.2, 0.3 + 1e-17}));
  ExpectFinite(sphere.Closest({1e200, -1e200, 0.0}));
  EXPECT_DOUBLE_EQ(sphere.Closest({0.1, -0.2, 0.3}).gap, -0.7);
}

TEST(Capsule, HasItsDerivativesOnCapsAndCylinder) {
  const Vector3d from(-0.3, 0.1, 0.0), to(0.4, 0.2, 0.1);
  const Capsule capsule(from, to, 0.2);
  const Vector3d axis = (to - from).normalized();
  RandomPoints points;
  int on_cylinder = 0, on_caps = 0;
  for (int i = 0; i < 80; ++i) {
    const Vector3d x = points.Next();
    const double along = axis.dot(x - from), length = (to - from).norm();
    const bool at_seam = std::abs(along) < 2.0 * kDifferenceStep || std::abs(along - length) < 2.0 * kDifferenceStep;
    if (at_seam || capsule.Closest(x).gap < -0.15) continue;
    (along > 0.0 && along < length ? on_cylinder : on_caps) += 1;
    ExpectDerivatives(capsule, x);
  }
  EXPECT_GT(on_cylinder, 10);
  EXPECT_GT(on_caps, 10);
}

TEST(Capsule, MeasuresFromItsSegment) {
  const Capsule capsule({0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, 0.25);
  EXPECT_DOUBLE_EQ(capsule.Closest({0.5, 0.0, 1.0}).gap, 0.75);
  EXPECT_DOUBLE_EQ(capsule.Closest({3.0, 0.0, 0.0}).gap, 1.75);
  EXPECT_DOUBLE_EQ(capsule.Closest({-1.0, 0.0, 0.0}).gap, 0.75);
}

TEST(Capsule, IsFiniteOnItsAxis) {
  const Capsule capsule({0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, 0.25);
  for (const double along : {0.0, 0.5, 1.0}) {
    const SurfacePoint point = capsule.Closest({along, 0.0, 0.0});
    ExpectFinite(point);
    EXPECT_DOUBLE_EQ(point.gap, -0.25);
    EXPECT_DOUBLE_EQ(point.normal.x(), 0.0);
  }
}

TEST(Obstacles, RefuseShapesThatAreNone) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Vector3d zero = Vector3d::Zero(), one = Vector3d::Ones();
  const auto expect = [](const auto& make) { ExpectError(make, ErrorKind::kBadData, {}); };
  expect([&] { Plane(zero, zero); });
  expect([&] { Plane(zero, nan * one); });
  expect([&] { Sphere(zero, 0.0); });
  expect([&] { Sphere(zero, nan); });
  expect([&] { Sphere(nan * one, 1.0); });
  expect([&] { Capsule(one, one, 1.0); });
  expect([&] { Capsule(zero, one, -1.0); });
}

}  // namespace
}  // namespace clothid::obstacle_test
