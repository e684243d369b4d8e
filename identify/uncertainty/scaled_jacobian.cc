#include "identify/uncertainty/scaled_jacobian.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/matrix/dense.h"

namespace clothid {
namespace {

// Entries of a singular vector below this are the rounding of zero.
constexpr double kVectorRounding = 1e-6;

}  // namespace

ScaledJacobian::ScaledJacobian(const std::vector<ParameterBlock>& blocks, const Eigen::MatrixXd& jacobian,
                               std::vector<int> indices)
    : indices_(std::move(indices)), ranges_(static_cast<Eigen::Index>(indices_.size())) {
  if (indices_.empty()) return;
  for (Eigen::Index i = 0; i < size(); ++i) ranges_[i] = blocks[indices_[i]].CoordinateRange();
  const Eigen::MatrixXd scaled = jacobian(Eigen::all, indices_) * ranges_.asDiagonal();
  // Padding to at least p rows gives every right singular vector.
  Eigen::MatrixXd padded = Eigen::MatrixXd::Zero(std::max(scaled.rows(), scaled.cols()), scaled.cols());
  padded.topRows(scaled.rows()) = scaled;
  const RightSingular svd = RightSingularVectors(padded);
  singular_values_ = svd.values;
  vectors_ = (svd.vectors.array().abs() < kVectorRounding).select(0.0, svd.vectors);
}

double ScaledJacobian::Inverse(Eigen::Index i, Eigen::Index j) const {
  double sum = 0.0;
  for (Eigen::Index k = 0; k < size(); ++k) {
    const double product = vectors_(i, k) * vectors_(j, k);
    if (product != 0.0) sum += product / (singular_values_[k] * singular_values_[k]);
  }
  return sum;
}

double ScaledJacobian::Solve(Eigen::Index i, const Eigen::VectorXd& vector) const {
  double sum = 0.0;
  for (Eigen::Index j = 0; j < size(); ++j) sum += Covariance(i, j) * vector[indices_[j]];
  return sum;
}

Eigen::RowVectorXd ScaledJacobian::SolveRow(Eigen::Index i, const Eigen::MatrixXd& vectors) const {
  Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(vectors.cols());
  for (Eigen::Index j = 0; j < size(); ++j) sum += Covariance(i, j) * vectors.row(indices_[j]);
  return sum;
}

double ScaledJacobian::VisibleChange(Eigen::Index i) const { return 1.0 / std::sqrt(Inverse(i, i)); }

double ScaledJacobian::CoordinateStd(Eigen::Index i) const { return ranges_[i] * std::sqrt(Inverse(i, i)); }

Eigen::VectorXd ScaledJacobian::Direction(Eigen::Index k, Eigen::Index num_blocks) const {
  Eigen::VectorXd direction = Eigen::VectorXd::Zero(num_blocks);
  direction(indices_) = ranges_.cwiseProduct(vectors_.col(k));
  Eigen::Index largest = 0;
  direction.cwiseAbs().maxCoeff(&largest);
  return direction / direction[largest];
}

}  // namespace clothid
