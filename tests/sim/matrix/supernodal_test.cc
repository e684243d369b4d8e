// Supernodal factors and solves against dense ones, for patterns with supernodes of all sizes.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <memory>
#include <new>
#include <random>
#include <vector>

#include "sim/matrix/fill_reducing_order.h"
#include "sim/matrix/lanes.h"
#include "sim/matrix/supernodal_factor.h"
#include "sim/matrix/supernodal_solve.h"
#include "sim/matrix/supernodes.h"

namespace {

std::atomic<int> allocations_left{-1};  // with `new`, until all fail; negative: none does

}  // namespace

// Every form of `new` for a single object whose memory this `delete` may get; those of arrays and of greater alignment
// have a `delete` of their own. Not inline: GCC would take their malloc and free for another pair than new and delete.
[[gnu::noinline]] void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  int left = allocations_left;
  while (left > 0 && !allocations_left.compare_exchange_weak(left, left - 1)) {
  }
  return left == 0 ? nullptr : std::malloc(std::max<std::size_t>(size, 1));
}
[[gnu::noinline]] void* operator new(std::size_t size) {
  void* const memory = operator new(size, std::nothrow);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, const std::nothrow_t&) noexcept { std::free(memory); }

namespace clothid::supernodal_test {
namespace {

using Neighbours = std::vector<std::vector<int>>;

void Connect(int i, int j, Neighbours* neighbours) {
  (*neighbours)[i].push_back(j);
  (*neighbours)[j].push_back(i);
}

// Of `num_blocks` block columns: `num_edges` blocks anywhere below the diagonal, and a dense square of `num_dense`
// blocks at the end.
Neighbours RandomNeighbours(int num_blocks, int num_edges, int num_dense, unsigned seed) {
  std::mt19937 random(seed);
  Neighbours neighbours(num_blocks);
  const auto any = [&] { return static_cast<int>(random() % num_blocks); };
  for (int e = 0; e < num_edges; ++e) Connect(any(), any(), &neighbours);
  for (int i = num_blocks - num_dense; i < num_blocks; ++i) {
    for (int j = num_blocks - num_dense; j < i; ++j) Connect(i, j, &neighbours);
  }
  return neighbours;
}

// Of the nodes of a grid of n x n squares with one diagonal each, in the order that a cloth has them in.
Neighbours GridNeighbours(int n) {
  const auto node = [n](int row, int column) { return row * (n + 1) + column; };
  Neighbours grid((n + 1) * (n + 1)), neighbours(grid.size());
  for (int row = 0; row <= n; ++row) {
    for (int column = 0; column <= n; ++column) {
      if (row < n) Connect(node(row, column), node(row + 1, column), &grid);
      if (column < n) Connect(node(row, column), node(row, column + 1), &grid);
      if (row < n && column < n) Connect(node(row, column), node(row + 1, column + 1), &grid);
    }
  }
  const std::vector<int> order = FillReducingOrder(grid);
  std::vector<int> places(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) places[order[i]] = static_cast<int>(i);
  for (std::size_t i = 0; i < grid.size(); ++i) {
    for (const int j : grid[i]) neighbours[places[i]].push_back(places[j]);
  }
  return neighbours;
}

// A random symmetric positive definite matrix.
struct RandomMatrix {
  RandomMatrix(const Neighbours& neighbours, unsigned seed) {
    std::mt19937 random(seed);
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
        ++seed;
        matrices.emplace_back(RandomNeighbours(num_blocks, static_cast<int>(edges_per_block * num_blocks),
                                               static_cast<int>(dense_share * num_blocks), seed),
                              seed);
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
  const RandomMatrix matrix(RandomNeighbours(40, 60, 10, 1), 1);
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
    ASSERT_TRUE(FactorSupernodes(supernodes, *matrix.pattern, matrix.values.data(), common.data(), nullptr,
                                 InstructionSet::kCommon));
    ASSERT_TRUE(FactorSupernodes(supernodes, *matrix.pattern, matrix.values.data(), best.data()));
    ASSERT_EQ(common, best);
    for (const int num_sides : {1, 3, 7}) {
      const Eigen::MatrixXd right = Eigen::MatrixXd::Random(matrix.pattern->size(), num_sides);
      Eigen::MatrixXd of_common, of_best;
      SolveSupernodes(supernodes, common.data(), right, &of_common, nullptr, InstructionSet::kCommon);
      SolveSupernodes(supernodes, common.data(), right, &of_best);
      EXPECT_EQ(of_common, of_best) << num_sides;
    }
  }
}

// Wherever the negative pivot is, in a supernode's first column or its last.
TEST(SupernodalTest, AnIndefiniteMatrixHasNoFactor) {
  const RandomMatrix matrix(RandomNeighbours(9, 10, 5, 3), 3);
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

// A matrix whose factor has branches, however small it is.
class BranchesTest : public ::testing::Test {
 protected:
  std::vector<double> FactorOf(const Eigen::VectorXd& values, ThreadTeam* team, bool* is_positive) const {
    std::vector<double> factor(NumFactorValues(supernodes_));
    *is_positive = FactorSupernodes(supernodes_, *matrix_.pattern, values.data(), factor.data(), team);
    return factor;
  }

  const RandomMatrix matrix_{GridNeighbours(20), 1};
  const Supernodes supernodes_{*matrix_.pattern, 0.0};
};

TEST_F(BranchesTest, EverySupernodeIsInABranchOrInTheTrunk) {
  ASSERT_GE(supernodes_.branches.size(), 8u);
  std::vector<int> found = supernodes_.trunk;
  double largest = 0.0;
  for (const Supernodes::Range& branch : supernodes_.branches) {
    double entries = 0.0;
    for (int s = branch.first; s < branch.last; ++s) {
      found.push_back(s);
      entries += supernodes_.num_rows(s) * supernodes_.num_columns(s);
      for (int u = supernodes_.update_starts[s]; u < supernodes_.update_starts[s + 1]; ++u) {
        EXPECT_GE(supernodes_.updates[u].source, branch.first) << s;
      }
    }
    largest = std::max(largest, entries);
  }
  std::sort(found.begin(), found.end());
  for (int s = 0; s < supernodes_.size(); ++s) EXPECT_EQ(found[s], s);
  ASSERT_EQ(static_cast<int>(found.size()), supernodes_.size());
  const Supernodes whole(*matrix_.pattern);
  EXPECT_LE(9.0 * largest, 0.125 * static_cast<double>(whole.value_starts.back()));
  EXPECT_TRUE(whole.branches.empty());
}

TEST_F(BranchesTest, FactorsAndSolutionsAreThoseOfDenseMatrices) {
  bool is_positive = false;
  const std::vector<double> factor = FactorOf(matrix_.values, nullptr, &is_positive);
  ASSERT_TRUE(is_positive);
  const Eigen::LLT<Eigen::MatrixXd> reference(matrix_.dense);
  const Eigen::MatrixXd l = reference.matrixL();
  EXPECT_LT((DenseFactor(supernodes_, matrix_.pattern->size(), factor) - l).norm(), 1e-13 * l.norm());
  for (const int num_sides : {1, 2, 7, 9}) {
    const Eigen::MatrixXd right = Eigen::MatrixXd::Random(matrix_.pattern->size(), num_sides);
    Eigen::MatrixXd solution;
    SolveSupernodes(supernodes_, factor.data(), right, &solution);
    EXPECT_LE((solution - reference.solve(right)).norm(), 1e-13 * right.norm()) << num_sides;
  }
}

TEST_F(BranchesTest, ThreadsDoNotChangeAByte) {
  bool is_positive = false;
  const std::vector<double> factor = FactorOf(matrix_.values, nullptr, &is_positive);
  const std::vector<float> single(factor.begin(), factor.end());
  for (const int num_threads : {2, 3, 8}) {
    ThreadTeam team(num_threads);
    EXPECT_EQ(FactorOf(matrix_.values, &team, &is_positive), factor) << num_threads;
    EXPECT_TRUE(is_positive);
    for (const int num_sides : {1, 3, 8}) {
      const Eigen::MatrixXd right = Eigen::MatrixXd::Random(matrix_.pattern->size(), num_sides);
      Eigen::MatrixXd alone, shared;
      SolveSupernodes(supernodes_, factor.data(), right, &alone);
      SolveSupernodes(supernodes_, factor.data(), right, &shared, &team);
      EXPECT_EQ(alone, shared) << num_threads << " " << num_sides;
      SolveSupernodes(supernodes_, single.data(), right, &alone);
      SolveSupernodes(supernodes_, single.data(), right, &shared, &team);
      EXPECT_EQ(alone, shared) << num_threads << " " << num_sides;
    }
  }
}

// Whichever task it is that finds none: it is told, and no thread waits for what does not come.
TEST_F(BranchesTest, MemoryThatRunsOutIsTold) {
  ThreadTeam team(3);
  bool is_positive = false;
  const std::vector<double> expected = FactorOf(matrix_.values, nullptr, &is_positive);
  std::vector<double> factor(expected.size());
  const Eigen::MatrixXd right = Eigen::MatrixXd::Random(matrix_.pattern->size(), 1);
  Eigen::MatrixXd solution = right;
  const auto solve = [&] {
    FactorSupernodes(supernodes_, *matrix_.pattern, matrix_.values.data(), factor.data(), &team);
    SolveSupernodes(supernodes_, factor.data(), right, &solution, &team);
  };
  int num_told = 0;
  for (bool is_solved = false; !is_solved;) {
    allocations_left = num_told;
    try {
      solve();
      is_solved = true;
    } catch (const std::bad_alloc&) {
      ++num_told;
    }
    allocations_left = -1;
  }
  EXPECT_EQ(factor, expected);
  EXPECT_GT(num_told, static_cast<int>(supernodes_.branches.size()));
}

// Wherever the negative pivot is, in a branch or in the trunk: no thread waits for what does not come.
TEST_F(BranchesTest, AnIndefiniteMatrixHasNoFactor) {
  ThreadTeam team(2);
  for (int column = 0; column < matrix_.pattern->size(); column += 7) {
    Eigen::VectorXd values = matrix_.values;
    for (int k = matrix_.pattern->outer()[column]; k < matrix_.pattern->outer()[column + 1]; ++k) {
      if (matrix_.pattern->inner()[k] == column) values[k] = -1e-3;
    }
    bool is_positive = true;
    FactorOf(values, &team, &is_positive);
    EXPECT_FALSE(is_positive) << column;
  }
}

TEST(SupernodalTest, AnyOrderIsFactored) {
  ThreadTeam team(2);
  for (const RandomMatrix& matrix : Matrices()) {
    const Supernodes supernodes(*matrix.pattern, 0.0);
    std::vector<double> factor(NumFactorValues(supernodes));
    ASSERT_TRUE(FactorSupernodes(supernodes, *matrix.pattern, matrix.values.data(), factor.data(), &team));
    const Eigen::VectorXd right = Eigen::VectorXd::Random(matrix.pattern->size());
    Eigen::MatrixXd solution;
    SolveSupernodes(supernodes, factor.data(), right, &solution, &team);
    EXPECT_LE((matrix.dense * solution - right).norm(), 1e-12 * right.norm());
  }
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
}  // namespace clothid::supernodal_test
