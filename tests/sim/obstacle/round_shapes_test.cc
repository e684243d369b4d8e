#include "sim/obstacle/round_shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "tests/expect_error.h"
#include "tests/sim/obstacle/region_checks.h"

namespace clothid::round_shapes_test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

const Vector3d kCenter(0.05, -0.1, 0.1), kAxis = Vector3d(0.3, -0.5, 0.8).normalized();
const double kInfinity = std::numeric_limits<double>::infinity();

struct ProfilePoint {
  double rho, height, outward_rho, outward_height;
};

// A curve beside the axis, over [0, 1].
using Profile = std::function<ProfilePoint(double u)>;

// Each profile turned about the axis, in two halves: on a whole turn a search would end at the seam.
std::vector<Patch> Revolved(const std::vector<Profile>& profiles) {
  std::vector<Patch> patches;
  for (const Profile& profile : profiles) {
    for (const double start : {0.0, M_PI}) {
      patches.push_back([profile, start](double u, double v) {
        const Vector3d x = kAxis.unitOrthogonal(), y = kAxis.cross(x);
        const Vector3d e = std::cos(start + M_PI * v) * x + std::sin(start + M_PI * v) * y;
        const ProfilePoint at = profile(u);
        return PatchPoint{kCenter + at.rho * e + at.height * kAxis, at.outward_rho * e + at.outward_height * kAxis};
      });
    }
  }
  return patches;
}

// A circular arc about (rho, height) from one angle to another, in rad from the direction away from the axis.
Profile Arc(double rho, double height, double radius, double from, double to, double side = 1.0) {
  return [=](double u) {
    const double angle = from + u * (to - from), c = std::cos(angle), s = std::sin(angle);
    return ProfilePoint{rho + radius * c, height + radius * s, side * c, side * s};
  };
}

double HeightOf(const Vector3d& x) { return kAxis.dot(x - kCenter); }
double RhoOf(const Vector3d& x) { return (x - kCenter - HeightOf(x) * kAxis).norm(); }
bool IsAnyBelow(double limit, const std::vector<double>& values) {
  for (const double value : values) {
    if (std::abs(value) < limit) return true;
  }
  return false;
}

constexpr double kRadius = 0.5, kHalfLength = 0.35;

Cylinder TestCylinder() { return Cylinder(kCenter - kHalfLength * kAxis, kCenter + kHalfLength * kAxis, kRadius); }

std::vector<Patch> CylinderSurface() {
  return Revolved({[](double u) {
                     return ProfilePoint{kRadius, kHalfLength * (2.0 * u - 1.0), 1.0, 0.0};
                   },
                   [](double u) {
                     return ProfilePoint{kRadius * u, kHalfLength, 0.0, 1.0};
                   },
                   [](double u) {
                     return ProfilePoint{kRadius * u, -kHalfLength, 0.0, -1.0};
                   }});
}

std::string RegionOfCylinder(const Vector3d& x) {
  const double side = RhoOf(x) - kRadius, end = std::abs(HeightOf(x)) - kHalfLength;
  if (IsAnyBelow(1e-3, {side, end, HeightOf(x)}) || RhoOf(x) < 0.15) return "";
  if (side > 0.0 && end > 0.0) return std::hypot(side, end) < 0.15 ? "" : "rim";
  if (side > 0.0) return "side";
  if (end > 0.0) return "end";
  if (std::abs(side - end) < 1e-3) return "";
  return side > end ? "inside the side" : "inside the end";
}

TEST(Cylinder, IsExactInEveryRegion) {
  ExpectExactInRegions(TestCylinder(), CylinderSurface(), RegionOfCylinder,
                       {"side", "end", "rim", "inside the side", "inside the end"});
}

TEST(Cylinder, HasTheCurvatureOfItsRim) {
  const Cylinder cylinder({0.0, 0.0, -1.0}, {0.0, 0.0, 0.0}, 0.5);
  const SurfacePoint point = cylinder.Closest({0.8, 0.0, 0.4});  // 0.5 m from the rim, along (0.6, 0, 0.8)
  EXPECT_NEAR(point.gap, 0.5, 1e-15);
  EXPECT_LT((point.normal - Vector3d(0.6, 0.0, 0.8)).norm(), 1e-15);
  Matrix3d expected;  // 1/0.5 across the rim, n_x/rho = 0.6/0.8 along it
  expected << 1.28, 0.0, -0.96, 0.0, 0.75, 0.0, -0.96, 0.0, 0.72;
  EXPECT_LT((point.normal_gradient - expected).norm(), 1e-14);
}

