// Rows by one block adjoint sweep in a subspace that follows the fit (costs/rows/residual_basis.h).
#ifndef CLOTHID_COSTS_ROWS_ADJOINT_ROWS_H_
#define CLOTHID_COSTS_ROWS_ADJOINT_ROWS_H_

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "costs/prediction/recording_model.h"
#include "costs/prediction/rollout_cost_options.h"
#include "costs/rows/evaluation_cache.h"
#include "costs/rows/latest_rollout.h"
#include "costs/rows/rollout_evaluation.h"

namespace clothid {

class AdjointRows {
 public:
  // Both must outlive it.
  AdjointRows(RecordingModel* model, const RolloutCostOptions* options) : model_(model), options_(options) {}

  // How many rows there are: |w e| last, directions of the subspace before it, zeros where there are fewer.
  int num_rows() const;

  // The rows at an evaluated point, whose rollout is `latest`, for the blocks `active`. `recent`: the rollouts whose
  // differences from it enter the subspace. Throws `std::runtime_error` where the sweep fails; `statistics` has counted
  // it then, too. What the rows tell of the Jacobian enters the next subspace.
  ResidualRows At(const RolloutEvaluation& evaluation, const std::vector<int>& active, const EvaluationCache& recent,
                  const LatestRollout& latest, CostStatistics* statistics);
  // dL/dq [q] of the blocks `active`, by a sweep of one column. Throws likewise.
  Eigen::VectorXd GradientAt(const RolloutEvaluation& evaluation, const std::vector<int>& active,
                             const LatestRollout& latest, CostStatistics* statistics) const;

  // J [m x q], without the weights of the loss, as far as it is known; empty: not at all.
  const Eigen::MatrixXd& last_jacobian() const { return last_jacobian_; }
  void SetLastJacobian(Eigen::MatrixXd jacobian) { last_jacobian_ = std::move(jacobian); }
  // As if `At` had just given the rows that `evaluation` has.
  void Resume(const RolloutEvaluation& evaluation, const EvaluationCache& recent);

 private:
  // Columns [m x s] that span the subspace, e the first of them.
  Eigen::MatrixXd Directions(const RolloutEvaluation& evaluation, const EvaluationCache& recent) const;
  // The basis B, and the weights w of the loss: B^T w e are the rows.
  Eigen::MatrixXd Basis(const RolloutEvaluation& evaluation, const EvaluationCache& recent,
                        Eigen::VectorXd* weights) const;
  void KeepJacobian(const Eigen::VectorXd& weights, const Eigen::MatrixXd& basis, const ResidualRows& rows);

  RecordingModel* model_;
  const RolloutCostOptions* options_;
  Eigen::MatrixXd last_jacobian_;
};

}  // namespace clothid

#endif  // CLOTHID_COSTS_ROWS_ADJOINT_ROWS_H_
