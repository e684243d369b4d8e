// The closed form of the contact law against its definition, and its derivatives against differences.
#include "sim/contact/contact_law.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>

namespace clothid::contact_law_test {
namespace {

class ContactLawTest : public ::testing::Test {
 protected:
  Eigen::Vector3d RandomVector() {
    std::normal_distribution<double> normal;
    return {normal(generator_), normal(generator_), normal(generator_)};
  }

  std::mt19937_64 generator_{7};
};

// (r, u) with u = (F + r)/d from F = d u - r: the set C of Eq. (8).
TEST_F(ContactLawTest, FulfilsComplementarityAndTheFrictionCone) {
  int branches[3] = {0, 0, 0};
  for (int i = 0; i < 3000; ++i) {
    const double mu = (i % 4) * 0.3;
    const Eigen::Vector3d n = RandomVector().normalized();
    const Eigen::Vector3d force = RandomVector();
    const ContactResponse response = EvaluateContactLaw(force, n, mu);
    ++branches[static_cast<int>(response.branch)];
    const Eigen::Vector3d r = response.impulse, u = force + r;
    const double r_normal = n.dot(r), u_normal = n.dot(u);
    const Eigen::Vector3d r_tangential = r - r_normal * n, u_tangential = u - u_normal * n;
    EXPECT_GE(r_normal, -1e-14);
    EXPECT_GE(u_normal, -1e-14);
    EXPECT_NEAR(r_normal * u_normal, 0.0, 1e-13);
    EXPECT_LE(r_tangential.norm(), mu * r_normal + 1e-13);
    EXPECT_LE(r_tangential.dot(u_tangential), 1e-13);
    if (u_tangential.norm() > 1e-10 && r_normal > 0.0) {
      EXPECT_NEAR(r_tangential.norm(), mu * r_normal, 1e-12);
    }
  }
  for (const int count : branches) EXPECT_GT(count, 100);
}

TEST_F(ContactLawTest, WithoutFrictionNeverSticks) {
  const Eigen::Vector3d n = Eigen::Vector3d::UnitZ();
  const ContactResponse response = EvaluateContactLaw(-2.0 * n, n, 0.0);
  EXPECT_EQ(response.branch, ContactBranch::kSlip);
  EXPECT_NEAR(response.slip_direction.norm(), 1.0, 1e-15);
  EXPECT_NEAR(response.slip_direction.dot(n), 0.0, 1e-15);
  EXPECT_EQ(SlipRatio(response, 0.0), 0.0);
  const Eigen::Matrix3d expected = -n * n.transpose();
  EXPECT_LT((ImpulseForceJacobian(response, n, 0.0) - expected).norm(), 1e-15);
}

TEST_F(ContactLawTest, IsContinuousAcrossItsBranches) {
  const Eigen::Vector3d n = Eigen::Vector3d::UnitZ();
  const double mu = 0.4, tiny = 1e-9;
  const auto impulse = [&](double normal, double tangential) {
    return EvaluateContactLaw({tangential, 0.0, normal}, n, mu).impulse;
  };
  EXPECT_LT((impulse(-1.0, 0.4 - tiny) - impulse(-1.0, 0.4 + tiny)).norm(), 4.0 * tiny);
  EXPECT_LT((impulse(-tiny, 0.5) - impulse(tiny, 0.5)).norm(), 4.0 * tiny);
}

TEST_F(ContactLawTest, ForceJacobianIsTheDerivative) {
  const double step = 1e-6;
  for (int i = 0; i < 300; ++i) {
    const double mu = 0.5;
    const Eigen::Vector3d n = RandomVector().normalized(), force = RandomVector(), direction = RandomVector();
    const ContactResponse response = EvaluateContactLaw(force, n, mu);
    const ContactResponse plus = EvaluateContactLaw(force + step * direction, n, mu);
    const ContactResponse minus = EvaluateContactLaw(force - step * direction, n, mu);
    if (plus.branch != response.branch || minus.branch != response.branch) continue;
    const Eigen::Vector3d difference = (plus.impulse - minus.impulse) / (2.0 * step);
    const Eigen::Vector3d derivative = ImpulseForceJacobian(response, n, mu) * direction;
    EXPECT_LT((difference - derivative).norm(), 1e-7 * (1.0 + derivative.norm()));
  }
}

// On a sphere of radius `distance`, where n and dn/dx are known.
TEST_F(ContactLawTest, PositionJacobianIsTheDerivativeThroughTheNormal) {
  const double step = 1e-6, mu = 0.5, distance = 0.7;
  int slipping = 0;
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector3d x = distance * RandomVector().normalized(), force = RandomVector(),
                          direction = RandomVector();
    const Eigen::Vector3d n = x.normalized();
    const Eigen::Matrix3d normal_gradient = (Eigen::Matrix3d::Identity() - n * n.transpose()) / x.norm();
    const ContactResponse response = EvaluateContactLaw(force, n, mu);
    const auto plus = EvaluateContactLaw(force, (x + step * direction).normalized(), mu);
    const auto minus = EvaluateContactLaw(force, (x - step * direction).normalized(), mu);
    if (plus.branch != response.branch || minus.branch != response.branch) continue;
    slipping += response.branch == ContactBranch::kSlip;
    const Eigen::Vector3d difference = (plus.impulse - minus.impulse) / (2.0 * step);
    const Eigen::Vector3d derivative = ImpulsePositionJacobian(response, force, n, normal_gradient, mu) * direction;
    EXPECT_LT((difference - derivative).norm(), 1e-7 * (1.0 + derivative.norm()));
  }
  EXPECT_GT(slipping, 50);
}

}  // namespace
}  // namespace clothid::contact_law_test
