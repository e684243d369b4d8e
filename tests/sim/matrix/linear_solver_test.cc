// The factorisations from two threads at once, and GMRES on blocks of right-hand sides.
#include "sim/matrix/linear_solver.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <thread>
#include <vector>

#include "sim/matrix/block_product.h"

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
  CholeskySolver solver(pattern_);
  const auto factor = solver.Factor(matrix.values);
  ASSERT_NE(factor, nullptr);
  const Eigen::MatrixXd right = Eigen::MatrixXd::Random(pattern_->size(), 3);
  Eigen::MatrixXd solution;
  factor->Solve(right, &solution);
  EXPECT_LT((matrix.view() * solution - right).norm(), 1e-12 * right.norm());
  matrix.block(pattern_->Find(7, 7)) *= -1.0;
  EXPECT_EQ(solver.Factor(matrix.values), nullptr);
  matrix.values[0] = std::nan("");
  EXPECT_EQ(solver.Factor(matrix.values), nullptr);
}

TEST_F(LinearSolverTest, ProductsAreThoseOfTheMatrix) {
  const BlockMatrix matrix = Matrix(0.0);
  for (const int num_columns : {1, 2, 8, 20}) {
    const Eigen::MatrixXd columns = Eigen::MatrixXd::Random(pattern_->size(), num_columns);
    const Eigen::MatrixXd expected = matrix.view() * columns;
    EXPECT_LT((MultiplySymmetric(matrix, columns) - expected).norm(), 1e-14 * expected.norm()) << num_columns;
  }
}

TEST_F(LinearSolverTest, FactorsLiveSideBySideAndBeyondTheirSolver) {
  const BlockMatrix matrix = Matrix(0.0);
  const Eigen::VectorXd doubled = 2.0 * matrix.values;
  const Eigen::MatrixXd right = Eigen::MatrixXd::Random(pattern_->size(), 2);
  Eigen::MatrixXd solution, half;
  auto solver = std::make_unique<CholeskySolver>(pattern_);
  solver->Factor(matrix.values)->Solve(right, &solution);
  const auto first = solver->Factor(doubled);  // in the memory of the one that is gone
  const auto second = solver->Factor(matrix.values);
  solver.reset();
  first->Solve(right, &half);
  EXPECT_LT((2.0 * half - solution).norm(), 1e-12 * solution.norm());
  second->Solve(right, &half);
  EXPECT_EQ(half, solution);
  EXPECT_EQ(first->bytes(), second->bytes());
  EXPECT_GE(first->bytes(), sizeof(double) * pattern_->num_values() / 2);
}

// A hub and its neighbours: eliminated first the hub would join all of them, last it joins none.
TEST_F(LinearSolverTest, TheFillReducingOrderIsAPermutationThatReducesFill) {
  constexpr int kNodes = 100;
  std::vector<std::vector<int>> hub_first(kNodes), renumbered(kNodes);
  for (int node = 1; node < kNodes; ++node) {
    hub_first[0].push_back(node);
    hub_first[node].push_back(0);
  }
  const std::vector<int> order = FillReducingOrder(hub_first);
  std::vector<int> index(kNodes, -1);
  for (int k = 0; k < kNodes; ++k) index[order[k]] = k;
  ASSERT_EQ(std::count(index.begin(), index.end(), -1), 0);
  for (int node = 0; node < kNodes; ++node) {
    for (const int neighbour : hub_first[node]) renumbered[index[node]].push_back(index[neighbour]);
  }
  const auto factor_bytes = [](const std::vector<std::vector<int>>& neighbours) {
    BlockMatrix identity(std::make_shared<BlockPattern>(neighbours));
    for (int i = 0; i < kNodes; ++i) identity.block(identity.pattern().Find(i, i)).setIdentity();
    return CholeskySolver(identity.shared_pattern()).Factor(identity.values)->bytes();
  };
  EXPECT_LT(10 * factor_bytes(renumbered), factor_bytes(hub_first));
}

