// Block matrices that are assembled in part.
#include "sim/matrix/block_matrix.h"

#include <gtest/gtest.h>

#include "tests/sim/matrix/grid_matrix.h"

namespace clothid::block_matrix_test {
namespace {

using BlockMatrixTest = GridMatrixTest;

TEST_F(BlockMatrixTest, CompletesAMatrixFromItsLowerTriangle) {
  BlockMatrix matrix = Matrix(0.0);
  matrix.values.setRandom();
  const Eigen::Matrix3d outside = matrix.block(pattern_->Diagonal(5));
  matrix.CompleteFromLower();
  const Eigen::MatrixXd dense = matrix.view();
  EXPECT_EQ((dense - dense.transpose()).norm(), 0.0);
  Eigen::Matrix3d sum = outside;
  for (int k = 0; k < pattern_->num_rows(5); ++k) sum += matrix.block(pattern_->Position(5, k));
  EXPECT_LT(Eigen::Matrix3d(sum.triangularView<Eigen::Lower>()).norm(), 1e-13);
}

}  // namespace
}  // namespace clothid::block_matrix_test
