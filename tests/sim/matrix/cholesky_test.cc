// The supernodal factorisation: solutions, inertia, factors side by side and in two threads at once.
#include "sim/matrix/cholesky.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <limits>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "tests/sim/matrix/grid_matrix.h"

namespace clothid::cholesky_test {
namespace {

using CholeskyTest = GridMatrixTest;

// Factored within microseconds, so that threads meet often.
class SmallCholeskyTest : public GridMatrixTest {
 protected:
  SmallCholeskyTest() : GridMatrixTest(3) {}
};

TEST_F(CholeskyTest, CholeskySolvesAndTestsTheInertia) {
  BlockMatrix matrix = Matrix(0.0);
  CholeskySolver solver(pattern_);
  const auto factor = solver.Factor(matrix.values);
  ASSERT_NE(factor, nullptr);
  const Eigen::MatrixXd right = Eigen::MatrixXd::Random(pattern_->size(), 3);
  Eigen::MatrixXd solution;
  factor->Solve(right, &solution);
  EXPECT_LT((matrix.view() * solution - right).norm(), 1e-12 * right.norm());
  factor->Solve(right.leftCols(0), &solution);
  EXPECT_EQ(solution.rows(), pattern_->size());
  EXPECT_EQ(solution.cols(), 0);
  matrix.block(pattern_->Find(7, 7)) *= -1.0;
  EXPECT_EQ(solver.Factor(matrix.values), nullptr);
  matrix.values[0] = std::nan("");
  EXPECT_EQ(solver.Factor(matrix.values), nullptr);
}

TEST_F(CholeskyTest, FactorsLiveSideBySideAndBeyondTheirSolver) {
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

TEST_F(CholeskyTest, SinglePrecisionIsNearTheSolutionAtAnyScale) {
  const BlockMatrix matrix = Matrix(0.0);
  CholeskySolver solver(pattern_);
  const auto factor = solver.Factor(matrix.values);
  SinglePrecisionFactor single;
  single.Set(factor);
  Eigen::MatrixXd right = Eigen::MatrixXd::Random(pattern_->size(), 6), expected, solution;
  right.col(1) *= 1e-100;
  right.col(2) *= 1e100;
  right.col(3).setZero();
  right.col(4).tail(pattern_->size() - 1).setZero();
  for (const int num_columns : {1, 3, 6}) {
    factor->Solve(right.leftCols(num_columns), &expected);
    single.Solve(right.leftCols(num_columns), &solution);
    for (int c = 0; c < num_columns; ++c) {
      EXPECT_LE((solution.col(c) - expected.col(c)).norm(), 1e-6 * expected.col(c).norm()) << c;
    }
  }
  EXPECT_TRUE(solution.col(3).isZero(0.0));
  const auto other = solver.Factor(4.0 * matrix.values);
  single.Set(other);
  single.Solve(right.leftCols(1), &solution);
  EXPECT_LE((4.0 * solution - expected.leftCols(1)).norm(), 1e-6 * expected.col(0).norm());
}

// Numbers below the smallest normal one are zeros within a solve in single precision, and nowhere else.
TEST_F(CholeskyTest, SinglePrecisionLeavesTheProcessorAsItWas) {
  const BlockMatrix matrix = Matrix(0.0);
  CholeskySolver solver(pattern_);
  SinglePrecisionFactor single;
  single.Set(solver.Factor(matrix.values));
  Eigen::MatrixXd solution;
  single.Solve(Eigen::MatrixXd::Random(pattern_->size(), 1), &solution);
  const volatile double smallest = std::numeric_limits<double>::min();
  EXPECT_GT(0.5 * smallest, 0.0);
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

// With a solver each, and with one for both.
TEST_F(CholeskyTest, TwoThreadsGetTheNumbersOfOne) {
  const BlockMatrix matrix = Matrix(0.0);
  const Eigen::MatrixXd right = Eigen::MatrixXd::Random(pattern_->size(), 8);
  Eigen::MatrixXd expected;
  CholeskySolver shared(pattern_);
  const auto shared_factor = shared.Factor(matrix.values);
  shared_factor->Solve(right, &expected);
  std::vector<int> wrong(2, 0);
  const auto work = [&](int thread) {
    CholeskySolver own(pattern_);
    Eigen::MatrixXd solution;
    for (int i = 0; i < 100; ++i) {
      for (const auto& factor : {own.Factor(matrix.values), shared.Factor(matrix.values), shared_factor}) {
        factor->Solve(right, &solution);
        wrong[thread] += solution != expected;
      }
    }
  };
  std::thread other(work, 1);
  work(0);
  other.join();
  EXPECT_EQ(wrong[0] + wrong[1], 0);
}

// Rollouts that kept their factors may end in a thread of their own, while the solver goes on.
TEST_F(SmallCholeskyTest, FactorsMayEndInAnotherThread) {
  const BlockMatrix matrix = Matrix(0.0);
  const Eigen::MatrixXd right = Eigen::MatrixXd::Random(pattern_->size(), 1);
  Eigen::MatrixXd expected, solution;
  CholeskySolver solver(pattern_);
  solver.Factor(matrix.values)->Solve(right, &expected);
  std::mutex mutex;
  std::vector<std::shared_ptr<const CholeskyFactor>> kept;
  std::atomic<bool> done{false};
  std::thread other([&] {
    while (!done) {
      std::vector<std::shared_ptr<const CholeskyFactor>> ending;
      const std::lock_guard<std::mutex> lock(mutex);
      ending.swap(kept);
    }
  });
  int wrong = 0;
  for (int i = 0; i < 20000; ++i) {
    auto factor = solver.Factor(matrix.values);
    factor->Solve(right, &solution);
    wrong += solution != expected;
    const std::lock_guard<std::mutex> lock(mutex);
    kept.push_back(std::move(factor));
  }
  done = true;
  other.join();
  EXPECT_EQ(wrong, 0);
}

}  // namespace
}  // namespace clothid::cholesky_test
