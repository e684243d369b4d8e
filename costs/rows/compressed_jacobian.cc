#include "costs/rows/compressed_jacobian.h"

#include <algorithm>
#include <stdexcept>

#include "sim/matrix/dense.h"

namespace clothid {
namespace {

// Rows gathered before they are reduced: enough to make a QR worth its call, few enough to stay in the cache.
constexpr Eigen::Index kChunkRows = 512;

}  // namespace

CompressedJacobian::CompressedJacobian(int num_parameters)
    : num_columns_(num_parameters + 1),
      rows_(Eigen::MatrixXd::Zero(num_columns_ + kChunkRows, num_columns_)),
      num_rows_(num_columns_),
      factor_(Eigen::MatrixXd::Zero(num_columns_, num_columns_)) {}

void CompressedJacobian::Add(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& residuals) {
  for (Eigen::Index begin = 0; begin < residuals.size();) {
    const Eigen::Index count = std::min(residuals.size() - begin, rows_.rows() - num_rows_);
    rows_.block(num_rows_, 0, count, num_columns_ - 1) = jacobian.middleRows(begin, count);
    rows_.block(num_rows_, num_columns_ - 1, count, 1) = residuals.segment(begin, count);
    num_rows_ += count;
    begin += count;
    if (num_rows_ == rows_.rows()) Reduce();
  }
}

const Eigen::MatrixXd& CompressedJacobian::Factor() {
  Reduce();
  return factor_;
}

void CompressedJacobian::Reduce() {
  factor_ = UpperFactor(rows_.topRows(num_rows_));
  rows_.topRows(num_columns_) = factor_;
  num_rows_ = num_columns_;
}

ResidualRows CompressedRows(const std::vector<int>& active, int num_rows, CompressedJacobian* compressed) {
  const Eigen::MatrixXd& factor = compressed->Factor();
  const Eigen::Index num_columns = factor.cols() - 1;
  ResidualRows rows;
  rows.active = active;
  rows.residuals = Eigen::VectorXd::Zero(num_rows);
  rows.jacobian = Eigen::MatrixXd::Zero(num_rows, num_columns);
  rows.residuals.head(num_columns + 1) = factor.col(num_columns);
  rows.jacobian.topRows(num_columns + 1) = factor.leftCols(num_columns);
  if (!rows.jacobian.allFinite()) throw std::runtime_error("the Jacobian is not finite");
  return rows;
}

}  // namespace clothid
