// Rotations and their derivatives, from no turn at all to large ones.
#include "costs/prediction/rigid_correction.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

namespace clothid::rigid_correction_test {
namespace {

const Eigen::Vector3d kShift(0.3, -0.2, 0.1), kCenter(1.0, 2.0, -0.5);
const Eigen::Vector3d kDirection = Eigen::Vector3d(1.0, -2.0, 0.5).normalized();
const double kAngles[] = {0.0, 1e-12, 1e-6, 9.99e-3, 1.001e-2, 0.3, 2.5};

Eigen::VectorXd SomePoints() {
  Eigen::VectorXd points(6);
  points << 0.4, 1.0, -2.0, 1.5, 0.2, 0.7;
  return points;
}

TEST(RigidCorrectionTest, TurnsAboutTheCenterAndShifts) {
  for (const double angle : kAngles) {
    const RigidCorrection correction(angle * kDirection, kShift, kCenter);
    const Eigen::Matrix3d rotation = Eigen::AngleAxisd(angle, kDirection).toRotationMatrix();
    EXPECT_LT((correction.rotation() - rotation).norm(), 1e-15) << angle;
    const Eigen::VectorXd points = SomePoints(), corrected = correction.Apply(points);
    for (int p = 0; p < 2; ++p) {
      const Eigen::Vector3d expected = rotation * (points.segment<3>(3 * p) - kCenter) + kCenter + kShift;
      EXPECT_LT((corrected.segment<3>(3 * p) - expected).norm(), 1e-14);
    }
    EXPECT_LT((correction.RotateBack(correction.Rotate(points)) - points).norm(), 1e-14);
  }
}

TEST(RigidCorrectionTest, DerivativesAreThoseOfDifferences) {
  const double step = 1e-5;
  for (const double angle : kAngles) {
    const Eigen::Vector3d turn = angle * kDirection;
    const RigidCorrection correction(turn, kShift, kCenter);
    const Eigen::VectorXd corrected = correction.Apply(SomePoints());
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d change = step * Eigen::Vector3d::Unit(axis);
      const Eigen::VectorXd above = RigidCorrection(turn + change, kShift, kCenter).Apply(SomePoints());
      const Eigen::VectorXd below = RigidCorrection(turn - change, kShift, kCenter).Apply(SomePoints());
      const Eigen::VectorXd difference = (above - below) / (2.0 * step);
      EXPECT_LT((correction.TurnDerivative(axis, corrected) - difference).norm(), 1e-9 * difference.norm())
          << angle << " axis " << axis;
    }
  }
}

}  // namespace
}  // namespace clothid::rigid_correction_test
