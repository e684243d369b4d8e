// Supernodal factors and solves against dense ones, for patterns with supernodes of all sizes.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <memory>
#include <random>
#include <vector>

#include "sim/matrix/lanes.h"
#include "sim/matrix/supernodal_factor.h"
#include "sim/matrix/supernodal_solve.h"
#include "sim/matrix/supernodes.h"

namespace clothid {
namespace {

// A random symmetric positive definite matrix of `num_blocks` block columns: `num_edges` blocks anywhere below the
// diagonal, and a dense square of `num_dense` blocks at the end.
struct RandomMatrix {
  RandomMatrix(int num_blocks, int num_edges, int num_dense, unsigned seed) {
    std::mt19937 random(seed);
    std::vector<std::vector<int>> neighbours(num_blocks);
    const auto connect = [&](int i, int j) {
      neighbours[i].push_back(j);
      neighbours[j].push_back(i);
    };
    for (int e = 0; e < num_edges; ++e)
      connect(static_cast<int>(random() % num_blocks), static_cast<int>(random() % num_blocks));
    for (int i = num_blocks - num_dense; i < num_blocks; ++i) {
      for (int j = num_blocks - num_dense; j < i; ++j) connect(i, j);
    }
    pattern = std::make_shared<BlockPattern>(neighbours);
    dense = Eigen::MatrixXd::Zero(pattern->size(), pattern->size());
    std::uniform_real_distribution<double> entry(-1.0, 1.0);
    for (int column = 0; column < pattern->size(); ++column) {
      for (int k = pattern->outer()[column]; k < pattern->outer()[column + 1]; ++k) {
        if (pattern->inner()[k] > column) dense(pattern->inner()[k], column) = entry(random);
      }
    }
    dense += dense.transpose().eval();
    dense.diagonal() = dense.cwiseAbs().rowwise().sum().array() + 0.1;
    values.resize(pattern->num_values());
    for (int column = 0; column < pattern->size(); ++column) {
      for (int k = pattern->outer()[column]; k < pattern->outer()[column + 1]; ++k) {
        values[k] = dense(pattern->inner()[k], column);
      }
    }
  }

