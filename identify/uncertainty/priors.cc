#include "identify/uncertainty/priors.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/matrix/dense.h"

namespace clothid {
namespace {

// Of what a link says, the share that others say as well: below it is rounding.
constexpr double kNothingLeft = 1e-10;

}  // namespace

bool HasPriors(const std::vector<ParameterBlock>& blocks) {
  return std::any_of(blocks.begin(), blocks.end(), [](const ParameterBlock& block) { return block.prior.is_given(); });
}

bool HasLinks(const std::vector<ParameterBlock>& blocks) {
  return std::any_of(blocks.begin(), blocks.end(), [](const ParameterBlock& block) { return block.is_linked(); });
}

bool IsKnot(const std::vector<ParameterBlock>& blocks, int index) {
  return blocks[index].is_linked() || std::any_of(blocks.begin(), blocks.end(), [&](const ParameterBlock& block) {
           return block.linked_to == index;
         });
}

Eigen::VectorXd PriorPrecisions(const std::vector<ParameterBlock>& blocks) {
  Eigen::VectorXd precisions = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(blocks.size()));
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (blocks[i].prior.is_given()) precisions[static_cast<Eigen::Index>(i)] = std::pow(blocks[i].PriorStd(), -2);
  }
  return precisions;
}

Eigen::MatrixXd LinkRows(const std::vector<ParameterBlock>& blocks) {
  const Eigen::Index count =
      std::count_if(blocks.begin(), blocks.end(), [](const ParameterBlock& block) { return block.is_linked(); });
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(count, static_cast<Eigen::Index>(blocks.size()));
  Eigen::Index row = 0;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (!blocks[i].is_linked()) continue;
    rows(row, static_cast<Eigen::Index>(i)) = 1.0 / blocks[i].LinkStd();
    rows(row++, blocks[i].linked_to) = -1.0 / blocks[i].LinkStd();
  }
  return rows;
}

Eigen::MatrixXd PriorRows(const std::vector<ParameterBlock>& blocks) {
  return WithPriorRows(blocks, Eigen::MatrixXd(0, static_cast<Eigen::Index>(blocks.size())), 1.0);
}

Eigen::VectorXd PriorResiduals(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates) {
  const Eigen::MatrixXd rows = PriorRows(blocks);
  Eigen::VectorXd residuals = rows * coordinates.head(rows.cols());
  Eigen::Index row = 0;
  for (const ParameterBlock& block : blocks) {
    if (block.prior.is_given()) residuals[row++] -= block.PriorCoordinate() / block.PriorStd();
  }
  return residuals;
}

Eigen::MatrixXd PriorHessian(const std::vector<ParameterBlock>& blocks) {
  const Eigen::MatrixXd rows = PriorRows(blocks);
  return rows.transpose() * rows;
}

double PriorCost(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates) {
  return 0.5 * PriorResiduals(blocks, coordinates).squaredNorm();
}

Eigen::VectorXd PriorGradient(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates) {
  return PriorRows(blocks).transpose() * PriorResiduals(blocks, coordinates);
}

Eigen::MatrixXd WithPriorRows(const std::vector<ParameterBlock>& blocks, const Eigen::MatrixXd& jacobian, double scale,
                              int left_out) {
  Eigen::MatrixXd all = jacobian;
  const auto append = [&all](const Eigen::RowVectorXd& row) {
    all.conservativeResize(all.rows() + 1, all.cols());
    all.row(all.rows() - 1) = row;
  };
  for (int i = 0; i < static_cast<int>(blocks.size()); ++i) {
    if (!blocks[i].prior.is_given() || i == left_out) continue;
    append(scale / blocks[i].PriorStd() * Eigen::RowVectorXd::Unit(jacobian.cols(), i));
  }
  const Eigen::MatrixXd links = LinkRows(blocks);
  all.conservativeResize(all.rows() + links.rows(), all.cols());
  all.bottomRows(links.rows()).setZero();
  all.bottomLeftCorner(links.rows(), links.cols()) = links;
  return all;
}

double VisibleWithoutLinks(const std::vector<ParameterBlock>& blocks, const ScaledJacobian& jacobian, Eigen::Index i) {
  const int index = jacobian.indices()[i];
  Eigen::MatrixXd inverse(jacobian.size(), jacobian.size());
  for (Eigen::Index a = 0; a < inverse.rows(); ++a) {
    for (Eigen::Index b = 0; b < inverse.cols(); ++b) inverse(a, b) = jacobian.Inverse(a, b);
  }
  if (!inverse.allFinite()) return 0.0;
  std::vector<ParameterBlock> own = blocks;
  for (std::size_t b = 0; b < own.size(); ++b) {
    if (static_cast<int>(b) != index && own[b].linked_to != index) own[b].linked_to = kNoBlock;
  }
  Eigen::MatrixXd links = LinkRows(own)(Eigen::all, jacobian.indices());
  for (Eigen::Index b = 0; b < links.cols(); ++b) links.col(b) *= blocks[jacobian.indices()[b]].CoordinateRange();
  const Eigen::MatrixXd told = links * inverse * links.transpose();
  const Eigen::MatrixXd left = Eigen::MatrixXd::Identity(told.rows(), told.cols()) - told;
  const Spectrum eigen = SymmetricSpectrum(left);
  const Eigen::VectorXd pull = eigen.vectors.transpose() * (links * inverse.col(i));
  double variance = inverse(i, i);
  for (Eigen::Index k = 0; k < pull.size(); ++k) {
    const double square = pull[k] * pull[k];
    if (eigen.values[k] > kNothingLeft) {
      variance += square / eigen.values[k];
    } else if (square > kNothingLeft * inverse(i, i)) {
      return 0.0;  // else what nothing tells any more is another knot
    }
  }
  return 1.0 / std::sqrt(variance);
}

Posterior::Posterior(const std::vector<ParameterBlock>& blocks, const Eigen::MatrixXd& jacobian,
                     std::vector<int> indices, int left_out)
    : jacobian_(blocks, WithPriorRows(blocks, jacobian, 1.0, left_out), std::move(indices)) {
  Eigen::VectorXd precisions = PriorPrecisions(blocks);
  if (left_out != kEveryPrior) precisions[left_out] = 0.0;
  precisions_ = precisions(jacobian_.indices());
  const Eigen::MatrixXd links = LinkRows(blocks);
  link_influences_.resize(jacobian_.size(), links.rows());
  for (Eigen::Index i = 0; i < jacobian_.size() && links.rows() > 0; ++i) {
    link_influences_.row(i) = jacobian_.SolveRow(i, links.transpose());
  }
}

double Posterior::PriorPart(Eigen::Index i, Eigen::Index j) const {
  double sum = 0.0;
  for (Eigen::Index k = 0; k < precisions_.size(); ++k) {
    if (precisions_[k] > 0.0) sum += jacobian_.Covariance(i, k) * precisions_[k] * jacobian_.Covariance(k, j);
  }
  return sum;
}

double Posterior::LinkPart(Eigen::Index i, Eigen::Index j) const {
  return link_influences_.row(i).dot(link_influences_.row(j));
}

double Posterior::Covariance(Eigen::Index i, Eigen::Index j, double scale) const {
  return scale * scale * jacobian_.Covariance(i, j) + (1.0 - scale * scale) * PriorPart(i, j);
}

}  // namespace clothid