TEST(CholeskySolverTest, CountsTheWorkOfADenseMatrix) {
  const int num_blocks = 5, n = 3 * num_blocks;
  std::vector<std::vector<int>> neighbours(num_blocks);
  for (int i = 0; i < num_blocks; ++i) {
    for (int j = 0; j < num_blocks; ++j) {
      if (j != i) neighbours[i].push_back(j);
    }
  }
  const CholeskySolver solver(std::make_shared<BlockPattern>(neighbours));
  EXPECT_EQ(solver.num_entries(), n * (n + 1) / 2);
  EXPECT_EQ(solver.num_flops(), n * (n + 1) * (2 * n + 1) / 6);
}

TEST_F(LinearSolverTest, CompletesAMatrixFromItsLowerTriangle) {
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
  CholeskySolver solver(pattern_);
  const auto factor = solver.Factor(symmetric.values);
  ASSERT_NE(factor, nullptr);
  Eigen::MatrixXd right = Eigen::MatrixXd::Random(pattern_->size(), 4), solution;
  right.col(1).setZero();
  right.col(2) *= 1e-9;
  const auto precondition = [&](const Eigen::MatrixXd& v) {
    Eigen::MatrixXd result;
    factor->Solve(v, &result);
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

TEST_F(LinearSolverTest, ConjugateGradientsSolveAndMeetNegativeCurvature) {
  BlockMatrix matrix = Matrix(0.0);
  CholeskySolver solver(pattern_);
  const auto factor = solver.Factor(matrix.values);
  ASSERT_NE(factor, nullptr);
  const auto precondition = [&](const Eigen::VectorXd& v) -> Eigen::VectorXd {
    Eigen::MatrixXd result;
    factor->Solve(v, &result);
    return result;
  };
  const auto multiply = [&](const Eigen::VectorXd& v) -> Eigen::VectorXd { return matrix.view() * v; };
  const Eigen::VectorXd right = Eigen::VectorXd::Random(pattern_->size());
  Eigen::VectorXd solution;
  matrix.values *= 1.5;
  matrix.block(pattern_->Find(7, 7)) *= 2.0;  // so that the factor is one of another matrix
  ConjugateGradientResult result = ConjugateGradients(multiply, precondition, right, 1e-12, 20, &solution);
  EXPECT_TRUE(result.converged);
  EXPECT_GT(result.iterations, 1);
  EXPECT_LT((matrix.view() * solution - right).norm(), 1.1e-12 * right.norm());
  EXPECT_FALSE(ConjugateGradients(multiply, precondition, right, 1e-12, 1, &solution).converged);
  matrix.block(pattern_->Find(7, 7)) *= -1.0;
  result = ConjugateGradients(multiply, precondition, right, 1e-12, 20, &solution);
  EXPECT_TRUE(result.indefinite);
  EXPECT_FALSE(result.converged);
  result = ConjugateGradients(multiply, precondition, Eigen::VectorXd::Zero(right.size()), 1e-12, 20, &solution);
  EXPECT_TRUE(result.converged);
  EXPECT_EQ(solution.norm(), 0.0);
}

// Serial OpenBLAS shares buffers between threads; without turns this fails within a few solves.
TEST_F(LinearSolverTest, TwoThreadsGetTheNumbersOfOne) {
  const BlockMatrix matrix = Matrix(0.0);
  const Eigen::MatrixXd right = Eigen::MatrixXd::Random(pattern_->size(), 8);
  Eigen::MatrixXd expected;
  CholeskySolver reference(pattern_);
  reference.Factor(matrix.values)->Solve(right, &expected);
  std::vector<int> wrong(2, 0);
  const auto work = [&](int thread) {
    CholeskySolver solver(pattern_);
    Eigen::MatrixXd solution;
    for (int i = 0; i < 100; ++i) {
      solver.Factor(matrix.values)->Solve(right, &solution);
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