  std::shared_ptr<const BlockPattern> pattern;
  Eigen::MatrixXd dense;
  Eigen::VectorXd values;
};

// A chain (tiny supernodes), arrows, a dense matrix (a single one, of tall and of odd sizes), and between.
std::vector<RandomMatrix> Matrices() {
  std::vector<RandomMatrix> matrices;
  unsigned seed = 0;
  for (const int num_blocks : {1, 2, 3, 4, 5, 9, 40, 90}) {
    for (const double edges_per_block : {0.0, 0.7, 2.5}) {
      for (const double dense_share : {0.0, 0.4, 1.0}) {
        matrices.emplace_back(num_blocks, static_cast<int>(edges_per_block * num_blocks),
                              static_cast<int>(dense_share * num_blocks), ++seed);
      }
    }
  }
  return matrices;
}

// L as a dense matrix.
Eigen::MatrixXd DenseFactor(const Supernodes& supernodes, int size, const std::vector<double>& factor) {
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(size, size);
  for (int s = 0; s < supernodes.size(); ++s) {
    const double* value = factor.data() + supernodes.value_starts[s];
    const int* const rows = supernodes.rows.data() + supernodes.row_starts[s];
    for (int column = 3 * supernodes.columns[s]; column < 3 * supernodes.columns[s + 1]; ++column) {
      for (int i = 0; i < 3 * supernodes.num_rows(s); ++i) dense(3 * rows[i / 3] + i % 3, column) = *value++;
    }
  }
  dense.triangularView<Eigen::StrictlyUpper>().setZero();
  dense.diagonal() = dense.diagonal().cwiseInverse();
  return dense;
}

TEST(SupernodalTest, FactorsAndSolutionsAreThoseOfDenseMatrices) {
  for (const RandomMatrix& matrix : Matrices()) {
    const Supernodes supernodes(*matrix.pattern);
    const int size = matrix.pattern->size();
    std::vector<double> factor(NumFactorValues(supernodes));
    ASSERT_TRUE(FactorSupernodes(supernodes, *matrix.pattern, matrix.values.data(), factor.data()));
    const Eigen::LLT<Eigen::MatrixXd> reference(matrix.dense);
    const Eigen::MatrixXd l = reference.matrixL();
    EXPECT_LT((DenseFactor(supernodes, size, factor) - l).norm(), 1e-13 * l.norm()) << size;
    EXPECT_GE(supernodes.num_entries, 0.5 * matrix.pattern->num_values());
    for (int num_sides = 0; num_sides <= 19; ++num_sides) {
      const Eigen::MatrixXd right = Eigen::MatrixXd::Random(size, num_sides);
      Eigen::MatrixXd solution = right;
      SolveSupernodes(supernodes, factor.data(), solution, &solution);
      EXPECT_LE((solution - reference.solve(right)).norm(), 1e-13 * right.norm()) << size << " " << num_sides;
    }
  }
}

TEST(SupernodalTest, PatternsHaveSupernodesOfAllSizes) {
  int smallest = 100, largest = 0, most = 0;
  for (const RandomMatrix& matrix : Matrices()) {
    const Supernodes supernodes(*matrix.pattern);
    most = std::max(most, supernodes.size());
    for (int s = 0; s < supernodes.size(); ++s) {
      smallest = std::min(smallest, supernodes.num_columns(s));
      largest = std::max(largest, supernodes.num_columns(s));
    }
  }
  EXPECT_EQ(smallest, 1);
  EXPECT_EQ(largest, 90);
  EXPECT_GT(most, 20);
}

TEST(SupernodalTest, OneAmongManyRightHandSidesIsSolvedAlike) {
  const RandomMatrix matrix(40, 60, 10, 1);
  const Supernodes supernodes(*matrix.pattern);
  std::vector<double> factor(NumFactorValues(supernodes));
  ASSERT_TRUE(FactorSupernodes(supernodes, *matrix.pattern, matrix.values.data(), factor.data()));
  const Eigen::MatrixXd right = Eigen::MatrixXd::Random(matrix.pattern->size(), 17);
  Eigen::MatrixXd all, some;
  SolveSupernodes(supernodes, factor.data(), right, &all);
  for (int num_sides = 2; num_sides < 17; ++num_sides) {
    SolveSupernodes(supernodes, factor.data(), right.leftCols(num_sides), &some);
    EXPECT_EQ(some, all.leftCols(num_sides)) << num_sides;
  }
}

TEST(SupernodalTest, InstructionSetsRoundAlike) {
  if (BestInstructionSet() == InstructionSet::kCommon) GTEST_SKIP() << "this machine has no other";
  for (const RandomMatrix& matrix : Matrices()) {
    const Supernodes supernodes(*matrix.pattern);
    std::vector<double> common(NumFactorValues(supernodes)), best = common;
    ASSERT_TRUE(
        FactorSupernodes(supernodes, *matrix.pattern, matrix.values.data(), common.data(), InstructionSet::kCommon));
    ASSERT_TRUE(FactorSupernodes(supernodes, *matrix.pattern, matrix.values.data(), best.data()));
    ASSERT_EQ(common, best);
    for (const int num_sides : {1, 3, 7}) {
      const Eigen::MatrixXd right = Eigen::MatrixXd::Random(matrix.pattern->size(), num_sides);
      Eigen::MatrixXd of_common, of_best;
      SolveSupernodes(supernodes, common.data(), right, &of_common, InstructionSet::kCommon);
      SolveSupernodes(supernodes, common.data(), right, &of_best);
      EXPECT_EQ(of_common, of_best) << num_sides;
    }
  }
}

// Wherever the negative pivot is, in a supernode's first column or its last.
TEST(SupernodalTest, AnIndefiniteMatrixHasNoFactor) {
  const RandomMatrix matrix(9, 10, 5, 3);
  const Supernodes supernodes(*matrix.pattern);
  std::vector<double> factor(NumFactorValues(supernodes));
  for (int column = 0; column < matrix.pattern->size(); ++column) {
    Eigen::VectorXd values = matrix.values;
    for (int k = matrix.pattern->outer()[column]; k < matrix.pattern->outer()[column + 1]; ++k) {
      if (matrix.pattern->inner()[k] == column) values[k] = -1e-3;
    }
    EXPECT_FALSE(FactorSupernodes(supernodes, *matrix.pattern, values.data(), factor.data())) << column;
  }
  ASSERT_TRUE(FactorSupernodes(supernodes, *matrix.pattern, matrix.values.data(), factor.data()));
}

TEST(SupernodalTest, AnEmptyMatrixHasAnEmptySolution) {
  const BlockPattern pattern({});
  const Supernodes supernodes(pattern);
  EXPECT_EQ(supernodes.size(), 0);
  std::vector<double> factor(NumFactorValues(supernodes));
  EXPECT_TRUE(FactorSupernodes(supernodes, pattern, nullptr, factor.data()));
  for (const int num_sides : {0, 1, 3}) {
    Eigen::MatrixXd solution;
    SolveSupernodes(supernodes, factor.data(), Eigen::MatrixXd(0, num_sides), &solution);
    EXPECT_EQ(solution.rows(), 0);
    EXPECT_EQ(solution.cols(), num_sides);
  }
}

}  // namespace
}  // namespace clothid
