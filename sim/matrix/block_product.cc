#include "sim/matrix/block_product.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <memory>

#include "sim/base/vector_clones.h"
#include "sim/matrix/lanes.h"

namespace clothid {
namespace {

// Shares of a product that every thread has, for threads that are late.
constexpr int kSharesEach = 4;

// The block rows `range` of a product with Sides::kSize columns, which stand beside each other in the rows of `x` and
// `y`. The matrix is symmetric, so a column is read as its row: the values of a block column are three scalar columns,
// each with three entries for every block.
template <typename Sides>
CLOTHID_ALWAYS_INLINE void MultiplyBeside(const BlockPattern& pattern, const BlockColumns& range, const double* values,
                                          const double* x, double* y) {
  constexpr int kSides = Sides::kSize;
  y += 3 * kSides * static_cast<std::ptrdiff_t>(range.first);
  for (int i = range.first; i < range.last; ++i, y += 3 * kSides) {
    const int num_rows = pattern.num_rows(i);
    const int* const rows = pattern.rows_begin(i);
    const double* const columns = values + pattern.Position(i, 0).start;
    Sides sums[3], entries;
    CLOTHID_UNROLL
    for (int c = 0; c < 3; ++c) sums[c].SetZero();
    for (int k = 0; k < num_rows; ++k) {
      const double* const x_rows = x + 3 * kSides * static_cast<std::ptrdiff_t>(rows[k]);
      CLOTHID_UNROLL
      for (int r = 0; r < 3; ++r) {
        entries.Load(x_rows + kSides * r);
        CLOTHID_UNROLL
        for (int c = 0; c < 3; ++c) sums[c].AddProduct(entries, columns[3 * (c * num_rows + k) + r]);
      }
    }
    CLOTHID_UNROLL
    for (int c = 0; c < 3; ++c) sums[c].Store(y + kSides * c);
  }
}

using Kernel = void (*)(const BlockPattern& pattern, const BlockColumns& range, const double* values, const double* x,
                        double* y);

template <typename Sides>
void MultiplyByCommon(const BlockPattern& pattern, const BlockColumns& range, const double* values, const double* x,
                      double* y) {
  MultiplyBeside<Sides>(pattern, range, values, x, y);
}

#if CLOTHID_HAS_AVX2
template <typename Sides>
CLOTHID_AVX2 void MultiplyByAvx2(const BlockPattern& pattern, const BlockColumns& range, const double* values,
                                 const double* x, double* y) {
  MultiplyBeside<Sides>(pattern, range, values, x, y);
}
#endif

struct Kernels {
  Kernel four, eight;
};

Kernels BestKernels() {
#if CLOTHID_HAS_AVX2
  using Best = Avx2Lanes<double>;
  if (BestInstructionSet() == InstructionSet::kAvx2) {
    return {MultiplyByAvx2<Best::Four>, MultiplyByAvx2<Best::Eight>};
  }
#endif
  using Common = CommonLanes<double>;
  return {MultiplyByCommon<Common::Four>, MultiplyByCommon<Common::Eight>};
}

// Three components and one to spare.
typedef double Quad __attribute__((vector_size(4 * sizeof(double))));

CLOTHID_ALWAYS_INLINE void AddProduct(const double* values, const Quad& entries, Quad* sum) {
  Quad loaded;
  std::memcpy(&loaded, values, sizeof(loaded));
  *sum += loaded * entries;
}

// The same for one column. A sum for every component of the entries, in a lane of its own; what the fourth lane sums up
// belongs to the next entry and is not used. So one entry behind `values` and `x` is read.
CLOTHID_VECTOR_CLONES void MultiplyOne(const double* values, const int* rows, int num_rows, const double* x,
                                       double* y) {
  const double* const columns[3] = {values, values + 3 * num_rows, values + 6 * num_rows};
  Quad sum0 = {}, sum1 = {}, sum2 = {};
  for (int k = 0; k < num_rows; ++k) {
    Quad entries;
    std::memcpy(&entries, x + 3 * rows[k], sizeof(entries));
    AddProduct(columns[0] + 3 * k, entries, &sum0);
    AddProduct(columns[1] + 3 * k, entries, &sum1);
    AddProduct(columns[2] + 3 * k, entries, &sum2);
  }
  y[0] = sum0[0] + sum0[1] + sum0[2];
  y[1] = sum1[0] + sum1[1] + sum1[2];
  y[2] = sum2[0] + sum2[1] + sum2[2];
}

// With one column.
void MultiplyVector(const BlockMatrix& matrix, ThreadTeam* team, const double* vector, double* product) {
  const BlockPattern& pattern = matrix.pattern();
  const auto size = static_cast<std::size_t>(pattern.size());
  if (size == 0) return;
  const double* const values = matrix.values.data();
  const std::unique_ptr<double[]> x(new double[size + 1]);
  std::copy_n(vector, size, x.get());
  x[size] = 0.0;
  const int last = pattern.num_blocks() - 1;
  const auto multiply = [&](const BlockColumns& range) {
    for (int i = range.first; i < std::min(range.last, last); ++i) {
      MultiplyOne(values + pattern.Position(i, 0).start, pattern.rows_begin(i), pattern.num_rows(i), x.get(),
                  product + 3 * i);
    }
  };
  ForColumns(pattern, team, multiply, kSharesEach);
  const std::size_t num_values = 9 * static_cast<std::size_t>(pattern.num_rows(last));
  const std::unique_ptr<double[]> last_values(new double[num_values + 1]);
  std::copy_n(values + pattern.Position(last, 0).start, num_values, last_values.get());
  last_values[num_values] = 0.0;
  MultiplyOne(last_values.get(), pattern.rows_begin(last), pattern.num_rows(last), x.get(), product + 3 * last);
}

}  // namespace

void MultiplySymmetric(const BlockMatrix& matrix, const Eigen::Ref<const Eigen::MatrixXd>& columns,
                       Eigen::MatrixXd* product, ThreadTeam* team) {
  const BlockPattern& pattern = matrix.pattern();
  const double* const values = matrix.values.data();
  product->resize(columns.rows(), columns.cols());
  if (columns.cols() == 1) {
    MultiplyVector(matrix, team, columns.data(), product->data());
    return;
  }
  const Kernels kernels = BestKernels();
  for (Eigen::Index first = 0; first < columns.cols(); first += 8) {
    const Eigen::Index width = std::min<Eigen::Index>(8, columns.cols() - first), sides = width > 4 ? 8 : 4;
    Eigen::MatrixXd x = Eigen::MatrixXd::Zero(sides, columns.rows()), y(sides, columns.rows());
    x.topRows(width) = columns.middleCols(first, width).transpose();
    const Kernel kernel = sides > 4 ? kernels.eight : kernels.four;
    const auto multiply = [&](const BlockColumns& range) { kernel(pattern, range, values, x.data(), y.data()); };
    ForColumns(pattern, team, multiply, kSharesEach);
    product->middleCols(first, width) = y.topRows(width).transpose();
  }
}

Eigen::MatrixXd MultiplySymmetric(const BlockMatrix& matrix, const Eigen::Ref<const Eigen::MatrixXd>& columns,
                                  ThreadTeam* team) {
  Eigen::MatrixXd product;
  MultiplySymmetric(matrix, columns, &product, team);
  return product;
}

}  // namespace clothid
