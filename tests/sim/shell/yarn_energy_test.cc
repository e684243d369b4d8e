// The energy of a membrane that stiffens along its yarns, against differences and closed forms.
#include "sim/shell/yarn_energy.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim/scene/warp.h"
#include "tests/sim/shell/strained_grid.h"

namespace clothid::yarn_energy_test {
namespace {

constexpr YarnConstants kKnit = {{200.0, 90.0, -40.0, 15.0}, {6.0, 3.0}};
constexpr YarnConstants kStiffest = {{200.0, 90.0, 60.0, 15.0}, {20.0, 20.0}};
constexpr double kArea = 0.06;  // m^2, of the grid

class YarnEnergyTest : public StrainedGridTest {
 protected:
  YarnEnergyTest()
      : energy_([&] {
          const Eigen::Matrix3Xd directions = WarpDirections(Warp(), mesh_);
          return std::make_shared<const TriangleElements>(
              MakeTriangleElements(mesh_, free_index_, *pattern_, &directions));
        }()) {}

  double Value(const YarnConstants& constants, const Eigen::VectorXd& positions) const {
    Eigen::VectorXd unused = Eigen::VectorXd::Zero(positions.size());
    return energy_.AddForce(constants, positions, &unused);
  }
  Eigen::VectorXd Force(const YarnConstants& constants, const Eigen::VectorXd& positions) const {
    Eigen::VectorXd force = Eigen::VectorXd::Zero(positions.size());
    energy_.AddForce(constants, positions, &force);
    return force;
  }
  Eigen::MatrixXd Hessian(const YarnConstants& constants, HessianKind kind, const Eigen::VectorXd& positions) const {
    BlockMatrix hessian(pattern_);
    energy_.AddHessian(1.0, constants, kind, positions, &hessian);
    hessian.CompleteFromLower();
    return Eigen::MatrixXd(hessian.view());
  }
  // The grid at rest under the map x -> F x of its plane.
  Eigen::VectorXd Mapped(const Eigen::Matrix2d& f) const {
    Eigen::Matrix3Xd mapped = mesh_.rest_positions;
    mapped.topRows<2>() = f * mesh_.rest_positions.topRows<2>();
    return mapped.reshaped();
  }
  // What pulls at the nodes of the last column, per width.
  double PullPerWidth(const YarnConstants& constants, double strain) const {
    const Eigen::VectorXd force = Force(constants, Mapped(Eigen::Matrix2d{{1.0 + strain, 0.0}, {0.0, 1.0}}));
    double pull = 0.0;
    for (int node = 3; node < mesh_.num_nodes(); node += 4) pull -= force[3 * node];
    return pull / 0.2;
  }

