// The orthotropic stretch energy against differences and closed forms.
#include "sim/shell/orthotropic_energy.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim/scene/warp.h"
#include "tests/sim/shell/strained_grid.h"

namespace clothid::orthotropic_energy_test {
namespace {

constexpr OrthotropicConstants kWoven = {200.0, 90.0, -40.0, 15.0};
constexpr double kArea = 0.06;  // m^2, of the grid

class OrthotropicEnergyTest : public StrainedGridTest {
 protected:
  OrthotropicEnergyTest() : energy_(AlongX()) {}

  OrthotropicEnergy WithWarp(const Warp& warp, const Mesh& mesh) const {
    const Eigen::Matrix3Xd directions = WarpDirections(warp, mesh);
    return OrthotropicEnergy(
        std::make_shared<const TriangleElements>(MakeTriangleElements(mesh, free_index_, *pattern_, &directions)));
  }
  OrthotropicEnergy AlongX() const { return WithWarp(Warp(), mesh_); }

  static double Value(const OrthotropicEnergy& energy, const OrthotropicConstants& constants,
                      const Eigen::VectorXd& positions) {
    Eigen::VectorXd unused = Eigen::VectorXd::Zero(positions.size());
    return energy.AddForce(constants, positions, &unused);
  }

  Eigen::VectorXd Force(const OrthotropicConstants& constants, const Eigen::VectorXd& positions) const {
    Eigen::VectorXd force = Eigen::VectorXd::Zero(positions.size());
    energy_.AddForce(constants, positions, &force);
    return force;
  }

  Eigen::MatrixXd Hessian(HessianKind kind, const Eigen::VectorXd& positions) const {
    BlockMatrix hessian(pattern_);
    energy_.AddHessian(kWoven, kind, positions, &hessian);
    hessian.CompleteFromLower();
    return Eigen::MatrixXd(hessian.view());
  }

  // The grid at rest under the map x -> F x of its plane.
  Eigen::VectorXd Mapped(const Eigen::Matrix2d& f) const {
    Eigen::Matrix3Xd mapped = mesh_.rest_positions;
    mapped.topRows<2>() = f * mesh_.rest_positions.topRows<2>();
    return mapped.reshaped();
  }

