// A pattern that takes over the order of the one before it gives the same solutions, and no factor that costs much
// more.
#include "sim/step/wide_pattern.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <vector>

#include "tests/sim/matrix/grid_matrix.h"

namespace clothid::wide_pattern_test {
namespace {

using Cliques = std::vector<std::array<int, 4>>;

class WidePatternTest : public GridMatrixTest {
 protected:
  // The matrix with a spring of stiffness 3 between any two blocks of a clique.
  BlockMatrix Coupled(const WidePattern& pattern, const Cliques& cliques) const {
    BlockMatrix wide = pattern.Widened(Matrix(0.0));
    for (const std::array<int, 4>& clique : cliques) {
      for (const int i : clique) {
        for (const int j : clique) {
          if (i < 0 || j <= i) continue;
          for (const int k : {i, j}) wide.block(wide.pattern().Diagonal(k)).diagonal().array() += 3.0;
          wide.block(wide.pattern().Find(i, j)).diagonal().array() -= 3.0;
          wide.block(wide.pattern().Find(j, i)).diagonal().array() -= 3.0;
        }
      }
    }
    return wide;
  }

  Eigen::MatrixXd Solution(const WidePattern& pattern, const Cliques& cliques) const {
    const BlockMatrix matrix = Coupled(pattern, cliques);
    const auto factor = pattern.Factor(matrix.values);
    EXPECT_NE(factor, nullptr);
    const Eigen::MatrixXd right = Eigen::VectorXd::LinSpaced(pattern_->size(), -1.0, 1.0);
    const Eigen::MatrixXd solution = pattern.Solve(*factor, right);
    EXPECT_LT((matrix.view() * solution - right).norm(), 1e-10 * right.norm());
    return solution;
  }
};

TEST_F(WidePatternTest, OrderOfTheOneBeforeGivesTheSameSolution) {
  const int last = pattern_->num_blocks() - 1;
  const Cliques first = {{0, last, last - 1, -1}}, second = {{1, last, last - 1, 2}};
  const WidePattern before(*pattern_, first, nullptr);
  EXPECT_TRUE(before.Covers(first));
  EXPECT_FALSE(before.Covers(second));
  const WidePattern fresh(*pattern_, second, nullptr), kept(*pattern_, second, &before);
  EXPECT_TRUE(kept.Covers(second));
  const Eigen::MatrixXd expected = Solution(fresh, second);
  EXPECT_LT((Solution(kept, second) - expected).norm(), 1e-10 * expected.norm());
  EXPECT_LE(kept.flops(), std::max(1.05 * before.flops(), fresh.flops()));
}

// As far couplings fill in far more than the narrow pattern did, the order is made anew.
TEST_F(WidePatternTest, MakesANewOrderWhereTheOldOneCostsMore) {
  const int n = pattern_->num_blocks();
  Cliques far;
  for (int i = 0; i + 1 < n; ++i) far.push_back({i, n - 1 - i, (7 * i) % n, (13 * i) % n});
  const WidePattern narrow(*pattern_, {}, nullptr), fresh(*pattern_, far, nullptr), wide(*pattern_, far, &narrow);
  EXPECT_GT(fresh.flops(), 2.0 * narrow.flops());
  EXPECT_EQ(wide.flops(), fresh.flops());
}

}  // namespace
}  // namespace clothid::wide_pattern_test
