#include "costs/rows/curvature_product.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "costs/rows/evaluated_residuals.h"
#include "costs/rows/forward_rows.h"
#include "sim/base/phase_seconds.h"

namespace clothid {

Eigen::VectorXd CurvatureProduct::At(const RolloutEvaluation& evaluation, const std::vector<int>& active,
                                     const Eigen::VectorXd& direction, const LatestRollout& latest,
                                     CostStatistics* statistics) {
  const ScopedTimer timer(&statistics->derivative_seconds);
  const auto first_unknown = std::lower_bound(active.begin(), active.end(), model_->num_blocks());
  const std::vector<int> blocks(active.begin(), first_unknown);
  Eigen::VectorXd along = Eigen::VectorXd::Zero(model_->observation().num_residuals());  // J direction
  if (!blocks.empty()) {
    SetBlockRows(evaluation, blocks, latest.rollout, statistics);
    along += block_rows_ * direction(blocks);
  }
  if (model_->num_unknowns() > 0) {
    ++statistics->sweeps;
    along += Sweep(evaluation, {{}, direction.tail(model_->num_unknowns())}, latest.rollout, /*passes_left=*/1);
  }
  return SweepBack(evaluation, active, along, Precision::kLoose, latest, statistics);
}

Eigen::VectorXd CurvatureProduct::PullBack(const RolloutEvaluation& evaluation, const std::vector<int>& active,
                                           const Eigen::VectorXd& change, const LatestRollout& latest,
                                           CostStatistics* statistics) const {
  const ScopedTimer timer(&statistics->derivative_seconds);
  return SweepBack(evaluation, active, change, evaluation.precision, latest, statistics);
}

Eigen::VectorXd CurvatureProduct::PullBackByBlockRows(const RolloutEvaluation& evaluation,
                                                      const std::vector<int>& active, const Eigen::VectorXd& change,
                                                      CostStatistics* statistics) {
  SetExactBlockRows(evaluation, active, statistics);
  Eigen::VectorXd weights;
  WeightedResiduals(options_->loss, model_->observation(), evaluation, &weights);
  Eigen::VectorXd product = Eigen::VectorXd::Zero(model_->num_coordinates());
  product(active) = block_rows_.transpose() * weights.cwiseAbs2().cwiseProduct(change);
  return product;
}

bool CurvatureProduct::KeepsBlockRows(std::size_t num_blocks) const {
  const auto num_rows = static_cast<std::size_t>(model_->observation().num_residuals());
  return model_->num_unknowns() == 0 && num_rows * num_blocks * sizeof(double) <= options_->memory_limit;
}

void CurvatureProduct::KeepBlockRows(const RolloutEvaluation& evaluation, Eigen::MatrixXd jacobian) {
  coordinates_ = evaluation.coordinates;
  precision_ = evaluation.precision;
  block_rows_ = std::move(jacobian);
}

Eigen::VectorXd CurvatureProduct::SweepBack(const RolloutEvaluation& evaluation, const std::vector<int>& active,
                                            const Eigen::VectorXd& change, Precision precision,
                                            const LatestRollout& latest, CostStatistics* statistics) const {
  Eigen::VectorXd weights;
  WeightedResiduals(options_->loss, model_->observation(), evaluation, &weights);
  ++statistics->sweeps;
  Eigen::VectorXd product = Eigen::VectorXd::Zero(model_->num_coordinates());
  product(active) =
      model_->PullBack(latest.rollout, evaluation.predicted, latest.velocities, evaluation.coordinates, active,
                       weights.cwiseAbs2().cwiseProduct(change), options_->adjoint, precision, &latest.forces);
  if (!product.allFinite()) throw std::runtime_error("the product with the Jacobian is not finite");
  return product;
}

void CurvatureProduct::Resume(const Eigen::VectorXd& coordinates, Precision precision) {
  const bool is_known = coordinates_.size() == coordinates.size() && coordinates_ == coordinates;
  if (is_known && precision_ == precision) return;
  coordinates_ = coordinates;
  precision_ = precision;
  block_rows_.resize(0, 0);
}

bool CurvatureProduct::IsCounted(const RolloutEvaluation& evaluation) const {
  return coordinates_.size() > 0 && coordinates_ == evaluation.coordinates && precision_ == evaluation.precision;
}

void CurvatureProduct::SetExactBlockRows(const RolloutEvaluation& evaluation, const std::vector<int>& blocks,
                                         CostStatistics* statistics) {
  if (IsCounted(evaluation) && block_rows_.size() > 0) return;
  CostStatistics counted_before;
  const PassOptions pass{evaluation.precision, options_->cancel, /*passes_left=*/0};
  ForwardRows swept =
      SweepForward(evaluation.coordinates, {blocks, {}}, pass, options_->loss, static_cast<int>(blocks.size()) + 1,
                   /*keeps_jacobian=*/true, model_, IsCounted(evaluation) ? &counted_before : statistics, nullptr);
  KeepBlockRows(evaluation, std::move(swept.jacobian));
}

void CurvatureProduct::SetBlockRows(const RolloutEvaluation& evaluation, const std::vector<int>& blocks,
                                    const Rollout& rollout, CostStatistics* statistics) {
  if (IsCounted(evaluation) && block_rows_.size() > 0) return;
  if (!IsCounted(evaluation)) ++statistics->sweeps;
  KeepBlockRows(evaluation, Sweep(evaluation, {blocks, {}}, rollout, /*passes_left=*/2));
}

Eigen::MatrixXd CurvatureProduct::Sweep(const RolloutEvaluation& evaluation, const SweepColumns& columns,
                                        const Rollout& rollout, int passes_left) {
  const Observation& observation = model_->observation();
  const auto num_columns = static_cast<Eigen::Index>(columns.blocks.size()) + columns.combinations.cols();
  Eigen::MatrixXd rows(observation.num_residuals(), num_columns);
  const auto add_frame = [&](int frame, const Eigen::VectorXd&, const Eigen::VectorXd&,
                             const Eigen::MatrixXd& jacobian) {
    rows.middleRows(observation.first_row(frame), jacobian.rows()) = jacobian;
  };
  model_->PushForward(rollout, evaluation.coordinates, columns, add_frame, Precision::kLoose, passes_left);
  return rows;
}

}  // namespace clothid
