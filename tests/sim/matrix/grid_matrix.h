// What tests of sparse matrices and their solvers start from.
#ifndef CLOTHID_TESTS_SIM_MATRIX_GRID_MATRIX_H_
#define CLOTHID_TESTS_SIM_MATRIX_GRID_MATRIX_H_

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "sim/matrix/block_matrix.h"

namespace clothid {

// A diagonally dominant matrix on a grid of n x n blocks, as a cloth has it: symmetric, or with a skew part.
class GridMatrixTest : public ::testing::Test {
 protected:
  explicit GridMatrixTest(int n = 20) {
    std::vector<std::vector<int>> neighbours(n * n);
    for (int i = 0; i < n * n; ++i) {
      for (const int j : {i - n - 1, i - n, i - 1, i + 1, i + n, i + n + 1}) {
        if (j < 0 || j >= n * n) continue;
        neighbours[i].push_back(j);
        neighbours[j].push_back(i);
      }
    }
    pattern_ = std::make_shared<BlockPattern>(neighbours);
  }

  BlockMatrix Matrix(double skew) const {
    BlockMatrix matrix(pattern_);
    for (int column = 0; column < pattern_->num_blocks(); ++column) {
      for (int k = 0; k < pattern_->num_rows(column); ++k) {
        const int row = pattern_->rows_begin(column)[k];
        const Eigen::Matrix3d sign = skew * Eigen::Matrix3d::Identity() * (row < column ? 1.0 : -1.0);
        matrix.block(pattern_->Position(column, k)) = row == column
                                                          ? Eigen::Matrix3d(20.0 * Eigen::Matrix3d::Identity())
                                                          : Eigen::Matrix3d(-0.3 * Eigen::Matrix3d::Ones() + sign);
      }
    }
    return matrix;
  }

  std::shared_ptr<const BlockPattern> pattern_;
};

}  // namespace clothid

#endif  // CLOTHID_TESTS_SIM_MATRIX_GRID_MATRIX_H_
