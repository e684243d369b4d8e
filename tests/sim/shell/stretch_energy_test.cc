// The stretch energy against differences and closed forms.
#include "sim/shell/stretch_energy.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/sim/shell/strained_grid.h"

namespace clothid::stretch_energy_test {
namespace {

class StretchEnergyTest : public StrainedGridTest {
 protected:
  StretchEnergyTest() : energy_(triangles_) {}

  Eigen::MatrixXd Hessian(HessianKind kind, const Eigen::VectorXd& positions) const {
    BlockMatrix hessian(pattern_);
    energy_.AddHessian(1.0, kind, positions, &hessian);
    hessian.CompleteFromLower();
    return Eigen::MatrixXd(hessian.view());
  }

  // E/k.
  double Value(const Eigen::VectorXd& positions) const {
    Eigen::VectorXd unused = Eigen::VectorXd::Zero(positions.size());
    return energy_.AddForce(1.0, positions, &unused);
  }

  StretchEnergy energy_;
};

TEST_F(StretchEnergyTest, ForceIsTheGradient) {
  Eigen::VectorXd force = Eigen::VectorXd::Zero(positions_.size());
  const double value = energy_.AddForce(2.0, positions_, &force);
  EXPECT_DOUBLE_EQ(value, Value(positions_));
  const double step = 1e-6;
  const double difference =
      (Value(positions_ + step * direction_) - Value(positions_ - step * direction_)) / (2.0 * step);
  EXPECT_NEAR(-force.dot(direction_), 2.0 * difference, 1e-7 * std::abs(difference));
}

TEST_F(StretchEnergyTest, HessianIsTheSecondDerivative) {
  const Eigen::MatrixXd hessian = Hessian(HessianKind::kExact, positions_);
  EXPECT_LT((hessian - hessian.transpose()).norm(), 1e-13 * hessian.norm());
  const double step = 1e-6;
  Eigen::VectorXd plus = Eigen::VectorXd::Zero(positions_.size()), minus = plus;
  energy_.AddForce(1.0, positions_ + step * direction_, &plus);
  energy_.AddForce(1.0, positions_ - step * direction_, &minus);
  const Eigen::VectorXd difference = (minus - plus) / (2.0 * step);
  EXPECT_LT((hessian * direction_ - difference).norm(), 1e-7 * difference.norm());
}

TEST_F(StretchEnergyTest, ClampedHessianIsPositiveSemidefiniteInCompression) {
  const Eigen::VectorXd compressed = 0.8 * positions_;
  EXPECT_LT(LowestEigenvalue(Hessian(HessianKind::kExact, compressed)), -1e-3);
  EXPECT_GT(LowestEigenvalue(Hessian(HessianKind::kClamped, compressed)), -1e-12);
  // In tension nothing is clamped.
  const Eigen::VectorXd stretched = 1.5 * rest_;
  EXPECT_LT((Hessian(HessianKind::kExact, stretched) - Hessian(HessianKind::kClamped, stretched)).norm(), 1e-12);
}

TEST_F(StretchEnergyTest, ValueOfAUniformStretch) {
  // F = diag(1.2, 1): E/k = area (0.2)^2 / 2.
  EXPECT_NEAR(Value(StretchedAlongX(rest_, 1.2)), 0.06 * 0.5 * 0.04, 1e-15);
}

TEST_F(StretchEnergyTest, RigidMotionIsFree) {
  Eigen::VectorXd straining = Eigen::VectorXd::Zero(rest_.size());
  energy_.AddForce(1.0, positions_, &straining);
  for (const double angle : {0.0, 0.5, 3.1}) {
    Eigen::VectorXd force = Eigen::VectorXd::Zero(rest_.size());
    EXPECT_LT(energy_.AddForce(1.0, Moved(rest_, angle), &force), 1e-24) << angle;
    EXPECT_LT(force.norm(), 1e-12 * straining.norm()) << angle;
  }
  // And whoever is strained keeps the energy.
  EXPECT_NEAR(Value(Moved(positions_, 2.0)), Value(positions_), 1e-12 * Value(positions_));
}

}  // namespace
}  // namespace clothid::stretch_energy_test
