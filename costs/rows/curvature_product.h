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

  // How many passes `At` takes after the rollout: sweeps of the blocks and of the unknowns, and the reverse sweep.
  static constexpr int kPasses = 3;

  // J^T J `direction` [p + n + f] at an evaluated point, whose rollout is `latest`, to about kLooseAdjointTolerance;
  // `active`: the coordinates that are not frozen, all others count as zero. The columns of blocks are swept once for
  // each point. Throws `std::runtime_error` where a sweep fails.
  Eigen::VectorXd At(const RolloutEvaluation& evaluation, const std::vector<int>& active,
                     const Eigen::VectorXd& direction, const LatestRollout& latest, CostStatistics* statistics);

  // J^T `change` [p + n + f] of a change of the residual [m], to the precision of the point, by one reverse sweep;
  // the rest as above.
  Eigen::VectorXd PullBack(const RolloutEvaluation& evaluation, const std::vector<int>& active,
                           const Eigen::VectorXd& change, const LatestRollout& latest,
                           CostStatistics* statistics) const;
  // The same where `KeepsBlockRows`, without a rollout: from the columns of the blocks, which are swept unless they are
  // those of the latest exact rows.
  Eigen::VectorXd PullBackByBlockRows(const RolloutEvaluation& evaluation, const std::vector<int>& active,
                                      const Eigen::VectorXd& change, CostStatistics* statistics);

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
  Eigen::VectorXd SweepBack(const RolloutEvaluation& evaluation, const std::vector<int>& active,
                            const Eigen::VectorXd& change, Precision precision, const LatestRollout& latest,
                            CostStatistics* statistics) const;
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
