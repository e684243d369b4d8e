// Rows by sensitivities: the prediction and its whole Jacobian in one forward sweep, frame by frame.
#ifndef CLOTHID_COSTS_ROWS_FORWARD_ROWS_H_
#define CLOTHID_COSTS_ROWS_FORWARD_ROWS_H_

#include <Eigen/Core>

#include "costs/prediction/recording_model.h"
#include "costs/prediction/robust_loss.h"
#include "costs/rows/rollout_evaluation.h"
#include "sim/rollout/rollout.h"

namespace clothid {

struct ForwardRows {
  Eigen::MatrixXd predicted;  // [R x T] m
  Eigen::MatrixXd forces;     // [3G x F] N
  RolloutCounts counts;
  ResidualRows rows;         // with their frame scores
  Eigen::MatrixXd jacobian;  // J [m x (q + c)] without the weights of the loss; empty unless it is asked for
};

// Along `columns` [q + c], as `num_rows` >= q + c + 1 rows. Nothing of the size [m x (q + c)] is stored unless
// `keeps_jacobian`. `rollout` (may be null): the one at the coordinates, which is not simulated again then, and has its
// counts elsewhere. Throws `std::runtime_error` where the sweep fails or the Jacobian is not finite; `statistics` has
// counted it then, too.
ForwardRows SweepForward(const Eigen::VectorXd& coordinates, const SweepColumns& columns, const PassOptions& pass,
                         const RobustLoss& loss, int num_rows, bool keeps_jacobian, RecordingModel* model,
                         CostStatistics* statistics, const Rollout* rollout);

}  // namespace clothid

#endif  // CLOTHID_COSTS_ROWS_FORWARD_ROWS_H_
