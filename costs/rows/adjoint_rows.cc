#include "costs/rows/adjoint_rows.h"

#include <algorithm>
#include <stdexcept>

#include "costs/rows/evaluated_residuals.h"
#include "costs/rows/residual_basis.h"
#include "sim/base/phase_seconds.h"

namespace clothid {
namespace {

// Differences that enter the subspace beside the last Jacobian, which holds the older ones.
constexpr int kFreshDifferences = 2;

void ExpectFinite(const Eigen::MatrixXd& gradients) {
  if (!gradients.allFinite()) throw std::runtime_error("the adjoint sweep gave a gradient that is not finite");
}

}  // namespace

int AdjointRows::num_rows() const {
  return 1 + options_->num_differences + std::max(kNumDisplacementModes, model_->num_coordinates());
}

// e first, so that it is in the span to rounding whatever follows.
Eigen::MatrixXd AdjointRows::Directions(const RolloutEvaluation& evaluation, const EvaluationCache& recent) const {
  const Observation& observation = model_->observation();
  const bool has_jacobian = last_jacobian_.size() > 0;
  Eigen::MatrixXd modes;
  if (!has_jacobian) modes = DisplacementModes(observation, ResidualDerivative(&observation, evaluation.predicted));
  const Eigen::MatrixXd& others = has_jacobian ? last_jacobian_ : modes;
  const int max_differences =
      has_jacobian ? std::min(kFreshDifferences, options_->num_differences) : options_->num_differences;
  Eigen::MatrixXd vectors = Eigen::MatrixXd::Zero(observation.num_residuals(), 1 + max_differences + others.cols());
  vectors.col(0) = evaluation.residuals;
  Eigen::Index column = 1;
  for (const RolloutEvaluation& other : recent.evaluations()) {
    if (column > max_differences) break;
    if (other.coordinates == evaluation.coordinates || !other.ok()) continue;
    vectors.col(column++) = ResidualChange(observation, evaluation, other.predicted, other.forces);
  }
  vectors.rightCols(others.cols()) = others;
  return vectors;
}

Eigen::MatrixXd AdjointRows::Basis(const RolloutEvaluation& evaluation, const EvaluationCache& recent,
                                   Eigen::VectorXd* weights) const {
  WeightedResiduals(options_->loss, model_->observation(), evaluation, weights);
  Eigen::MatrixXd vectors = Directions(evaluation, recent);
  vectors.array().colwise() *= weights->array();
  return OrthonormalBasis(std::move(vectors));
}

void AdjointRows::KeepJacobian(const Eigen::VectorXd& weights, const Eigen::MatrixXd& basis, const ResidualRows& rows) {
  const bool has_residual = rows.residuals[num_rows() - 1] > 0.0;
  const Eigen::Index num_directions = basis.cols() - (has_residual ? 1 : 0);
  last_jacobian_ = basis.rightCols(num_directions) * rows.jacobian.topRows(num_directions);
  if (has_residual) last_jacobian_ += basis.leftCols(1) * rows.jacobian.bottomRows(1);
  last_jacobian_ = (weights.cwiseInverse().asDiagonal() * last_jacobian_).eval();
}

ResidualRows AdjointRows::At(const RolloutEvaluation& evaluation, const std::vector<int>& active,
                             const EvaluationCache& recent, const LatestRollout& latest, CostStatistics* statistics) {
  const ScopedTimer timer(&statistics->derivative_seconds);
  Eigen::VectorXd weights;
  const Eigen::MatrixXd basis = Basis(evaluation, recent, &weights);
  const double norm = weights.cwiseProduct(evaluation.residuals).norm();
  ++statistics->sweeps;
  // (B^T w J)^T = J^T w B: the seeds are the columns of w B. Where no weight differs from one they are B, which is
  // large.
  const bool is_weighted = options_->loss.is_robust() || model_->observation().error_weights().size() > 0;
  Eigen::MatrixXd weighted_basis;
  if (is_weighted) weighted_basis = weights.asDiagonal() * basis;
  const Eigen::MatrixXd gradients =
      model_->PullBack(latest.rollout, evaluation.predicted, latest.velocities, evaluation.coordinates, active,
                       is_weighted ? weighted_basis : basis, options_->adjoint, evaluation.precision, &latest.forces);
  ExpectFinite(gradients);

  // B^T e is |e| in the row of e, the first column of B, and zero in the others by construction.
  const Eigen::Index num_directions = basis.cols() - (norm > 0.0 ? 1 : 0);
  ResidualRows rows;
  rows.active = active;
  rows.residuals = Eigen::VectorXd::Zero(num_rows());
  rows.jacobian = Eigen::MatrixXd::Zero(num_rows(), static_cast<Eigen::Index>(active.size()));
  rows.residuals[num_rows() - 1] = norm;
  rows.jacobian.topRows(num_directions) = gradients.rightCols(num_directions).transpose();
  if (norm > 0.0) rows.jacobian.bottomRows(1) = gradients.leftCols(1).transpose();
  KeepJacobian(weights, basis, rows);
  return rows;
}

Eigen::VectorXd AdjointRows::GradientAt(const RolloutEvaluation& evaluation, const std::vector<int>& active,
                                        const LatestRollout& latest, CostStatistics* statistics) const {
  const ScopedTimer timer(&statistics->derivative_seconds);
  Eigen::VectorXd weights;
  const Eigen::VectorXd weighted = WeightedResiduals(options_->loss, model_->observation(), evaluation, &weights);
  ++statistics->sweeps;
  const Eigen::VectorXd gradient =
      model_->PullBack(latest.rollout, evaluation.predicted, latest.velocities, evaluation.coordinates, active,
                       weights.cwiseProduct(weighted), options_->adjoint, evaluation.precision, &latest.forces);
  ExpectFinite(gradient);
  return gradient;
}

void AdjointRows::Resume(const RolloutEvaluation& evaluation, const EvaluationCache& recent) {
  Eigen::VectorXd weights;
  const Eigen::MatrixXd basis = Basis(evaluation, recent, &weights);
  KeepJacobian(weights, basis, evaluation.rows);
}

}  // namespace clothid
