#include "sim/matrix/block_matrix.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace clothid {
namespace {

// Below so many values a second thread gains less than it costs.
constexpr int kSharedValues = 1 << 17;

// The first of n items that a share has.
int FirstOf(int share, int num_shares, std::size_t n) {
  return static_cast<int>(static_cast<std::int64_t>(n) * share / num_shares);
}

}  // namespace

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

void BlockMatrix::CompleteFromLower(ThreadTeam* team) {
  const int num_shares = NumSharing(*pattern_, team);
  if (num_shares == 1) {
    Mirror(0, 1);
  } else {
    team->Run(num_shares, [&](int share) { Mirror(share, num_shares); });
  }
  ForColumns(*pattern_, team, [this](const BlockColumns& columns) { SetDiagonals(columns); });
}

void BlockMatrix::Mirror(int share, int num_shares) {
  double* const all = values.data();
  const std::vector<BlockPattern::MirroredBlock>& mirrored = pattern_->mirrored();
  const int end = FirstOf(share + 1, num_shares, mirrored.size());
  for (int i = FirstOf(share, num_shares, mirrored.size()); i < end; ++i) {
    const BlockPattern::MirroredBlock& block = mirrored[i];
    const double* lower = all + block.lower.start;
    double* upper = all + block.upper.start;
    for (int r = 0; r < 3; ++r, ++lower, upper += block.upper.stride) {
      for (int c = 0; c < 3; ++c) upper[c] = lower[static_cast<std::ptrdiff_t>(c) * block.lower.stride];
    }
  }
}

void BlockMatrix::SetDiagonals(const BlockColumns& columns) {
  const double* entry = values.data() + columns.begin;
  for (int column = columns.first; column < columns.last; ++column) {
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

int NumSharing(const BlockPattern& pattern, const ThreadTeam* team) {
  return team == nullptr || pattern.num_values() < kSharedValues ? 1 : team->num_threads();
}

BlockColumns ShareOfColumns(const BlockPattern& pattern, int share, int num_shares) {
  const int n = pattern.num_blocks();
  const auto begin = [&](int column) { return column == n ? pattern.num_values() : pattern.Position(column, 0).start; };
  const int first = FirstOf(share, num_shares, static_cast<std::size_t>(n));
  const int last = FirstOf(share + 1, num_shares, static_cast<std::size_t>(n));
  return {first, last, begin(first), begin(last), num_shares == 1};
}

}  // namespace clothid
