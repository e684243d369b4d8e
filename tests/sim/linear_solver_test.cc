// The factorisations from two threads at once, and GMRES on blocks of right-hand sides.
#include "sim/linear_solver.h"

#include <gtest/gtest.h>

#include <memory>
#include <thread>
#include <vector>

namespace clothid {
namespace {

// A diagonally dominant matrix on a grid of n x n blocks, as a cloth has it: symmetric, or with a skew part.
class LinearSolverTest : public ::testing::Test {
 protected:
  explicit LinearSolverTest(int n = 20) {
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

TEST_F(LinearSolverTest, CholeskySolvesAndTestsTheInertia) {
  BlockMatrix matrix = Matrix(0.0);
  CholeskyFactor factor(pattern_);
  ASSERT_TRUE(factor.Factor(matrix.values));
  const Eigen::MatrixXd right = Eigen::MatrixXd::Random(pattern_->size(), 3);
  Eigen::MatrixXd solution;
  factor.Solve(right, &solution);
  EXPECT_LT((matrix.view() * solution - right).norm(), 1e-12 * right.norm());
  matrix.block(pattern_->Find(7, 7)) *= -1.0;
  EXPECT_FALSE(factor.Factor(matrix.values));
  matrix.values[0] = std::nan("");
  EXPECT_FALSE(factor.Factor(matrix.values));
}

TEST_F(LinearSolverTest, LuSolvesAndSolvesTransposed) {
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

TEST_F(LinearSolverTest, GmresSolvesColumnsOfDifferentDifficulty) {
  const BlockMatrix matrix = Matrix(0.5), symmetric = Matrix(0.0);
  CholeskyFactor factor(pattern_);
  ASSERT_TRUE(factor.Factor(symmetric.values));
  Eigen::MatrixXd right = Eigen::MatrixXd::Random(pattern_->size(), 4), solution;
  right.col(1).setZero();
  right.col(2) *= 1e-9;
  const auto precondition = [&](const Eigen::MatrixXd& v) {
    Eigen::MatrixXd result;
    factor.Solve(v, &result);
    return result;
  };
  const auto multiply = [&](const Eigen::MatrixXd& v) -> Eigen::MatrixXd { return matrix.view() * v; };
  const GmresResult result = Gmres(multiply, precondition, right, 1e-11, 60, &solution);
  EXPECT_TRUE(result.converged);
  EXPECT_GT(result.iterations, 2);
  EXPECT_EQ(solution.col(1).norm(), 0.0);
  for (const int c : {0, 2, 3}) {
    EXPECT_LT((matrix.view() * solution.col(c) - right.col(c)).norm(), 1e-10 * right.col(c).norm()) << c;
  }
  EXPECT_FALSE(Gmres(multiply, precondition, right, 1e-11, 2, &solution).converged);
}

// Serial OpenBLAS shares buffers between threads; without turns this fails within a few solves.
TEST_F(LinearSolverTest, TwoThreadsGetTheNumbersOfOne) {
  const BlockMatrix matrix = Matrix(0.0);
  const Eigen::MatrixXd right = Eigen::MatrixXd::Random(pattern_->size(), 8);
  Eigen::MatrixXd expected;
  CholeskyFactor reference(pattern_);
  ASSERT_TRUE(reference.Factor(matrix.values));
  reference.Solve(right, &expected);
  std::vector<int> wrong(2, 0);
  const auto work = [&](int thread) {
    CholeskyFactor factor(pattern_);
    Eigen::MatrixXd solution;
    for (int i = 0; i < 100; ++i) {
      factor.Factor(matrix.values);
      factor.Solve(right, &solution);
      wrong[thread] += solution != expected;
    }
  };
  std::thread other(work, 1);
  work(0);
  other.join();
  EXPECT_EQ(wrong[0] + wrong[1], 0);
}

}  // namespace
}  // namespace clothid
