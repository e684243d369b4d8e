#include "sim/matrix/block_product.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <memory>

#include "sim/base/vector_clones.h"

namespace clothid {
namespace {

// Columns that are multiplied at once.
constexpr int kWidth = 8;
typedef double Lanes __attribute__((vector_size(kWidth * sizeof(double))));

// One block row of a product. The matrix is symmetric, so its column is read as its row: `values` holds its three
// scalar columns, each with 3 `num_rows` entries; entry 3 k + r belongs to row 3 rows[k] + r of `x`.
CLOTHID_VECTOR_CLONES void MultiplyLanes(const double* values, const int* rows, int num_rows, const Lanes* x,
                                         Lanes* y) {
  const double* const columns[3] = {values, values + 3 * num_rows, values + 6 * num_rows};
  Lanes sum0 = {}, sum1 = {}, sum2 = {};
  for (int k = 0; k < num_rows; ++k) {
    const Lanes* const x_rows = x + 3 * rows[k];
    for (int r = 0; r < 3; ++r) {
      sum0 += columns[0][3 * k + r] * x_rows[r];
      sum1 += columns[1][3 * k + r] * x_rows[r];
      sum2 += columns[2][3 * k + r] * x_rows[r];
    }
  }
  y[0] = sum0;
  y[1] = sum1;
  y[2] = sum2;
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
void MultiplyVector(const BlockMatrix& matrix, const double* vector, double* product) {
  const BlockPattern& pattern = matrix.pattern();
  const auto size = static_cast<std::size_t>(pattern.size());
  if (size == 0) return;
  const double* const values = matrix.values.data();
  const std::unique_ptr<double[]> x(new double[size + 1]);
  std::copy_n(vector, size, x.get());
  x[size] = 0.0;
  const int last = pattern.num_blocks() - 1;
  for (int i = 0; i < last; ++i) {
    MultiplyOne(values + pattern.Position(i, 0).start, pattern.rows_begin(i), pattern.num_rows(i), x.get(),
                product + 3 * i);
  }
  const std::size_t num_values = 9 * static_cast<std::size_t>(pattern.num_rows(last));
  const std::unique_ptr<double[]> last_values(new double[num_values + 1]);
  std::copy_n(values + pattern.Position(last, 0).start, num_values, last_values.get());
  last_values[num_values] = 0.0;
  MultiplyOne(last_values.get(), pattern.rows_begin(last), pattern.num_rows(last), x.get(), product + 3 * last);
}

}  // namespace

void MultiplySymmetric(const BlockMatrix& matrix, const Eigen::Ref<const Eigen::MatrixXd>& columns,
                       Eigen::MatrixXd* product) {
  const BlockPattern& pattern = matrix.pattern();
  const double* const values = matrix.values.data();
  product->resize(columns.rows(), columns.cols());
  if (columns.cols() == 1) {
    MultiplyVector(matrix, columns.data(), product->data());
    return;
  }
  const Eigen::Index size = columns.rows();
  const std::unique_ptr<Lanes[]> x(new Lanes[size]), y(new Lanes[size]);
  for (Eigen::Index first = 0; first < columns.cols(); first += kWidth) {
    const int width = static_cast<int>(std::min<Eigen::Index>(kWidth, columns.cols() - first));
    for (Eigen::Index row = 0; row < size; ++row) {
      for (int c = 0; c < kWidth; ++c) x[row][c] = c < width ? columns(row, first + c) : 0.0;
    }
    for (int i = 0; i < pattern.num_blocks(); ++i) {
      MultiplyLanes(values + pattern.Position(i, 0).start, pattern.rows_begin(i), pattern.num_rows(i), x.get(),
                    y.get() + 3 * i);
    }
    for (int c = 0; c < width; ++c) {
      for (Eigen::Index row = 0; row < size; ++row) (*product)(row, first + c) = y[row][c];
    }
  }
}

Eigen::MatrixXd MultiplySymmetric(const BlockMatrix& matrix, const Eigen::Ref<const Eigen::MatrixXd>& columns) {
  Eigen::MatrixXd product;
  MultiplySymmetric(matrix, columns, &product);
  return product;
}

}  // namespace clothid
