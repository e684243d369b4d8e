#include "sim/step/freed_nodes.h"

#include <algorithm>

namespace clothid {
namespace {

constexpr double kMostFreed = 0.05;  // of all nodes

// The blocks of `freed` and their neighbours, ascending.
std::vector<int> WithNeighbours(const std::vector<FreedBlock>& freed, const BlockPattern& pattern) {
  std::vector<int> blocks;
  for (const FreedBlock& node : freed) {
    const int* const rows = pattern.rows_begin(node.block);
    blocks.insert(blocks.end(), rows, rows + pattern.num_rows(node.block));
  }
  std::sort(blocks.begin(), blocks.end());
  blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
  return blocks;
}

// R_F of vectors.
Eigen::MatrixXd Restrict(const std::vector<int>& blocks, const Eigen::MatrixXd& vectors) {
  Eigen::MatrixXd own(3 * static_cast<Eigen::Index>(blocks.size()), vectors.cols());
  for (std::size_t j = 0; j < blocks.size(); ++j) {
    own.middleRows<3>(3 * static_cast<Eigen::Index>(j)) = vectors.middleRows<3>(3 * blocks[j]);
  }
  return own;
}

// vectors += R_F^T own.
void AddAt(const std::vector<int>& blocks, const Eigen::MatrixXd& own, Eigen::MatrixXd* vectors) {
  for (std::size_t j = 0; j < blocks.size(); ++j) {
    vectors->middleRows<3>(3 * blocks[j]) += own.middleRows<3>(3 * static_cast<Eigen::Index>(j));
  }
}

// The rows of `blocks`, which ascend, of columns of theirs.
Eigen::SparseMatrix<double> RowsOf(const std::vector<int>& blocks, const Eigen::SparseMatrix<double>& columns) {
  std::vector<Eigen::Index> rows(columns.rows(), -1);
  for (std::size_t j = 0; j < blocks.size(); ++j) {
    for (int c = 0; c < 3; ++c) rows[3 * blocks[j] + c] = 3 * static_cast<Eigen::Index>(j) + c;
  }
  Eigen::SparseMatrix<double> own(columns.cols(), columns.cols());
  own.reserve(columns.nonZeros());
  for (Eigen::Index c = 0; c < columns.cols(); ++c) {
    own.startVec(c);
    for (Eigen::SparseMatrix<double>::InnerIterator entry(columns, c); entry; ++entry) {
      if (rows[entry.row()] >= 0) own.insertBack(rows[entry.row()], c) = entry.value();
    }
  }
  own.finalize();
  return own;
}

}  // namespace

void FreedNodes::Clear() {
  freed_.clear();
  are_too_many_ = false;
}

void FreedNodes::Find(const BlockMatrix& hessian, const ContactElimination& contacts, const HeldBlocks& held) {
  Clear();
  const BlockPattern& pattern = hessian.pattern();
  freed_ = contacts.FreedSince(held, pattern.num_blocks());
  if (freed_.empty()) return;
  are_too_many_ = static_cast<double>(freed_.size()) > kMostFreed * pattern.num_blocks();
  if (!are_too_many_) {
    blocks_ = WithNeighbours(freed_, pattern);
    columns_ = contacts.ReducedColumns(hessian, blocks_);
    factor_.compute(RowsOf(blocks_, columns_));
  }
  if (are_too_many_ || factor_.info() != Eigen::Success) freed_.clear();
}

void FreedNodes::RemoveFreed(Eigen::MatrixXd* vectors) const {
  for (const FreedBlock& node : freed_) {
    vectors->middleRows<3>(3 * node.block) -= (node.projection * vectors->middleRows<3>(3 * node.block)).eval();
  }
}

Eigen::MatrixXd FreedNodes::Apply(const LinearMap& apply, const Eigen::MatrixXd& vectors) const {
  if (empty()) return apply(vectors);
  Eigen::MatrixXd own = factor_.solve(Restrict(blocks_, vectors));
  Eigen::MatrixXd rest = vectors - columns_ * own;
  RemoveFreed(&rest);
  Eigen::MatrixXd result = apply(rest);
  RemoveFreed(&result);
  own -= factor_.solve(columns_.transpose() * result);
  AddAt(blocks_, own, &result);
  return result;
}

}  // namespace clothid