  YarnEnergy energy_;
};

class YarnEnergiesTest : public YarnEnergyTest, public testing::WithParamInterface<YarnConstants> {};

TEST_P(YarnEnergiesTest, ForceIsTheGradient) {
  const double step = 1e-6;
  const double difference =
      (Value(GetParam(), positions_ + step * direction_) - Value(GetParam(), positions_ - step * direction_)) /
      (2.0 * step);
  EXPECT_NEAR(-Force(GetParam(), positions_).dot(direction_), difference, 1e-7 * std::abs(difference));
}

TEST_P(YarnEnergiesTest, HessianIsTheSecondDerivative) {
  const Eigen::MatrixXd hessian = Hessian(GetParam(), HessianKind::kExact, positions_);
  EXPECT_LT((hessian - hessian.transpose()).norm(), 1e-13 * hessian.norm());
  const double step = 1e-7;
  const Eigen::VectorXd difference =
      (Force(GetParam(), positions_ - step * direction_) - Force(GetParam(), positions_ + step * direction_)) /
      (2.0 * step);
  EXPECT_LT((hessian * direction_ - difference).norm(), 1e-6 * difference.norm());
}

TEST_P(YarnEnergiesTest, ClampedHessianIsPositiveSemidefinite) {
  for (const double factor : {0.6, 0.8, 1.0, 1.3}) {
    EXPECT_GT(LowestEigenvalue(Hessian(GetParam(), HessianKind::kClamped, factor * positions_)), -1e-12) << factor;
  }
  EXPECT_LT(LowestEigenvalue(Hessian(GetParam(), HessianKind::kExact, 0.6 * positions_)), -1e-3);
  // Stretched along yarns that stand at a right angle nothing is clamped.
  const Eigen::VectorXd stretched = Mapped(Eigen::Matrix2d{{1.1, 0.0}, {0.0, 1.2}});
  YarnConstants constants = GetParam();
  constants.k.c12 = std::abs(constants.k.c12);
  const Eigen::MatrixXd exact = Hessian(constants, HessianKind::kExact, stretched);
  EXPECT_LT((exact - Hessian(constants, HessianKind::kClamped, stretched)).norm(), 1e-13 * exact.norm());
}

TEST_P(YarnEnergiesTest, DerivativesByStiffeningAreDifferences) {
  for (int yarn = 0; yarn < 2; ++yarn) {
    Eigen::VectorXd derivative = Eigen::VectorXd::Zero(positions_.size());
    energy_.AddStiffeningDerivative(yarn, 1.0, GetParam(), positions_, &derivative);
    YarnConstants more = GetParam(), less = GetParam();
    more.stiffening[yarn] += 1e-4;
    less.stiffening[yarn] -= 1e-4;
    const Eigen::VectorXd difference = (Force(more, positions_) - Force(less, positions_)) / 2e-4;
    EXPECT_LT((derivative - difference).norm(), 1e-6 * difference.norm()) << yarn;
  }
}

TEST_P(YarnEnergiesTest, RigidMotionIsFreeAndTurnsForces) {
  const Eigen::VectorXd force = Force(GetParam(), positions_);
  const double strained = Value(GetParam(), positions_);
  for (const double angle : {0.0, 0.5, 3.1}) {
    EXPECT_LT(Value(GetParam(), Moved(rest_, angle)), 1e-24) << angle;
    EXPECT_NEAR(Value(GetParam(), Moved(positions_, angle)), strained, 1e-12 * strained) << angle;
    const Eigen::VectorXd turned = Moved(force, angle) - Moved(Eigen::VectorXd::Zero(force.size()), angle);
    EXPECT_LT((Force(GetParam(), Moved(positions_, angle)) - turned).norm(), 1e-11 * force.norm()) << angle;
  }
}

INSTANTIATE_TEST_SUITE_P(All, YarnEnergiesTest, testing::Values(kKnit, kStiffest));

// Force per rest width over engineering strain: k (exp(b e) - 1)/b in tension, k e in compression.
TEST_F(YarnEnergyTest, TheCurveOfAStripIsTheLaw) {
  YarnConstants constants = kKnit;
  constants.k.c12 = 0.0;
  for (const double stiffening : {0.0, 1e-6, 1e-3, 0.2, 6.0, 20.0}) {
    constants.stiffening[0] = stiffening;
    for (const double strain : {-0.2, -0.01, 1e-4, 0.02, 0.1, 0.3}) {
      const double stress = strain <= 0.0 || stiffening == 0.0 ? strain : std::expm1(stiffening * strain) / stiffening;
      EXPECT_NEAR(PullPerWidth(constants, strain), 200.0 * stress, 1e-11 * 200.0 * std::abs(stress))
          << stiffening << " " << strain;
    }
  }
}

// The slope doubles with every ln(2)/b.
TEST_F(YarnEnergyTest, StiffensByItsFactor) {
  YarnConstants constants = kKnit;
  constants.k.c12 = 0.0;
  const auto slope = [&](double strain) {
    return (PullPerWidth(constants, strain + 1e-6) - PullPerWidth(constants, strain - 1e-6)) / 2e-6;
  };
  EXPECT_NEAR(slope(0.05), 200.0 * std::exp(0.3), 1e-5 * 200.0);
  EXPECT_NEAR(slope(0.05 + std::log(2.0) / 6.0) / slope(0.05), 2.0, 1e-7);
}

TEST_F(YarnEnergyTest, ValuesOfUniformStrains) {
  const auto value = [&](const Eigen::Matrix2d& f) { return Value(kKnit, Mapped(f)) / kArea; };
  const auto psi = [](double e, double b) { return (std::expm1(b * e) - b * e) / (b * b); };
  const double s = 0.2;
  EXPECT_NEAR(value(Eigen::Matrix2d{{1.0 + s, 0.0}, {0.0, 1.0}}), 200.0 * psi(s, 6.0), 1e-11);
  EXPECT_NEAR(value(Eigen::Matrix2d{{1.0, 0.0}, {0.0, 1.0 - s}}), 0.5 * 90.0 * s * s, 1e-12);
  EXPECT_NEAR(value((1.0 + s) * Eigen::Matrix2d::Identity()), 200.0 * psi(s, 6.0) + 90.0 * psi(s, 3.0) - 40.0 * s * s,
              1e-11);
  // Yarns that keep their lengths and turn to the angle with the cosine s.
  EXPECT_NEAR(value(Eigen::Matrix2d{{1.0, s}, {0.0, std::sqrt(1.0 - s * s)}}), 0.5 * 15.0 * s * s, 1e-12);
}

// In small strains it is the orthotropic law.
TEST_F(YarnEnergyTest, IsOrthotropicInSmallStrains) {
  const Eigen::Matrix3Xd directions = WarpDirections(Warp(), mesh_);
  const OrthotropicEnergy orthotropic(
      std::make_shared<const TriangleElements>(MakeTriangleElements(mesh_, free_index_, *pattern_, &directions)));
  BlockMatrix expected(pattern_);
  orthotropic.AddHessian(kKnit.k, HessianKind::kExact, rest_, &expected);
  expected.CompleteFromLower();
  const Eigen::MatrixXd hessian = Hessian(kKnit, HessianKind::kExact, rest_);
  EXPECT_LT((hessian - Eigen::MatrixXd(expected.view())).norm(), 1e-12 * hessian.norm());
}

}  // namespace
}  // namespace clothid::yarn_energy_test
