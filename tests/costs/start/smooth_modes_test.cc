// Modes of the cloth's Laplacian against those of a rectangle, and of both solvers against each other.
#include "costs/start/smooth_modes.h"

#include <gtest/gtest.h>

#include <Eigen/SparseCore>
#include <cmath>

#include "sim/mesh/mesh.h"
#include "sim/shell/triangle_element.h"

namespace clothid::smooth_modes_test {
namespace {

Scene GridScene(int nodes_x, int nodes_y) {
  Scene scene;
  GridOptions grid;
  grid.nodes = {nodes_x, nodes_y};
  grid.size = {0.6, 0.4};
  scene.mesh = MakeGrid(grid);
  scene.initial_positions = scene.mesh.rest_positions.reshaped();
  scene.initial_velocities = Eigen::VectorXd::Zero(scene.initial_positions.size());
  return scene;
}

// phi^T L phi/phi^T M phi of every mode.
Eigen::VectorXd Values(const ClothModel& model, const Eigen::MatrixXd& modes) {
  const Eigen::SparseMatrix<double> laplacian = LaplacianMatrix(model.triangles(), model.num_nodes());
  const Eigen::MatrixXd product = laplacian * modes;
  return (modes.cwiseProduct(product).colwise().sum().array() /
          (model.node_areas().asDiagonal() * modes.cwiseAbs2()).colwise().sum().array())
      .transpose();
}

// A sheet with free edges: pi^2 (i^2/a^2 + j^2/b^2), the first of them 0.
TEST(SmoothModesTest, AreThoseOfARectangle) {
  const double pi = std::acos(-1.0);
  for (const int nodes : {13, 41}) {  // dense, and by iteration
    const Scene scene = GridScene(nodes, nodes);
    const ClothModel model(scene);
    const Eigen::MatrixXd modes = SmoothModes(model, {}, 5);
    ASSERT_EQ(modes.cols(), 5);
    const Eigen::VectorXd values = Values(model, modes);
    const double a = pi * pi / 0.36, b = pi * pi / 0.16;
    const double expected[] = {0.0, a, b, a + b, 4.0 * a};
    for (int i = 0; i < 5; ++i) {
      EXPECT_NEAR(values[i], i == 2 ? std::min(b, 4.0 * a) : expected[i], 0.02 * a + 0.02 * expected[i])
          << nodes << " " << i;
    }
  }
}

TEST(SmoothModesTest, AreOrthonormalAndZeroWhereFixed) {
  const Scene scene = GridScene(18, 16);
  const ClothModel model(scene);
  const Eigen::MatrixXd modes = SmoothModes(model, {0, 17}, 30);
  EXPECT_TRUE(modes.row(0).isZero(0.0) && modes.row(17).isZero(0.0));
  const Eigen::MatrixXd gram = modes.transpose() * model.node_areas().asDiagonal() * modes / model.node_areas().sum();
  EXPECT_LE((gram - Eigen::MatrixXd::Identity(30, 30)).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_EQ(modes, SmoothModes(model, {0, 17}, 30)) << "the same every time";
  EXPECT_EQ(SmoothModes(model, {0}, 10000).cols(), 18 * 16 - 1);
}

}  // namespace
}  // namespace clothid::smooth_modes_test
