// Rows by forward differences, one more rollout per parameter: the baseline.
#ifndef CLOTHID_COSTS_ROWS_NUMERIC_ROWS_H_
#define CLOTHID_COSTS_ROWS_NUMERIC_ROWS_H_

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "costs/prediction/recording_model.h"
#include "costs/rows/rollout_evaluation.h"

namespace clothid {

// Runs the rollout of a point, with so many passes to come, for its prediction and its forces.
using RunRollout = std::function<void(const Eigen::VectorXd& coordinates, int passes_left, Eigen::MatrixXd* predicted,
                                      ForceTrack* forces)>;

// For the blocks `active` [q] at an evaluated point, as `num_rows` >= q + 1 rows:
//   J_i = (e(q + h u_i) - e(q))/h,  h of `ForwardDifferenceStep`.
// Throws what `run` throws where one of the rollouts fails.
ResidualRows NumericRows(const RolloutEvaluation& evaluation, const std::vector<int>& active, int num_rows,
                         const RolloutCostOptions& options, const RecordingModel& model, const RunRollout& run);

}  // namespace clothid

#endif  // CLOTHID_COSTS_ROWS_NUMERIC_ROWS_H_
