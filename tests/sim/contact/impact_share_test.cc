// The part of an impulse that stops an impact: what it is where its meaning is clear, continuity, and its derivative
// against central differences.
#include "sim/contact/impact_share.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

namespace clothid::impact_share_test {
namespace {

constexpr double kMass = 0.003;
constexpr double kFriction = 0.4;

const Eigen::Vector3d kNormal = Eigen::Vector3d(0.3, -0.2, 0.9).normalized();

// A contact that pushes with r_N = `normal_impulse` and drags sideways.
Contact PushingContact(double normal_impulse, ContactBranch branch) {
  const Eigen::Vector3d tangent = kNormal.cross(Eigen::Vector3d(0.1, 1.0, 0.2)).normalized();
  const double drag = (branch == ContactBranch::kStick ? 0.5 : 2.0) * kFriction * normal_impulse;
  Contact contact;
  contact.candidate.normal = kNormal;
  contact.force = -normal_impulse * kNormal + drag * tangent;
  contact.response = EvaluateContactLaw(contact.force, kNormal, kFriction);
  EXPECT_EQ(contact.response.branch, branch);
  return contact;
}

TEST(ImpactShareTest, ANodeThatRestsHasNone) {
  const Contact contact = PushingContact(1e-4, ContactBranch::kSlip);
  const Eigen::Vector3d along = kNormal.unitOrthogonal();
  EXPECT_NEAR(ImpactShare(contact, kMass, 0.1 * along), 0.0, 1e-15);
  EXPECT_EQ(ImpactShare(contact, kMass, 0.1 * along - 1e-3 * kNormal), 0.0);  // about a convex surface
  EXPECT_EQ(ImpactVelocity(contact, kMass, 0.1 * along - 1e-3 * kNormal), Eigen::Vector3d::Zero());
}

TEST(ImpactShareTest, AnImpactWithoutOtherForcesIsAllOfIt) {
  for (const ContactBranch branch : {ContactBranch::kStick, ContactBranch::kSlip}) {
    const Contact contact = PushingContact(1e-4, branch);
    const Eigen::Vector3d change = contact.response.impulse / kMass;
    EXPECT_NEAR(ImpactShare(contact, kMass, change), 1.0, 1e-14);
    EXPECT_LE((ImpactVelocity(contact, kMass, change) - change).norm(), 1e-14 * change.norm());
  }
}

// With gravity that presses on, what stops the node is the change of its normal velocity, with friction in proportion.
TEST(ImpactShareTest, TakesTheNormalChangeAndItsFriction) {
  const Contact contact = PushingContact(1e-4, ContactBranch::kSlip);
  const Eigen::Vector3d change = (contact.response.impulse - 0.3e-4 * kNormal) / kMass;
  const Eigen::Vector3d stopped = ImpactVelocity(contact, kMass, change);
  EXPECT_NEAR(ImpactShare(contact, kMass, change), 0.7, 1e-14);
  EXPECT_NEAR(kNormal.dot(stopped), kNormal.dot(change), 1e-15);
  EXPECT_LE((stopped - 0.7 * contact.response.impulse / kMass).norm(), 1e-15);
}

TEST(ImpactShareTest, IsContinuousBetweenItsBranches) {
  const Contact contact = PushingContact(1e-4, ContactBranch::kSlip);
  const auto at = [&](double share) {
    const Eigen::Vector3d change = share * 1e-4 / kMass * kNormal;
    return ImpactVelocity(contact, kMass, change);
  };
  for (const double branch_change : {0.0, 1.0}) {
    EXPECT_LE((at(branch_change + 1e-9) - at(branch_change - 1e-9)).norm(), 1e-8 * at(1.0).norm());
  }
  EXPECT_EQ(at(1.5), at(2.0));
}

class ImpactDerivativeTest : public ::testing::TestWithParam<double> {};

// u by the change of velocity, the impulse, the position (through the normal of a ball) and the mass.
TEST_P(ImpactDerivativeTest, IsTheDifference) {
  constexpr double kRadius = 0.2;
  const Eigen::Vector3d impulse = PushingContact(1e-4, ContactBranch::kSlip).response.impulse;
  const Eigen::Vector3d change = GetParam() * 1e-4 / kMass * kNormal + Eigen::Vector3d(0.01, -0.02, 0.0);
  const Eigen::Vector3d d_change(0.3, 0.5, -0.4), d_impulse(2e-3, -1e-3, 3e-3), d_position(0.02, 0.01, -0.03);
  constexpr double kMassRate = 1e-3;
  // Along a line in all four; the law's normal force is that of the impulse.
  const auto contact_at = [&](double s) {
    Contact contact;
    const Eigen::Vector3d offset = kRadius * kNormal + s * d_position;
    contact.candidate.normal = offset.normalized();
    contact.candidate.normal_gradient =
        (Eigen::Matrix3d::Identity() - contact.candidate.normal * contact.candidate.normal.transpose()) / offset.norm();
    contact.response.branch = ContactBranch::kSlip;
    contact.response.impulse = impulse + s * d_impulse;
    contact.response.normal_force = -contact.candidate.normal.dot(contact.response.impulse);
    return contact;
  };
  const auto velocity_at = [&](double s) {
    return ImpactVelocity(contact_at(s), kMass + s * kMassRate, change + s * d_change);
  };
  const ObstacleImpactDerivative derivative = DifferentiateImpact(contact_at(0.0), kMass, change);
  const Eigen::Vector3d actual = derivative.change * d_change + derivative.impulse * d_impulse +
                                 derivative.position * d_position + derivative.masses * kMassRate;
  const Eigen::Vector3d expected = (velocity_at(1e-6) - velocity_at(-1e-6)) / 2e-6;
  EXPECT_LE((actual - expected).norm(), 1e-7 * expected.norm());
  EXPECT_EQ(expected.norm() > 0.0, GetParam() > 0.0);
}

INSTANTIATE_TEST_SUITE_P(Shares, ImpactDerivativeTest, ::testing::Values(-0.5, 0.4, 1.7));

}  // namespace
}  // namespace clothid::impact_share_test
