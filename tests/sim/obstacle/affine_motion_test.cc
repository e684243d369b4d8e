// Obstacles that move: the surface where they are, and what a change of their motion does.
#include "sim/obstacle/affine_motion.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "sim/path/rotation_vector.h"

namespace clothid {
namespace {

const Eigen::Vector3d kPlace(0.31, -0.12, 0.27);

// A body that is turned and a little sheared, as a second stage has it, and moves.
SolveMaps Maps() {
  SolveMaps maps;
  maps.start.leftCols<3>() = ExponentialOf({0.4, -0.7, 0.2}).toRotationMatrix();
  maps.start.leftCols<3>() *= 1.01;
  maps.start(0, 1) += 0.03;
  maps.start.col(3) << 0.05, 0.02, -0.04;
  maps.velocity << 0.3, -1.0, 0.5, 0.7, 1.1, 0.2, -0.4, -0.3, -0.6, 0.3, 0.1, 0.9;
  maps.velocity_change << 0.1, 0.2, -0.1, 0.3, 0.05, -0.2, 0.4, 0.1, 0.2, 0.1, -0.3, 0.2;
  return maps;
}

const Capsule& Shape() {
  static const Capsule shape({-0.1, 0.05, 0.0}, {0.15, -0.02, 0.08}, 0.06);
  return shape;
}

TEST(AffineMotionTest, APoseTakesTheSurfaceAlong) {
  SolveMaps maps;
  maps.start.leftCols<3>() = ExponentialOf({0.4, -0.7, 0.2}).toRotationMatrix();
  maps.start.col(3) << 0.05, 0.02, -0.04;
  const MovedSurfacePoint moved = AffineMotion(maps).Closest(Shape(), kPlace);
  const Capsule there(Apply(maps.start, Shape().from()), Apply(maps.start, Shape().to()), Shape().radius());
  const SurfacePoint expected = there.Closest(kPlace);
  EXPECT_NEAR(moved.surface.gap, expected.gap, 1e-15);
  EXPECT_NEAR(moved.slope, 1.0, 1e-15);
  EXPECT_LE((moved.surface.normal - expected.normal).norm(), 1e-14);
  EXPECT_LE((moved.surface.normal_gradient - expected.normal_gradient).norm(), 1e-13);
}

TEST(AffineMotionTest, NormalAndItsGradientAreDerivatives) {
  const AffineMotion motion(Maps());
  const MovedSurfacePoint point = motion.Closest(Shape(), kPlace);
  constexpr double kStep = 1e-6;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d shift = kStep * Eigen::Vector3d::Unit(axis);
    const MovedSurfacePoint plus = motion.Closest(Shape(), kPlace + shift),
                            minus = motion.Closest(Shape(), kPlace - shift);
    EXPECT_NEAR((plus.surface.gap - minus.surface.gap) / (2.0 * kStep), point.slope * point.surface.normal[axis], 1e-9);
    const Eigen::Vector3d difference = (plus.surface.normal - minus.surface.normal) / (2.0 * kStep);
    EXPECT_LE((difference - point.surface.normal_gradient.col(axis)).norm(), 1e-8);
    const Eigen::Vector3d by_velocity =
        (motion.velocity().At(kPlace + shift) - motion.velocity().At(kPlace - shift)) / (2.0 * kStep);
    EXPECT_LE((by_velocity - motion.velocity().gradient.col(axis)).norm(), 1e-9);
  }
}

// V is the velocity map at the body's point that is there.
TEST(AffineMotionTest, MovesItsMaterialPoint) {
  const SolveMaps maps = Maps();
  const Eigen::Vector3d point(0.2, -0.1, 0.3);
  const AffineMotion motion(maps);
  EXPECT_LE((motion.velocity().At(Apply(maps.start, point)) - Apply(maps.velocity, point)).norm(), 1e-14);
  EXPECT_LE((motion.velocity_change().At(Apply(maps.start, point)) - Apply(maps.velocity_change, point)).norm(), 1e-14);
}

TEST(AffineMotionTest, ChangesOfTheMapsAreDerivatives) {
  SolveMaps change;
  change.start << 0.2, -0.1, 0.4, 0.3, 0.5, 0.1, -0.2, -0.6, 0.3, 0.2, -0.4, 0.1;
  change.velocity = 2.0 * change.start.rowwise().reverse();
  change.velocity_change = -change.start;
  const auto motion_at = [&](double amount) {
    SolveMaps maps = Maps();
    maps.start += amount * change.start;
    maps.velocity += amount * change.velocity;
    maps.velocity_change += amount * change.velocity_change;
    return AffineMotion(maps);
  };
  const AffineMotion motion = motion_at(0.0);
  const SurfacePoint surface = motion.Closest(Shape(), kPlace).surface;
  const MotionChange result = motion.Differentiate(change, kPlace, surface.normal, surface.normal_gradient);
  constexpr double kStep = 1e-6;
  const AffineMotion plus = motion_at(kStep), minus = motion_at(-kStep);
  const MovedSurfacePoint at_plus = plus.Closest(Shape(), kPlace), at_minus = minus.Closest(Shape(), kPlace);
  const auto slope = [](const auto& a, const auto& b) { return (a - b) / (2.0 * kStep); };
  EXPECT_NEAR(slope(at_plus.surface.gap, at_minus.surface.gap), motion.Closest(Shape(), kPlace).slope * result.distance,
              1e-9);
  EXPECT_LE((slope(at_plus.surface.normal, at_minus.surface.normal) - result.normal).norm(), 1e-8);
  EXPECT_LE((slope(plus.velocity().At(kPlace), minus.velocity().At(kPlace)) - result.velocity).norm(), 1e-8);
  EXPECT_LE(
      (slope(plus.velocity_change().At(kPlace), minus.velocity_change().At(kPlace)) - result.velocity_change).norm(),
      1e-8);
}

}  // namespace
}  // namespace clothid
