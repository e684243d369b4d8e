// Products with the Gauss-Newton matrix J^T J of a recording, or with J^T, weighted by the loss, along a rollout that
// is at hand.
#ifndef CLOTHID_COSTS_ROWS_CURVATURE_PRODUCT_H_
#define CLOTHID_COSTS_ROWS_CURVATURE_PRODUCT_H_

#include <Eigen/Core>
#include <vector>

#include "costs/prediction/recording_model.h"
#include "costs/prediction/rollout_cost_options.h"
#include "costs/rows/latest_rollout.h"
#include "costs/rows/rollout_evaluation.h"

namespace clothid {

class CurvatureProduct {
 public:
  // Both must outlive it.
  CurvatureProduct(RecordingModel* model, const RolloutCostOptions* options) : model_(model), options_(options) {}

  // J^T J `direction` [p + n + f] at an evaluated point, to about kLooseAdjointTolerance; `active`: the coordinates
  // that are not frozen, all others count as zero. The columns of blocks are swept once for each point. Throws
  // `std::runtime_error` where a sweep fails.
  Eigen::VectorXd At(const RolloutEvaluation& evaluation, const std::vector<int>& active,
                     const Eigen::VectorXd& direction, LatestRollout* rollouts, CostStatistics* statistics);

  // J^T `change` [p + n + f] of a change of the residual [m], to the precision of the point, by one reverse sweep;
  // `active` and failures as above.
  Eigen::VectorXd PullBack(const RolloutEvaluation& evaluation, const std::vector<int>& active,
                           const Eigen::VectorXd& change, LatestRollout* rollouts, CostStatistics* statistics) const;

  // A journal tells that `At` was called at a point, and has counted its sweeps.
  void Resume(const Eigen::VectorXd& coordinates, Precision precision);
  void Forget() { Resume({}, Precision::kFull); }

 private:
  // The columns of J, without weights, that belong to `blocks`.
  void SetBlockRows(const RolloutEvaluation& evaluation, const std::vector<int>& blocks, const Rollout& rollout,
                    CostStatistics* statistics);
  // J^T of a change of the residual [m], by a reverse sweep along the latest of `rollouts`, which is of this point.
  Eigen::VectorXd SweepBack(const RolloutEvaluation& evaluation, const std::vector<int>& active,
                            const Eigen::VectorXd& change, Precision precision, const Rollout& rollout,
                            const LatestRollout& rollouts, CostStatistics* statistics) const;
  // J [m x (q + c)], without weights.
  Eigen::MatrixXd Sweep(const RolloutEvaluation& evaluation, const SweepColumns& columns, const Rollout& rollout,
                        int passes_left);

  RecordingModel* model_;
  const RolloutCostOptions* options_;
  // Whose columns are counted, and, unless they have yet to be made, there.
  Eigen::VectorXd coordinates_;
  Precision precision_ = Precision::kFull;
  Eigen::MatrixXd block_rows_;  // [m x q]; empty: not made
};

}  // namespace clothid

#endif  // CLOTHID_COSTS_ROWS_CURVATURE_PRODUCT_H_
