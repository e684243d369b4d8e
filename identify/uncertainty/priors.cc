#include "identify/uncertainty/priors.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace clothid {

bool HasPriors(const std::vector<ParameterBlock>& blocks) {
  return std::any_of(blocks.begin(), blocks.end(), [](const ParameterBlock& block) { return block.prior.is_given(); });
}

Eigen::VectorXd PriorPrecisions(const std::vector<ParameterBlock>& blocks) {
  Eigen::VectorXd precisions = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(blocks.size()));
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (blocks[i].prior.is_given()) precisions[static_cast<Eigen::Index>(i)] = std::pow(blocks[i].PriorStd(), -2);
  }
  return precisions;
}

double PriorCost(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates) {
  double cost = 0.0;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (!blocks[i].prior.is_given()) continue;
    const double off = coordinates[static_cast<Eigen::Index>(i)] - blocks[i].PriorCoordinate();
    cost += 0.5 * std::pow(off / blocks[i].PriorStd(), 2);
  }
  return cost;
}

Eigen::VectorXd PriorGradient(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates) {
  Eigen::VectorXd gradient = PriorPrecisions(blocks);
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    if (blocks[i].prior.is_given()) gradient[row] *= coordinates[row] - blocks[i].PriorCoordinate();
  }
  return gradient;
}

Eigen::MatrixXd WithPriorRows(const std::vector<ParameterBlock>& blocks, const Eigen::MatrixXd& jacobian, double scale,
                              int left_out) {
  Eigen::MatrixXd all = jacobian;
  for (int i = 0; i < static_cast<int>(blocks.size()); ++i) {
    if (!blocks[i].prior.is_given() || i == left_out) continue;
    all.conservativeResize(all.rows() + 1, jacobian.cols());
    all.row(all.rows() - 1).setZero();
    all(all.rows() - 1, i) = scale / blocks[i].PriorStd();
  }
  return all;
}

Posterior::Posterior(const std::vector<ParameterBlock>& blocks, const Eigen::MatrixXd& jacobian,
                     std::vector<int> indices, int left_out)
    : jacobian_(blocks, WithPriorRows(blocks, jacobian, 1.0, left_out), std::move(indices)) {
  Eigen::VectorXd precisions = PriorPrecisions(blocks);
  if (left_out != kEveryPrior) precisions[left_out] = 0.0;
  precisions_ = precisions(jacobian_.indices());
}

double Posterior::PriorPart(Eigen::Index i, Eigen::Index j) const {
  double sum = 0.0;
  for (Eigen::Index k = 0; k < precisions_.size(); ++k) {
    if (precisions_[k] > 0.0) sum += jacobian_.Covariance(i, k) * precisions_[k] * jacobian_.Covariance(k, j);
  }
  return sum;
}

double Posterior::Covariance(Eigen::Index i, Eigen::Index j, double scale) const {
  return scale * scale * jacobian_.Covariance(i, j) + (1.0 - scale * scale) * PriorPart(i, j);
}

}  // namespace clothid
