// Rows by sensitivities: the prediction and its whole Jacobian in one forward sweep, frame by frame.
#ifndef CLOTHID_COSTS_ROWS_FORWARD_ROWS_H_
#define CLOTHID_COSTS_ROWS_FORWARD_ROWS_H_

#include <Eigen/Core>
#include <vector>

#include "costs/prediction/recording_model.h"
#include "costs/prediction/robust_loss.h"
#include "costs/rows/rollout_evaluation.h"

namespace clothid {

struct ForwardRows {
  Eigen::MatrixXd predicted;  // [R x T] m
  Eigen::MatrixXd forces;     // [3G x F] N
  RolloutCounts counts;
  ResidualRows rows;         // with their frame scores
  Eigen::MatrixXd jacobian;  // J [m x q] without the weights of the loss; empty unless it is asked for
};

// For the blocks `active` [q], as `num_rows` >= q + 1 rows. Nothing of the size [m x q] is stored unless
// `keeps_jacobian`. Throws `std::runtime_error` where the sweep fails or the Jacobian is not finite; `statistics` has
// counted it then, too.
ForwardRows SweepForward(const Eigen::VectorXd& coordinates, const std::vector<int>& active, const PassOptions& pass,
                         const RobustLoss& loss, int num_rows, bool keeps_jacobian, RecordingModel* model,
                         CostStatistics* statistics, const Eigen::MatrixXd* follow = nullptr);

}  // namespace clothid

#endif  // CLOTHID_COSTS_ROWS_FORWARD_ROWS_H_
