// The finite elements that the energies share, against closed forms.
#include "sim/shell/triangle_element.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim/matrix/dense.h"
#include "tests/sim/shell/strained_grid.h"

namespace clothid::triangle_element_test {
namespace {

using TriangleElementTest = StrainedGridTest;

TEST_F(TriangleElementTest, AreasSumUpAndFillersHaveNone) {
  double area = 0.0;
  int num_triangles = 0, num_fillers = 0;
  for (const TriangleBatch& batch : *triangles_) {
    for (int lane = 0; lane < kLanes; ++lane) {
      area += batch.area[lane];
      (batch.area[lane] > 0.0 ? num_triangles : num_fillers) += 1;
      if (batch.area[lane] > 0.0) continue;
      for (const auto& blocks : batch.blocks) EXPECT_FALSE(blocks[lane].valid());
    }
  }
  EXPECT_NEAR(area, 0.06, 1e-15);
  EXPECT_EQ(num_triangles, mesh_.num_faces());
  EXPECT_EQ(num_fillers, 4);
}

// x = B X + b has the columns of B in the plane of the cloth as F, up to the axes that a triangle has in that plane.
TEST_F(TriangleElementTest, TheDeformationGradientOfAnAffineMapIsItsMatrix) {
  Eigen::Matrix3d map;
  map << 1.1, 0.2, 0.0, -0.3, 0.9, 0.0, 0.4, 0.1, 1.0;
  const Eigen::VectorXd mapped = ((map * mesh_.rest_positions).colwise() + Eigen::Vector3d(1.0, 2.0, 3.0)).reshaped();
  const Eigen::Matrix2d expected = (map.leftCols<2>().transpose() * map.leftCols<2>());
  for (const TriangleBatch& batch : *triangles_) {
    CornerVectors corners;
    GatherCorners(batch, mapped.data(), &corners);
    for (int lane = 0; lane < kLanes; ++lane) {
      const Symmetric2 metric = Metric(DeformationGradient(batch, corners, lane));
      EXPECT_NEAR(metric.m00 + metric.m11, expected.trace(), 1e-13);
      EXPECT_NEAR(metric.m00 * metric.m11 - metric.m01 * metric.m01, expected.determinant(), 1e-13);
    }
  }
}

TEST_F(TriangleElementTest, CornerForcesAreInBalanceAndTheTransposeOfTheGradient) {
  const TriangleBatch& batch = triangles_->front();
  CornerVectors corners, forces;
  GatherCorners(batch, positions_.data(), &corners);
  const Gradient stress = {{{1.0, -2.0, 0.5}, {0.3, 4.0, -1.0}}};
  for (int lane = 0; lane < kLanes; ++lane) {
    SetCornerForces(batch, 2.0, stress, lane, &forces);
    const Gradient f = DeformationGradient(batch, corners, lane);
    double work = 0.0, expected = 0.0;
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(forces.values[0][c][lane] + forces.values[1][c][lane] + forces.values[2][c][lane], 0.0, 1e-12);
      for (int i = 0; i < 3; ++i) work += forces.values[i][c][lane] * corners.values[i][c][lane];
      for (int k = 0; k < 2; ++k) expected += 2.0 * stress.column[k][c] * f.column[k][c];
    }
    EXPECT_NEAR(work, expected, 1e-12 * (1.0 + std::abs(expected)));
  }
}

// u^T L u of u = s . X is area |s|^2, the Dirichlet energy.
TEST_F(TriangleElementTest, TheLaplacianOfALinearFunction) {
  const Eigen::MatrixXd laplacian = LaplacianMatrix(*triangles_, mesh_.num_nodes());
  EXPECT_LT((laplacian - laplacian.transpose()).norm(), 1e-14);
  EXPECT_LT((laplacian * Eigen::VectorXd::Ones(mesh_.num_nodes())).norm(), 1e-13);
  const Eigen::VectorXd u = mesh_.rest_positions.transpose() * Eigen::Vector3d(2.0, -3.0, 0.0);
  EXPECT_NEAR(u.dot(laplacian * u), 0.06 * 13.0, 1e-13);
  EXPECT_LT((LaplacianDiagonal(*triangles_, mesh_.num_nodes()) - laplacian.diagonal()).norm(), 1e-14);
}

TEST_F(TriangleElementTest, ClampsEigenvaluesAlone) {
  Eigen::MatrixXd matrix(2, 2);
  matrix << 2.0, 1.5, 1.5, -1.0;
  const Spectrum spectrum = SymmetricSpectrum(matrix);
  ASSERT_LT(spectrum.values[0], 0.0);
  ASSERT_GT(spectrum.values[1], 2.5);
  const Eigen::Vector2d clamped_values(0.0, 2.5);
  const Eigen::Matrix2d expected = spectrum.vectors * clamped_values.asDiagonal() * spectrum.vectors.transpose();
  const Symmetric2 clamped = ClampEigenvalues({2.0, 1.5, -1.0}, 0.0, 2.5);
  EXPECT_NEAR(clamped.m00, expected(0, 0), 1e-14);
  EXPECT_NEAR(clamped.m01, expected(0, 1), 1e-14);
  EXPECT_NEAR(clamped.m11, expected(1, 1), 1e-14);
  const Symmetric2 multiple = ClampEigenvalues({3.0, 0.0, 3.0}, 0.0, 2.5);  // no direction of its own
  EXPECT_NEAR(multiple.m00, 2.5, 1e-14);
  EXPECT_NEAR(multiple.m01, 0.0, 1e-14);
  EXPECT_NEAR(multiple.m11, 2.5, 1e-14);
}

}  // namespace
}  // namespace clothid::triangle_element_test
