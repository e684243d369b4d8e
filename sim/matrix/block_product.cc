#include "sim/matrix/block_product.h"

#include <algorithm>
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

// The same for one column. A sum for every component of the entries, so that no sum waits for another.
void MultiplyOne(const double* values, const int* rows, int num_rows, const double* x, double* y) {
  for (int c = 0; c < 3; ++c, values += 3 * num_rows) {
    double sum0 = 0.0, sum1 = 0.0, sum2 = 0.0;
    for (int k = 0; k < num_rows; ++k) {
      const double* const entries = x + 3 * rows[k];
      sum0 += values[3 * k] * entries[0];
      sum1 += values[3 * k + 1] * entries[1];
      sum2 += values[3 * k + 2] * entries[2];
    }
    y[c] = sum0 + sum1 + sum2;
  }
}

}  // namespace

void MultiplySymmetric(const BlockMatrix& matrix, const Eigen::Ref<const Eigen::MatrixXd>& columns,
                       Eigen::MatrixXd* product) {
  const BlockPattern& pattern = matrix.pattern();
  const double* const values = matrix.values.data();
  product->resize(columns.rows(), columns.cols());
  if (columns.cols() == 1) {
    for (int i = 0; i < pattern.num_blocks(); ++i) {
      MultiplyOne(values + pattern.Position(i, 0).start, pattern.rows_begin(i), pattern.num_rows(i), columns.data(),
                  product->data() + 3 * i);
    }
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
