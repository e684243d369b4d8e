// Solutions with a matrix that is not symmetric and with its transpose.
#include "sim/matrix/lu.h"

#include <gtest/gtest.h>

#include "tests/sim/matrix/grid_matrix.h"

namespace clothid::lu_test {
namespace {

using LuTest = GridMatrixTest;

TEST_F(LuTest, LuSolvesAndSolvesTransposed) {
  const BlockMatrix matrix = Matrix(0.5);
  LuFactor factor(pattern_);
  ASSERT_TRUE(factor.Factor(matrix.values));
  const Eigen::MatrixXd right = Eigen::MatrixXd::Random(pattern_->size(), 2);
  Eigen::MatrixXd solution;
  // `view` reads columns as rows, so it is the transpose of what LU factors.
  factor.Solve(right, &solution);
  EXPECT_LT((matrix.view().transpose() * solution - right).norm(), 1e-12 * right.norm());
  factor.SolveTransposed(right, &solution);
  EXPECT_LT((matrix.view() * solution - right).norm(), 1e-12 * right.norm());
  EXPECT_FALSE(factor.Factor(Eigen::VectorXd::Zero(pattern_->num_values())));
}

}  // namespace
}  // namespace clothid::lu_test
