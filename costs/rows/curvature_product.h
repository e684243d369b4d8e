// Products with the Gauss-Newton matrix J^T J of a recording, or with J^T, weighted by the loss, along a rollout that
// is at hand.
#ifndef CLOTHID_COSTS_ROWS_CURVATURE_PRODUCT_H_
#define CLOTHID_COSTS_ROWS_CURVATURE_PRODUCT_H_

#include <Eigen/Core>
#include <cstddef>
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

  // J^T `change` [p + n + f] of a change of the residual [m], to the precision of the point; `active` and failures as
  // above. Where `KeepsBlockRows`, from the columns of the blocks, which are swept unless they are those of the latest
  // exact rows; else by one reverse sweep.
  Eigen::VectorXd PullBack(const RolloutEvaluation& evaluation, const std::vector<int>& active,
                           const Eigen::VectorXd& change, LatestRollout* rollouts, CostStatistics* statistics);

  // Whether the columns of exact rows are to be kept: there are no others than those of `num_blocks` blocks, and they
  // take no more memory than a rollout may.
  bool KeepsBlockRows(std::size_t num_blocks) const;
  // J [m x q] of the free blocks at a point, without weights, by a forward sweep.
  void KeepBlockRows(const RolloutEvaluation& evaluation, Eigen::MatrixXd jacobian);

  // A journal tells that the columns of the blocks were made at a point, and has counted their sweep.
  void Resume(const Eigen::VectorXd& coordinates, Precision precision);
  void Forget() { Resume({}, Precision::kFull); }

 private:
  // Whether the columns of the blocks at that point were counted.
  bool IsCounted(const RolloutEvaluation& evaluation) const;
  // The columns of J, without weights, that belong to `blocks`: to `kLooseAdjointTolerance` along a rollout, or as
  // exactly as exact rows.
  void SetBlockRows(const RolloutEvaluation& evaluation, const std::vector<int>& blocks, const Rollout& rollout,
                    CostStatistics* statistics);
  void SetExactBlockRows(const RolloutEvaluation& evaluation, const std::vector<int>& blocks,
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