  OrthotropicEnergy energy_;
};

TEST_F(OrthotropicEnergyTest, ForceIsTheGradient) {
  const double step = 1e-6;
  const double difference = (Value(energy_, kWoven, positions_ + step * direction_) -
                             Value(energy_, kWoven, positions_ - step * direction_)) /
                            (2.0 * step);
  EXPECT_NEAR(-Force(kWoven, positions_).dot(direction_), difference, 1e-7 * std::abs(difference));
}

TEST_F(OrthotropicEnergyTest, HessianIsTheSecondDerivative) {
  const Eigen::MatrixXd hessian = Hessian(HessianKind::kExact, positions_);
  EXPECT_LT((hessian - hessian.transpose()).norm(), 1e-13 * hessian.norm());
  const double step = 1e-6;
  const Eigen::VectorXd difference =
      (Force(kWoven, positions_ - step * direction_) - Force(kWoven, positions_ + step * direction_)) / (2.0 * step);
  EXPECT_LT((hessian * direction_ - difference).norm(), 1e-7 * difference.norm());
}

TEST_F(OrthotropicEnergyTest, ClampedHessianIsPositiveSemidefiniteInCompression) {
  const Eigen::VectorXd compressed = 0.8 * positions_;
  EXPECT_LT(LowestEigenvalue(Hessian(HessianKind::kExact, compressed)), -1e-3);
  EXPECT_GT(LowestEigenvalue(Hessian(HessianKind::kClamped, compressed)), -1e-12);
  // In tension nothing is clamped.
  const Eigen::VectorXd stretched = 1.5 * rest_;
  const Eigen::MatrixXd exact = Hessian(HessianKind::kExact, stretched);
  EXPECT_LT((exact - Hessian(HessianKind::kClamped, stretched)).norm(), 1e-13 * exact.norm());
}

TEST_F(OrthotropicEnergyTest, ValuesOfUniformStrains) {
  const double s = 0.2, e = s + 0.5 * s * s;
  const auto value = [&](const Eigen::Matrix2d& f) { return Value(energy_, kWoven, Mapped(f)) / kArea; };
  EXPECT_NEAR(value(Eigen::Matrix2d{{1.0 + s, 0.0}, {0.0, 1.0}}), 0.5 * kWoven.c11 * e * e, 1e-12);
  EXPECT_NEAR(value(Eigen::Matrix2d{{1.0, 0.0}, {0.0, 1.0 + s}}), 0.5 * kWoven.c22 * e * e, 1e-12);
  EXPECT_NEAR(value((1.0 + s) * Eigen::Matrix2d::Identity()), (0.5 * (kWoven.c11 + kWoven.c22) + kWoven.c12) * e * e,
              1e-12);
  // Simple shear by s: 2 e_12 = s, e_22 = s^2/2.
  EXPECT_NEAR(value(Eigen::Matrix2d{{1.0, s}, {0.0, 1.0}}),
              0.5 * kWoven.c66 * s * s + 0.125 * kWoven.c22 * std::pow(s, 4), 1e-12);
}

// In uniaxial tension the force per width is Y e (1 + e)(1 + e/2).
TEST_F(OrthotropicEnergyTest, TensionOfAStretchedStrip) {
  const double s = 0.1, width = 0.2, tension = kWoven.c11 * s * (1.0 + s) * (1.0 + s / 2.0);
  const Eigen::VectorXd force =
      Force({kWoven.c11, kWoven.c22, 0.0, kWoven.c66}, Mapped(Eigen::Matrix2d{{1.0 + s, 0.0}, {0.0, 1.0}}));
  double pull = 0.0;
  for (int node = 3; node < mesh_.num_nodes(); node += 4) pull -= force[3 * node];  // of the last column
  EXPECT_NEAR(pull, tension * width, 1e-12 * tension);
}

TEST_F(OrthotropicEnergyTest, RigidMotionIsFree) {
  const double straining = Force(kWoven, positions_).norm(), strained = Value(energy_, kWoven, positions_);
  for (const double angle : {0.0, 0.5, 3.1}) {
    EXPECT_LT(Value(energy_, kWoven, Moved(rest_, angle)), 1e-24) << angle;
    EXPECT_LT(Force(kWoven, Moved(rest_, angle)).norm(), 1e-12 * straining) << angle;
    EXPECT_NEAR(Value(energy_, kWoven, Moved(positions_, angle)), strained, 1e-12 * strained) << angle;
  }
}

// Yarns at an angle to the mesh are those of a mesh that is turned the other way at rest, whichever way triangles are
// listed.
TEST_F(OrthotropicEnergyTest, AnAngleOfTheWarpTurnsTheMesh) {
  const double radians = 35.0 * std::acos(-1.0) / 180.0;
  Mesh turned = mesh_;
  turned.rest_positions =
      Eigen::AngleAxisd(-radians, Eigen::Vector3d::UnitZ()).toRotationMatrix() * mesh_.rest_positions;
  const double expected = Value(WithWarp(Warp(), turned), kWoven, positions_);
  const Warp by_angle = {Eigen::Vector3d::UnitX(), 35.0};
  const Warp by_direction = {Eigen::Vector3d(2.0 * std::cos(radians), 2.0 * std::sin(radians), 0.7), 0.0};
  EXPECT_NEAR(Value(WithWarp(by_angle, mesh_), kWoven, positions_), expected, 1e-12 * expected);
  EXPECT_NEAR(Value(WithWarp(by_direction, mesh_), kWoven, positions_), expected, 1e-12 * expected);
  EXPECT_GT(std::abs(Value(energy_, kWoven, positions_) - expected), 1e-2 * expected);
  Mesh reversed = mesh_;
  reversed.faces.row(1).swap(reversed.faces.row(2));
  const Warp other_way = {Eigen::Vector3d::UnitX(), -35.0};  // seen from the other side
  EXPECT_NEAR(Value(WithWarp(other_way, reversed), kWoven, positions_), expected, 1e-12 * expected);
}

// a (lambda/2 (tr e)^2 + mu |e|^2), whatever the axes.
TEST_F(OrthotropicEnergyTest, IsotropicConstantsAreThoseOfAPlate) {
  const double young = 120.0, nu = 0.4, c11 = young / (1.0 - nu * nu);
  const OrthotropicConstants isotropic = {c11, c11, nu * c11, 0.5 * young / (1.0 + nu)};
  const double lambda = nu * c11, mu = isotropic.c66;
  double expected = 0.0;
  for (int f = 0; f < mesh_.num_faces(); ++f) {
    const auto edges = [&](const Eigen::VectorXd& x) {
      Eigen::Matrix<double, 3, 2> e;
      for (int k = 0; k < 2; ++k) {
        e.col(k) = x.segment<3>(3 * mesh_.faces(k + 1, f)) - x.segment<3>(3 * mesh_.faces(0, f));
      }
      return e;
    };
    const Eigen::Matrix2d rest = edges(rest_).topRows<2>();
    const Eigen::Matrix<double, 3, 2> gradient = edges(positions_) * rest.inverse();
    const Eigen::Matrix2d e = 0.5 * (gradient.transpose() * gradient - Eigen::Matrix2d::Identity());
    expected += 0.5 * std::abs(rest.determinant()) * (0.5 * lambda * e.trace() * e.trace() + mu * e.squaredNorm());
  }
  for (const double angle : {0.0, 25.0, 90.0}) {
    const Warp warp = {Eigen::Vector3d::UnitX(), angle};
    EXPECT_NEAR(Value(WithWarp(warp, mesh_), isotropic, positions_), expected, 1e-12 * expected) << angle;
  }
}

// The membrane of a MuJoCo flex is a quadratic form in the changes of the squared lengths l^2 of edges. Without
// Poisson's ratio, with Young's modulus E and thickness t, it is the one with C_11 = C_22 = E t/4, C_66 = E t/8: the
// Green strain is e = sum over edges of (l^2 - l_0^2)/2 times the symmetric matrix that is 1 along the edge and 0 along
// the others.
TEST_F(OrthotropicEnergyTest, IsASumOverSquaredLengthsOfEdges) {
  const double stiffness = 1e5 * 4e-4 / 4.0;
  double expected = 0.0;
  for (int f = 0; f < mesh_.num_faces(); ++f) {
    Eigen::Matrix3d products;  // of edges: u^T m u for m = (m_11, m_22, m_12)
    Eigen::Vector3d changes;
    Eigen::Matrix2d rest;
    for (int side = 0; side < 3; ++side) {
      const int a = mesh_.faces(side, f), b = mesh_.faces((side + 1) % 3, f);
      const Eigen::Vector2d u = (mesh_.rest_positions.col(b) - mesh_.rest_positions.col(a)).head<2>();
      products.row(side) << u[0] * u[0], u[1] * u[1], 2.0 * u[0] * u[1];
      changes[side] = (positions_.segment<3>(3 * b) - positions_.segment<3>(3 * a)).squaredNorm() - u.squaredNorm();
      if (side < 2) rest.col(side) = u;
    }
    const Eigen::Vector3d e = 0.5 * products.inverse() * changes;
    expected += 0.25 * std::abs(rest.determinant()) * stiffness * (e[0] * e[0] + e[1] * e[1] + 2.0 * e[2] * e[2]);
  }
  EXPECT_NEAR(Value(energy_, {stiffness, stiffness, 0.0, 0.5 * stiffness}, positions_), expected, 1e-12 * expected);
}

TEST(OrthotropicConstantsTest, TheLargestBoundsTheEnergy) {
  EXPECT_NEAR((OrthotropicConstants{3.0, 1.0, 0.0, 1.0}).Largest(), 3.0, 1e-15);
  EXPECT_NEAR((OrthotropicConstants{3.0, 3.0, -1.0, 1.0}).Largest(), 4.0, 1e-15);
  EXPECT_NEAR((OrthotropicConstants{3.0, 1.0, 0.0, 5.0}).Largest(), 10.0, 1e-15);
}

}  // namespace
}  // namespace clothid::orthotropic_energy_test
