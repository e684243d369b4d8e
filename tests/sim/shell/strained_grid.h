// What tests of energies start from: a grid of cloth, strained and creased at random, every node free.
#ifndef CLOTHID_TESTS_SIM_SHELL_STRAINED_GRID_H_
#define CLOTHID_TESTS_SIM_SHELL_STRAINED_GRID_H_

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <memory>
#include <numeric>
#include <random>
#include <vector>

#include "sim/matrix/block_matrix.h"
#include "sim/matrix/dense.h"
#include "sim/mesh/mesh.h"
#include "sim/shell/triangle_element.h"

namespace clothid {

class StrainedGridTest : public ::testing::Test {
 protected:
  StrainedGridTest() {
    GridOptions grid;
    grid.nodes = {4, 3};
    grid.size = {0.3, 0.2};  // 12 triangles: they do not fill the last batch
    mesh_ = MakeGrid(grid);
    free_index_.resize(mesh_.num_nodes());
    std::iota(free_index_.begin(), free_index_.end(), 0);
    pattern_ = std::make_shared<BlockPattern>(std::vector<std::vector<int>>(mesh_.num_nodes(), free_index_));
    triangles_ = std::make_shared<const TriangleElements>(MakeTriangleElements(mesh_, free_index_, *pattern_));
    std::mt19937_64 generator(3);
    std::normal_distribution<double> normal;
    rest_ = mesh_.rest_positions.reshaped();
    positions_ = rest_;
    for (double& x : positions_) x += 0.01 * normal(generator);
    direction_.resize(positions_.size());
    for (double& x : direction_) x = normal(generator);
  }

  // `positions` turned by `angle` (rad) about an axis that lies askew, and shifted.
  static Eigen::VectorXd Moved(const Eigen::VectorXd& positions, double angle) {
    const Eigen::Matrix3d rotation =
        Eigen::AngleAxisd(angle, Eigen::Vector3d(1.0, -2.0, 0.5).normalized()).toRotationMatrix();
    const Eigen::Matrix3Xd x = positions.reshaped(3, positions.size() / 3);
    return ((rotation * x).colwise() + Eigen::Vector3d(0.3, -5.0, 2.0)).reshaped();
  }

  // `positions` with x times `factor`.
  static Eigen::VectorXd StretchedAlongX(Eigen::VectorXd positions, double factor) {
    for (Eigen::Index i = 0; i < positions.size(); i += 3) positions[i] *= factor;
    return positions;
  }

  // The lowest eigenvalue of a symmetric matrix, relative to the highest.
  static double LowestEigenvalue(const Eigen::MatrixXd& matrix) {
    const Eigen::VectorXd values = SymmetricEigenvalues(matrix);
    return values[0] / values[values.size() - 1];
  }

  Mesh mesh_;  // 0.3 m x 0.2 m in the plane z = 0
  std::vector<int> free_index_;
  std::shared_ptr<const BlockPattern> pattern_;  // with every block
  std::shared_ptr<const TriangleElements> triangles_;
  Eigen::VectorXd rest_, positions_, direction_;  // [3N]
};

}  // namespace clothid

#endif  // CLOTHID_TESTS_SIM_SHELL_STRAINED_GRID_H_