TEST(Cylinder, IsFiniteWhereNoDirectionIsNearest) {
  const Cylinder cylinder({0.0, 0.0, -1.0}, {0.0, 0.0, 1.0}, 0.5);
  const SurfacePoint middle = cylinder.Closest(Vector3d::Zero());
  ExpectFinite(middle);
  EXPECT_EQ(middle.gap, -0.5);
  EXPECT_EQ(middle.normal.z(), 0.0);
  EXPECT_TRUE(middle.normal_gradient.isZero(0.0));
  EXPECT_EQ(cylinder.Closest({0.0, 0.0, 0.8}).normal, Vector3d::UnitZ());
  EXPECT_LT((cylinder.Closest({0.25, 0.0, 0.75}).normal - Vector3d::UnitX()).norm(), 1e-15) << "as near to the end";
  const Cylinder flat({0.0, 0.0, -0.1}, {0.0, 0.0, 0.1}, 0.5);
  EXPECT_EQ(flat.Closest({0.1, 0.0, 0.0}).normal, Vector3d::UnitZ());
  for (const Vector3d& rim : {Vector3d(0.5, 0.0, 1.0), Vector3d(0.5 + 1e-15, 0.0, 1.0 + 1e-15)}) {
    ExpectFinite(cylinder.Closest(rim));
    EXPECT_NEAR(cylinder.Closest(rim).gap, 0.0, 2e-15);
    EXPECT_LT((cylinder.Closest(rim).normal - Vector3d::UnitX()).norm(), 1e-15);
  }
  ExpectFinite(TestCylinder().Closest({1e200, -1e200, 0.0}));
}

std::string RegionOfTorus(const Vector3d& x) {
  const double ring = std::hypot(RhoOf(x) - kRadius, HeightOf(x));
  if (RhoOf(x) < 0.15 || ring < 0.15) return "";
  return ring < 0.3 ? "inside" : RhoOf(x) < kRadius ? "hole" : "outside";
}

TEST(Torus, IsExactInEveryRegion) {
  ExpectExactInRegions(Torus(kCenter, 2.0 * kAxis, kRadius, 0.3),
                       Revolved({Arc(kRadius, 0.0, 0.3, -M_PI, 0.0), Arc(kRadius, 0.0, 0.3, 0.0, M_PI)}), RegionOfTorus,
                       {"inside", "hole", "outside"});
}

TEST(Torus, IsFiniteOnItsAxisAndItsRing) {
  const Torus torus(Vector3d::Zero(), Vector3d::UnitZ(), 0.4, 0.1);
  for (const double height : {-0.3, 0.0, 0.3}) {
    ExpectFinite(torus.Closest({0.0, 0.0, height}));
    ExpectFinite(torus.Closest({1e-14, -1e-300, height}));
    EXPECT_NEAR(torus.Closest({0.0, 0.0, height}).gap, std::hypot(0.4, height) - 0.1, 1e-15);
  }
  const SurfacePoint on_ring = torus.Closest({0.0, 0.4, 0.0});
  ExpectFinite(on_ring);
  EXPECT_EQ(on_ring.gap, -0.1);
  EXPECT_LT((on_ring.normal - Vector3d::UnitY()).norm(), 1e-15);
  EXPECT_TRUE(on_ring.normal_gradient.isZero(0.0));
  ExpectFinite(torus.Closest({1e200, -1e200, 0.0}));
}

constexpr double kThickness = 0.06, kMiddleRadius = kRadius + 0.5 * kThickness;

// The arcs of the inside and the outside from the bottom to the rim, and the rim's.
std::vector<Patch> BowlSurface(double angle) {
  const double rim = angle - M_PI_2;  // in rad from the direction away from the axis
  return Revolved(
      {Arc(0.0, 0.0, kRadius, -M_PI_2, rim, -1.0), Arc(0.0, 0.0, kRadius + kThickness, -M_PI_2, rim),
       Arc(kMiddleRadius * std::cos(rim), kMiddleRadius * std::sin(rim), 0.5 * kThickness, rim, rim + M_PI)});
}

std::string RegionOfBowl(const Vector3d& x, double angle) {
  const double own = std::atan2(RhoOf(x), -HeightOf(x)), r = (x - kCenter).norm();
  const double from_rim =
      std::hypot(RhoOf(x) - kMiddleRadius * std::sin(angle), HeightOf(x) + kMiddleRadius * std::cos(angle));
  if (std::abs(own - angle) < 1e-3 || r < 0.15) return "";
  if (own > angle) return from_rim < 0.15 || RhoOf(x) < 0.15 ? "" : "rim";
  if (std::abs(r - kMiddleRadius) < 1e-3) return "";
  if (std::abs(r - kMiddleRadius) < 0.5 * kThickness) return r < kMiddleRadius ? "inner half" : "outer half";
  return r < kMiddleRadius ? "in the bowl" : "under the bowl";
}

TEST(Bowl, IsExactInEveryRegion) {
  for (const double angle : {1.0, M_PI_2, 2.2}) {
    ExpectExactInRegions(Bowl(kCenter, kAxis, kRadius, angle, kThickness), BowlSurface(angle),
                         [angle](const Vector3d& x) { return RegionOfBowl(x, angle); },
                         {"rim", "inner half", "outer half", "in the bowl", "under the bowl"});
  }
}

