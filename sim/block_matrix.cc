#include "sim/block_matrix.h"

#include <algorithm>

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
}

BlockPosition BlockPattern::Find(int row, int column) const {
  const int* begin = rows_begin(column);
  const int* found = std::lower_bound(begin, begin + num_rows(column), row);
  return Position(column, static_cast<int>(found - begin));
}

Eigen::Map<const Eigen::SparseMatrix<double, Eigen::RowMajor>> BlockMatrix::view() const {
  return {pattern_->size(),         pattern_->size(),         pattern_->num_values(),
          pattern_->outer().data(), pattern_->inner().data(), values.data()};
}

}  // namespace clothid
