// The bending energy against differences and closed forms.
#include "sim/shell/bending_energy.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <vector>

#include "sim/scene/scene.h"
#include "sim/shell/bending_patch.h"
#include "tests/sim/shell/strained_grid.h"

namespace clothid::bending_energy_test {
namespace {

// Of `mesh`, for a Hessian that has every block.
BendingEnergy EnergyOf(const Mesh& mesh, BendingLaw law) {
  std::vector<int> everyone(mesh.num_nodes());
  std::iota(everyone.begin(), everyone.end(), 0);
  const BlockPattern pattern(std::vector<std::vector<int>>(mesh.num_nodes(), everyone));
  if (law == BendingLaw::kEdges) return BendingEnergy(EdgeBendingMatrix(mesh), everyone, pattern);
  const BendingPatches patches(mesh, FirstEdges(mesh));
  return BendingEnergy(patches.Matrix(IsotropicRigidity(1.0, 0.3)), everyone, pattern);
}

class BendingEnergyTest : public StrainedGridTest, public ::testing::WithParamInterface<BendingLaw> {
 protected:
  static BendingEnergy MakeEnergy(const Mesh& mesh) { return EnergyOf(mesh, GetParam()); }
};

TEST_P(BendingEnergyTest, IgnoresAffineMaps) {
  const BendingEnergy energy = MakeEnergy(mesh_);
  Eigen::VectorXd force = Eigen::VectorXd::Zero(rest_.size());
  EXPECT_NEAR(energy.AddForce(1.0, 1.3 * rest_, &force), 0.0, 1e-13);
  EXPECT_LT(force.norm(), 1e-10);
}

TEST_P(BendingEnergyTest, ForceIsTheGradient) {
  const BendingEnergy energy = MakeEnergy(mesh_);
  Eigen::VectorXd force = Eigen::VectorXd::Zero(positions_.size()), unused = force;
  energy.AddForce(3.0, positions_, &force);
  const double step = 1e-5;
  const double difference = (energy.AddForce(3.0, positions_ + step * direction_, &unused) -
                             energy.AddForce(3.0, positions_ - step * direction_, &unused)) /
                            (2.0 * step);
  EXPECT_NEAR(-force.dot(direction_), 3.0 * difference, 1e-7 * std::abs(3.0 * difference));
}

// A strip bent gently to radius R. The edges across the strip, a third of all, carry the whole curvature, three times
// over: on this mesh E is three times the k_b/2 area/R^2 of the continuum (see bending_energy.h).
TEST(EdgeBendingTest, ValueOfACylinder) {
  GridOptions grid;
  grid.nodes = {81, 5};
  grid.size = {1.0, 0.05};
  const Mesh strip = MakeGrid(grid);
  const BendingEnergy strip_energy = EnergyOf(strip, BendingLaw::kEdges);
  const double radius = 2.0;
  Eigen::VectorXd bent = strip.rest_positions.reshaped();
  for (int node = 0; node < strip.num_nodes(); ++node) {
    const double angle = strip.rest_positions(0, node) / radius;
    bent[3 * node] = radius * std::sin(angle);
    bent[3 * node + 2] = radius * (1.0 - std::cos(angle));
  }
  Eigen::VectorXd unused = Eigen::VectorXd::Zero(bent.size());
  const double expected = 3.0 * 0.5 * 0.05 / (radius * radius);
  EXPECT_NEAR(strip_energy.AddForce(1.0, bent, &unused), expected, 0.02 * expected);
}

TEST_P(BendingEnergyTest, HessianIsTheSecondDerivative) {
  const BendingEnergy energy = MakeEnergy(mesh_);
  BlockMatrix hessian(pattern_);
  energy.AddHessian(3.0, &hessian);
  hessian.CompleteFromLower();
  const Eigen::MatrixXd matrix(hessian.view());
  EXPECT_EQ((matrix - matrix.transpose()).norm(), 0.0);
  EXPECT_GT(LowestEigenvalue(matrix), -1e-12);
  // The force is linear, so that differences are exact but for rounding.
  Eigen::VectorXd plus = Eigen::VectorXd::Zero(positions_.size()), minus = plus;
  energy.AddForce(3.0, positions_ + direction_, &plus);
  energy.AddForce(3.0, positions_ - direction_, &minus);
  EXPECT_LT((matrix * direction_ - 0.5 * (minus - plus)).norm(), 1e-12 * (minus - plus).norm());
  for (int node = 0; node < mesh_.num_nodes(); ++node) {
    EXPECT_NEAR(matrix(3 * node, 3 * node), 3.0 * energy.diagonal()[node], 1e-12 * matrix.norm()) << node;
  }
}

TEST_P(BendingEnergyTest, RigidMotionKeepsIt) {
  const BendingEnergy energy = MakeEnergy(mesh_);
  Eigen::VectorXd unused = Eigen::VectorXd::Zero(rest_.size());
  const double creased = energy.AddForce(1.0, positions_, &unused);
  ASSERT_GT(creased, 0.0);
  for (const double angle : {0.5, 3.1}) {
    EXPECT_NEAR(energy.AddForce(1.0, Moved(positions_, angle), &unused), creased, 1e-10 * creased) << angle;
    EXPECT_LT(std::abs(energy.AddForce(1.0, Moved(rest_, angle), &unused)), 1e-10 * creased) << angle;
  }
}

INSTANTIATE_TEST_SUITE_P(Laws, BendingEnergyTest, ::testing::Values(BendingLaw::kEdges, BendingLaw::kPatches),
                         [](const auto& test) { return test.param == BendingLaw::kEdges ? "Edges" : "Patches"; });

}  // namespace
}  // namespace clothid::bending_energy_test
