#include "sim/shell/seam_energy.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim/cloth/cloth_model.h"
#include "sim/cloth/system_matrix.h"
#include "tests/sim/forces_of.h"
#include "tests/sim/plain_scenes.h"

namespace clothid::seam_energy_test {
namespace {

// A grid with a link to a node, one to a point of an edge that closes, and one at a handle.
Scene Linked() {
  Scene scene = ClothScene(SquareGrid(4, 0.3), 0.01);
  scene.mesh.links = {{3, {12, 12}, 0.0, 40.0, 0.0}, {15, {0, 1}, 0.3, 70.0, 0.5}, {5, {10, 9}, 0.8, 25.0, 0.2}};
  scene.handles.nodes = {1, 10};
  return scene;
}

Eigen::VectorXd Scattered(const Scene& scene) {
  Eigen::VectorXd positions = scene.initial_positions;
  for (Eigen::Index i = 0; i < positions.size(); ++i)
    positions[i] += 0.05 * std::sin(3.7 * static_cast<double>(i) + 0.4);
  return positions;
}

double EnergyAt(const SeamEnergy& seams, double time, const Eigen::VectorXd& positions) {
  Eigen::VectorXd unused = Eigen::VectorXd::Zero(positions.size());
  return seams.AddForce(time, positions, &unused);
}

TEST(SeamEnergyTest, IsThatOfItsFormula) {
  const Scene scene = Linked();
  const ClothModel model(scene);
  const Eigen::Matrix3Xd x = Scattered(scene).reshaped(3, 16), rest = scene.mesh.rest_positions;
  const auto gap = [](const Eigen::Matrix3Xd& at) -> Eigen::Vector3d {
    return at.col(15) - 0.7 * at.col(0) - 0.3 * at.col(1);
  };
  const auto other = [](const Eigen::Matrix3Xd& at) -> Eigen::Vector3d {
    return at.col(5) - 0.2 * at.col(10) - 0.8 * at.col(9);
  };
  const double button = 20.0 * (x.col(3) - x.col(12)).squaredNorm();
  const Eigen::VectorXd positions = x.reshaped();
  EXPECT_NEAR(
      EnergyAt(SeamsOf(model), 0.1, positions),
      button + 35.0 * (gap(x) - 0.8 * gap(rest)).squaredNorm() + 12.5 * (other(x) - 0.5 * other(rest)).squaredNorm(),
      1e-14);
  EXPECT_NEAR(EnergyAt(SeamsOf(model), 0.7, positions),
              button + 35.0 * gap(x).squaredNorm() + 12.5 * other(x).squaredNorm(), 1e-14);
  EXPECT_NEAR(EnergyAt(SeamsOf(model), 0.0, scene.initial_positions), 20.0 * (rest.col(3) - rest.col(12)).squaredNorm(),
              1e-14);
}

TEST(SeamEnergyTest, ForceAndPowerAreItsDerivatives) {
  const Scene scene = Linked();
  const ClothModel model(scene);
  const SeamEnergy& seams = SeamsOf(model);
  const Eigen::VectorXd positions = Scattered(scene);
  Eigen::VectorXd force = Eigen::VectorXd::Zero(positions.size());
  seams.AddForce(0.13, positions, &force);
  constexpr double kStep = 1e-4;  // the energy is quadratic: differences are exact but for rounding
  for (Eigen::Index i = 0; i < positions.size(); ++i) {
    Eigen::VectorXd plus = positions, minus = positions;
    plus[i] += kStep;
    minus[i] -= kStep;
    EXPECT_NEAR(force[i], -(EnergyAt(seams, 0.13, plus) - EnergyAt(seams, 0.13, minus)) / (2.0 * kStep), 1e-10);
  }
  for (const double time : {0.13, 0.3, 0.8}) {
    const double slope =
        (EnergyAt(seams, time + kStep, positions) - EnergyAt(seams, time - kStep, positions)) / (2.0 * kStep);
    EXPECT_NEAR(seams.Power(time, positions), slope, 1e-10) << time;
  }
  EXPECT_EQ(seams.Power(0.8, positions), 0.0);
}

// Over the free nodes, and the matrix of all.
TEST(SeamEnergyTest, HessianIsTheMatrix) {
  const Scene scene = Linked();
  const ClothModel model(scene);
  const Eigen::MatrixXd matrix = SeamsOf(model).matrix();
  EXPECT_LT((matrix * Eigen::VectorXd::Ones(16)).norm(), 1e-13);
  EXPECT_EQ(matrix, matrix.transpose());
  BlockMatrix hessian(model.pattern());
  SeamsOf(model).AddHessian(2.0, &hessian);
  hessian.CompleteFromLower();
  const BlockPattern& pattern = *model.pattern();
  const Eigen::MatrixXd dense = Eigen::Map<const Eigen::SparseMatrix<double>>(
      pattern.size(), pattern.size(), pattern.num_values(), pattern.outer().data(), pattern.inner().data(),
      hessian.values.data());
  const Eigen::MatrixXd free = matrix(model.free_nodes(), model.free_nodes());
  for (int axis = 0; axis < 3; ++axis) {
    const auto of_axis = Eigen::seqN(axis, model.num_free(), 3);
    EXPECT_LT((dense(of_axis, of_axis) - 2.0 * free).norm(), 1e-12);
    EXPECT_EQ(dense(of_axis, Eigen::seqN((axis + 1) % 3, model.num_free(), 3)).norm(), 0.0);
  }
}

// P has it, with the weights of contacts on its diagonal.
TEST(SeamEnergyTest, IsPartOfTheSystemMatrix) {
  const Scene scene = Linked();
  Scene plain = scene;
  plain.mesh.links.clear();
  const ClothModel model(scene), without(plain);
  const auto over_nodes = [](const ClothModel& of, const Material& material) {
    Eigen::MatrixXd all = Eigen::MatrixXd::Zero(16, 16);
    all(of.free_nodes(), of.free_nodes()) = Eigen::MatrixXd(AssembleSystemMatrix(of, material, 0.02));
    return all;
  };
  Eigen::MatrixXd expected = 0.02 * 0.02 * Eigen::MatrixXd(SeamsOf(model).matrix());
  for (const int handle : scene.handles.nodes) {
    expected.row(handle).setZero();
    expected.col(handle).setZero();
  }
  EXPECT_LT((over_nodes(model, scene.material) - over_nodes(without, scene.material) - expected).norm(), 1e-13);
}

TEST(SeamEnergyTest, IsAbsentWithoutLinks) {
  const Scene scene = ClothScene(SquareGrid(4, 0.3), 0.01);
  EXPECT_EQ(ClothModel(scene).forces().Find<SeamTerm>(), nullptr);
}

}  // namespace
}  // namespace clothid::seam_energy_test
