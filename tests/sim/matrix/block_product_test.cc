// Products of a block matrix with few columns and with many.
#include "sim/matrix/block_product.h"

#include <gtest/gtest.h>

#include "tests/sim/matrix/grid_matrix.h"

namespace clothid {
namespace {

using BlockProductTest = GridMatrixTest;

TEST_F(BlockProductTest, ProductsAreThoseOfTheMatrix) {
  const BlockMatrix matrix = Matrix(0.0);
  for (const int num_columns : {1, 2, 8, 20}) {
    const Eigen::MatrixXd columns = Eigen::MatrixXd::Random(pattern_->size(), num_columns);
    const Eigen::MatrixXd expected = matrix.view() * columns;
    EXPECT_LT((MultiplySymmetric(matrix, columns) - expected).norm(), 1e-14 * expected.norm()) << num_columns;
  }
}

}  // namespace
}  // namespace clothid
