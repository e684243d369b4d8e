// A factorisation or a solution that runs out of memory ends in an error that says so: neither in numbers nor in the
// finding that the matrix is singular or not positive definite.
#include <SuiteSparse_config.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/matrix/cholesky.h"
#include "sim/matrix/fill_reducing_order.h"
#include "sim/matrix/lu.h"
#include "tests/sim/matrix/grid_matrix.h"

namespace clothid::out_of_memory_test {
namespace {

// SuiteSparse takes its memory from functions without an argument of our own, so they can reach nothing but a global.
int allocations_left = -1;  // until all fail; negative: none does

bool Fails() {
  if (allocations_left == 0) return true;
  if (allocations_left > 0) --allocations_left;
  return false;
}
void* Malloc(size_t size) { return Fails() ? nullptr : std::malloc(size); }
void* Calloc(size_t count, size_t size) { return Fails() ? nullptr : std::calloc(count, size); }
void* Realloc(void* memory, size_t size) { return Fails() ? nullptr : std::realloc(memory, size); }

class OutOfMemoryTest : public GridMatrixTest {
 protected:
  OutOfMemoryTest() : GridMatrixTest(8), matrix_(Matrix(0.0)), right_(Eigen::MatrixXd::Random(pattern_->size(), 3)) {
#if SUITESPARSE_MAIN_VERSION >= 7
    SuiteSparse_config_malloc_func_set(Malloc);
    SuiteSparse_config_calloc_func_set(Calloc);
    SuiteSparse_config_realloc_func_set(Realloc);
#else
    SuiteSparse_config.malloc_func = Malloc;
    SuiteSparse_config.calloc_func = Calloc;
    SuiteSparse_config.realloc_func = Realloc;
#endif
  }
  ~OutOfMemoryTest() override { allocations_left = -1; }

  // Lets `work` run out of memory at its first allocation, at its second, and so on until it ends. Returns how often
  // it was told. `work` itself looks at what it got.
  static int RunOutOfMemory(const std::string& routine, const std::function<void()>& work) {
    for (int num_told = 0;; ++num_told) {
      allocations_left = num_told;
      try {
        work();
        allocations_left = -1;
        return num_told;
      } catch (const std::runtime_error& error) {
        allocations_left = -1;
        EXPECT_NE(std::string(error.what()).find(routine), std::string::npos) << error.what();
        EXPECT_NE(std::string(error.what()).find("out of memory"), std::string::npos) << error.what();
      }
    }
  }

  void ExpectSolved(const Eigen::MatrixXd& solution) const {
    EXPECT_LT((matrix_.view() * solution - right_).norm(), 1e-12 * right_.norm());
  }

  BlockMatrix matrix_;
  Eigen::MatrixXd right_;
};

TEST_F(OutOfMemoryTest, CholeskySaysSo) {
  EXPECT_GT(RunOutOfMemory("cholmod_analyze", [this] { const CholeskySolver solver(pattern_); }), 2);
  // Those that failed leave nothing behind that would harm the next.
  CholeskySolver solver(pattern_);
  // Factors and solutions need no memory of SuiteSparse.
  Eigen::MatrixXd solution;
  const auto solve = [&] {
    const auto factor = solver.Factor(matrix_.values);
    ASSERT_NE(factor, nullptr);
    factor->Solve(right_, &solution);
    ExpectSolved(solution);
  };
  EXPECT_EQ(RunOutOfMemory("", solve), 0);
}

TEST_F(OutOfMemoryTest, LuSaysSo) {
  LuFactor factor(pattern_);
  const auto make_factor = [&] { EXPECT_TRUE(factor.Factor(matrix_.values)); };
  EXPECT_GT(RunOutOfMemory("umfpack_di_", make_factor), 2);
  Eigen::MatrixXd solution;
  const auto solve = [&] {
    factor.Solve(right_, &solution);
    ExpectSolved(solution);
  };
  EXPECT_GT(RunOutOfMemory("umfpack_di_solve", solve), 0);
}

TEST_F(OutOfMemoryTest, OrderingSaysSo) {
  std::vector<std::vector<int>> chain(50);
  for (int i = 1; i < 50; ++i) {
    chain[i].push_back(i - 1);
    chain[i - 1].push_back(i);
  }
  std::vector<int> order;
  EXPECT_GT(RunOutOfMemory("cholmod_analyze", [&] { order = FillReducingOrder(chain); }), 2);
  EXPECT_EQ(order.size(), chain.size());
}

}  // namespace
}  // namespace clothid::out_of_memory_test
