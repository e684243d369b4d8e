// Products of a block matrix with few columns and with many.
#include "sim/matrix/block_product.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <vector>

#include "tests/sim/matrix/grid_matrix.h"

namespace clothid::block_product_test {
namespace {

using BlockProductTest = GridMatrixTest;

TEST_F(BlockProductTest, ProductsAreThoseOfTheMatrix) {
  const BlockMatrix matrix = Matrix(0.0);
  for (const int num_columns : {1, 2, 4, 5, 8, 20}) {
    const Eigen::MatrixXd columns = Eigen::MatrixXd::Random(pattern_->size(), num_columns);
    const Eigen::MatrixXd expected = matrix.view() * columns;
    EXPECT_LT((MultiplySymmetric(matrix, columns) - expected).norm(), 1e-14 * expected.norm()) << num_columns;
  }
}

TEST(BlockProductOfOneTest, NeedsNoNeighbours) {
  BlockMatrix matrix(std::make_shared<BlockPattern>(std::vector<std::vector<int>>(1)));
  matrix.values.setLinSpaced(9, 1.0, 9.0);
  const Eigen::MatrixXd product = MultiplySymmetric(matrix, Eigen::Vector3d(1.0, 10.0, 100.0));
  EXPECT_EQ(product, Eigen::Vector3d(321.0, 654.0, 987.0));
  const BlockMatrix none(std::make_shared<BlockPattern>(std::vector<std::vector<int>>()));
  EXPECT_EQ(MultiplySymmetric(none, Eigen::VectorXd()).size(), 0);
}

class LargeBlockProductTest : public GridMatrixTest {
 protected:
  LargeBlockProductTest() : GridMatrixTest(70) {}
};

TEST_F(LargeBlockProductTest, ThreadsDoNotChangeAByte) {
  const BlockMatrix matrix = Matrix(0.0);
  for (const int num_columns : {1, 3, 9}) {
    const Eigen::MatrixXd columns = Eigen::MatrixXd::Random(pattern_->size(), num_columns);
    const Eigen::MatrixXd product = MultiplySymmetric(matrix, columns);
    for (const int num_threads : {2, 3}) {
      ThreadTeam team(num_threads);
      EXPECT_EQ(MultiplySymmetric(matrix, columns, &team), product);
    }
  }
}

// What a row has no entry for does not get into it, not even as 0 times infinity.
TEST_F(BlockProductTest, RowsSeeTheirEntriesAlone) {
  const BlockMatrix matrix = Matrix(0.0);
  for (const int node : {0, 21, 200, 399}) {
    Eigen::VectorXd column = Eigen::VectorXd::Ones(pattern_->size());
    column.segment<3>(3 * node).setConstant(std::numeric_limits<double>::infinity());
    const Eigen::MatrixXd product = MultiplySymmetric(matrix, column);
    int num_finite = 0;
    for (int i = 0; i < pattern_->num_blocks(); ++i) {
      const int* const rows = pattern_->rows_begin(i);
      const bool has_entry = std::find(rows, rows + pattern_->num_rows(i), node) != rows + pattern_->num_rows(i);
      EXPECT_EQ(product.middleRows<3>(3 * i).allFinite(), !has_entry) << i << " " << node;
      num_finite += !has_entry;
    }
    EXPECT_GT(num_finite, 390);
  }
}

}  // namespace
}  // namespace clothid::block_product_test
