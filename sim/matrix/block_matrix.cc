#include "sim/matrix/block_matrix.h"

#include <algorithm>
#include <cstddef>

namespace clothid {

BlockPattern::BlockPattern(const std::vector<std::vector<int>>& neighbours) {
  const int n = static_cast<int>(neighbours.size());
  column_start_.push_back(0);
  outer_.push_back(0);
  for (int column = 0; column < n; ++column) {
    std::vector<int> rows = neighbours[column];
    rows.push_back(column);
    std::sort(rows.begin(), rows.end());
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
    for (int c = 0; c < 3; ++c) {
      for (const int row : rows) inner_.insert(inner_.end(), {3 * row, 3 * row + 1, 3 * row + 2});
      outer_.push_back(static_cast<int>(inner_.size()));
    }
    rows_.insert(rows_.end(), rows.begin(), rows.end());
    column_start_.push_back(static_cast<int>(rows_.size()));
  }
  for (int column = 0; column < n; ++column) {
    const int* begin = rows_begin(column);
    diagonal_.push_back(static_cast<int>(std::lower_bound(begin, begin + num_rows(column), column) - begin));
    for (int k = diagonal_[column] + 1; k < num_rows(column); ++k) {
      mirrored_.push_back({Position(column, k), Find(column, begin[k])});
    }
  }
}

BlockPosition BlockPattern::Find(int row, int column) const {
  const int* begin = rows_begin(column);
  const int* found = std::lower_bound(begin, begin + num_rows(column), row);
  return Position(column, static_cast<int>(found - begin));
}

void BlockMatrix::CompleteFromLower() {
  double* const all = values.data();
  for (const BlockPattern::MirroredBlock& block : pattern_->mirrored()) {
    const double* lower = all + block.lower.start;
    double* upper = all + block.upper.start;
    for (int r = 0; r < 3; ++r, ++lower, upper += block.upper.stride) {
      for (int c = 0; c < 3; ++c) upper[c] = lower[static_cast<std::ptrdiff_t>(c) * block.lower.stride];
    }
  }
  const double* entry = all;
  for (int column = 0; column < pattern_->num_blocks(); ++column) {
    Eigen::Matrix3d sum;
    for (int c = 0; c < 3; ++c) {
      double x = 0.0, y = 0.0, z = 0.0;
      for (const double* end = entry + 3 * pattern_->num_rows(column); entry != end; entry += 3) {
        x += entry[0];
        y += entry[1];
        z += entry[2];
      }
      sum.col(c) << x, y, z;
    }
    block(pattern_->Diagonal(column)) = -Eigen::Matrix3d(sum.selfadjointView<Eigen::Lower>());
  }
}

Eigen::Map<const Eigen::SparseMatrix<double, Eigen::RowMajor>> BlockMatrix::view() const {
  return {pattern_->size(),         pattern_->size(),         pattern_->num_values(),
          pattern_->outer().data(), pattern_->inner().data(), values.data()};
}

}  // namespace clothid