TEST(Bowl, IsASphereFromInsideAndOutside) {
  const Bowl bowl(kCenter, kAxis, kRadius, M_PI_2, kThickness);
  const Sphere inner(kCenter, kRadius), outer(kCenter, kRadius + kThickness);
  for (const double r : {0.2, 0.49, 0.57, 0.9}) {
    const Vector3d x = kCenter + r * (Vector3d(0.3, 0.2, 0.4).normalized() - 1.2 * kAxis).normalized();
    const SurfacePoint point = bowl.Closest(x), expected = (r < kMiddleRadius ? inner : outer).Closest(x);
    const double side = r < kMiddleRadius ? -1.0 : 1.0;
    EXPECT_NEAR(point.gap, side * expected.gap, 1e-15);
    EXPECT_LT((point.normal - side * expected.normal).norm(), 1e-14);
    EXPECT_LT((point.normal_gradient - side * expected.normal_gradient).norm(), 1e-13);
  }
}

TEST(Bowl, IsFiniteOnItsMedialSet) {
  const Bowl bowl(Vector3d::Zero(), Vector3d::UnitZ(), 0.5, M_PI_2, 0.1);
  const SurfacePoint center = bowl.Closest(Vector3d::Zero());
  ExpectFinite(center);
  EXPECT_NEAR(center.gap, 0.5, 1e-15);
  EXPECT_EQ(center.normal, Vector3d::UnitZ());
  ExpectFinite(bowl.Closest({0.0, 0.0, 0.3}));
  EXPECT_NEAR(bowl.Closest({0.0, 0.0, 0.3}).gap, std::hypot(0.55, 0.3) - 0.05, 1e-15);
  EXPECT_EQ(bowl.Closest({0.0, 0.0, -0.55}).normal, -Vector3d::UnitZ()) << "out of the bowl";
  for (const Vector3d& on_rim : {Vector3d(0.55, 0.0, 0.0), Vector3d(0.55, 0.0, 1e-15), Vector3d(0.55, 0.0, -1e-15)}) {
    ExpectFinite(bowl.Closest(on_rim));
    EXPECT_NEAR(bowl.Closest(on_rim).gap, -0.05, 3e-15);
  }
  ExpectFinite(bowl.Closest({1e200, -1e200, 1e200}));
  ExpectFinite(bowl.Closest({1e200, -1e200, -1e200}));
}

TEST(RoundShapes, MoveWithTheirNumbers) {
  const Matrix3d rotation = Eigen::Quaterniond(0.1, 0.7, 0.2, -0.5).normalized().toRotationMatrix();
  const Vector3d shift(0.3, -2.0, 1.0), center = rotation * kCenter + shift, axis = rotation * kAxis;
  ExpectMoved(TestCylinder(), Cylinder(center - kHalfLength * axis, center + kHalfLength * axis, kRadius), rotation,
              shift);
  ExpectMoved(Torus(kCenter, kAxis, 0.5, 0.3), Torus(center, axis, 0.5, 0.3), rotation, shift);
  ExpectMoved(Bowl(kCenter, kAxis, 0.5, 2.0, 0.1), Bowl(center, axis, 0.5, 2.0, 0.1), rotation, shift);
}

TEST(RoundShapes, RefuseShapesThatAreNone) {
  const Vector3d zero = Vector3d::Zero(), up = Vector3d::UnitZ();
  const auto expect = [](const char* word, const auto& make) { ExpectError(make, ErrorKind::kBadData, {word}); };
  expect("ends", [&] { Cylinder(up, up, 1.0); });
  expect("position", [&] { Cylinder(kInfinity * up, up, 1.0); });
  expect("radius", [&] { Cylinder(zero, up, 0.0); });
  expect("axis", [&] { Torus(zero, zero, 1.0, 0.1); });
  expect("radius", [&] { Torus(zero, up, -1.0, 0.1); });
  expect("tube_radius", [&] { Torus(zero, up, 1.0, 0.0); });
  expect("tube_radius", [&] { Torus(zero, up, 1.0, 1.0); });
  expect("axis", [&] { Bowl(zero, kInfinity * up, 1.0, 1.0, 0.1); });
  expect("radius", [&] { Bowl(zero, up, 0.0, 1.0, 0.1); });
  expect("thickness", [&] { Bowl(zero, up, 1.0, 1.0, 0.0); });
  expect("angle", [&] { Bowl(zero, up, 1.0, 0.0, 0.1); });
  expect("angle", [&] { Bowl(zero, up, 1.0, M_PI, 0.1); });
  expect("angle", [&] { Bowl(zero, up, 1.0, kInfinity, 0.1); });
  expect("opening", [&] { Bowl(zero, up, 1.0, 3.1, 0.1); });
}

}  // namespace
}  // namespace clothid::round_shapes_test
