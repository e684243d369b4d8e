// Symmetric sparse matrices of 3 x 3 blocks over the free nodes, with one pattern for a whole fit.
//
// Storage is scalar compressed columns (both triangles), as CHOLMOD and UMFPACK take it; a 3 x 3 block is a strided
// view into it, so assembly adds in place.
#ifndef CLOTHID_SIM_MATRIX_BLOCK_MATRIX_H_
#define CLOTHID_SIM_MATRIX_BLOCK_MATRIX_H_

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <memory>
#include <vector>

#include "sim/base/thread_team.h"

namespace clothid {

// Where a block starts in the value array, and the distance of its columns there.
struct BlockPosition {
  int start = -1;
  int stride = 0;
  bool valid() const { return start >= 0; }
};

// Block columns first up to last of a pattern, and where their values are.
struct BlockColumns {
  int first, last;
  int begin, end;
  bool are_all;

  bool have(BlockPosition position) const { return position.start >= begin && position.start < end; }
};

class BlockPattern {
 public:
  // `neighbours` [n]: for every block row the block columns beside the diagonal; must be symmetric, may repeat.
  explicit BlockPattern(const std::vector<std::vector<int>>& neighbours);

  int num_blocks() const { return static_cast<int>(column_start_.size()) - 1; }
  int size() const { return 3 * num_blocks(); }
  int num_values() const { return static_cast<int>(inner_.size()); }
  const std::vector<int>& outer() const { return outer_; }  // [size + 1]
  const std::vector<int>& inner() const { return inner_; }  // [num_values], ascending within a column

  // The block rows of block column `column`, ascending, and the position of the k-th of them.
  const int* rows_begin(int column) const { return rows_.data() + column_start_[column]; }
  int num_rows(int column) const { return column_start_[column + 1] - column_start_[column]; }
  BlockPosition Position(int column, int k) const { return {9 * column_start_[column] + 3 * k, 3 * num_rows(column)}; }
  // Of a block that is in the pattern.
  BlockPosition Find(int row, int column) const;
  // A block below the diagonal, and its transpose above it.
  struct MirroredBlock {
    BlockPosition lower, upper;
  };
  // All of them, by columns of the lower block.
  const std::vector<MirroredBlock>& mirrored() const { return mirrored_; }
  BlockPosition Diagonal(int column) const { return Position(column, diagonal_[column]); }

 private:
  std::vector<int> column_start_, rows_;  // by blocks
  std::vector<int> diagonal_;             // per block column: the k of its diagonal block
  std::vector<MirroredBlock> mirrored_;
  std::vector<int> outer_, inner_;  // by scalars
};

class BlockMatrix {
 public:
  using Block = Eigen::Map<Eigen::Matrix3d, 0, Eigen::OuterStride<>>;
  using ConstBlock = Eigen::Map<const Eigen::Matrix3d, 0, Eigen::OuterStride<>>;

  explicit BlockMatrix(std::shared_ptr<const BlockPattern> pattern)
      : values(Eigen::VectorXd::Zero(pattern->num_values())), pattern_(std::move(pattern)) {}

  const BlockPattern& pattern() const { return *pattern_; }
  const std::shared_ptr<const BlockPattern>& shared_pattern() const { return pattern_; }
  Block block(BlockPosition position) {
    return Block(values.data() + position.start, Eigen::OuterStride<>(position.stride));
  }
  ConstBlock block(BlockPosition position) const {
    return ConstBlock(values.data() + position.start, Eigen::OuterStride<>(position.stride));
  }

  // Makes a matrix whole that has rows of sum zero, as the Hessian of an energy that does not see translations. Below
  // the diagonal its blocks must be there; on it, for every block column, the sum of the blocks between it and nodes
  // that the matrix does not have; what stands above it does not matter.
  void CompleteFromLower(ThreadTeam* team = nullptr);

  // The matrix for products. Symmetric, so it may be read by rows, which is the faster product.
  Eigen::Map<const Eigen::SparseMatrix<double, Eigen::RowMajor>> view() const;

  Eigen::VectorXd values;  // [num_values]

 private:
  void Mirror(int share, int num_shares);          // of the blocks below the diagonal, above it
  void SetDiagonals(const BlockColumns& columns);  // from what stands beside them in their columns

  std::shared_ptr<const BlockPattern> pattern_;
};

// The threads that share the work on a matrix of this pattern: 1 without a team (null), and where a second gains
// nothing.
int NumSharing(const BlockPattern& pattern, const ThreadTeam* team);

// `num_shares` of the columns, one after the other.
BlockColumns ShareOfColumns(const BlockPattern& pattern, int share, int num_shares);

// Calls work(columns) for shares that together are all columns, `shares_each` for every thread. Allocates nothing where
// one does all.
template <typename Work>
void ForColumns(const BlockPattern& pattern, ThreadTeam* team, const Work& work, int shares_each = 1) {
  const int num_shares = shares_each * NumSharing(pattern, team);
  if (num_shares == shares_each) {
    work(ShareOfColumns(pattern, 0, 1));
  } else {
    team->Run(num_shares, [&](int share) { work(ShareOfColumns(pattern, share, num_shares)); });
  }
}

}  // namespace clothid

#endif  // CLOTHID_SIM_MATRIX_BLOCK_MATRIX_H_
