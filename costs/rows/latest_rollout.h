// The rollout that was run last, with what was predicted along it. Trajectories are large, so there is one, and never
// two.
#ifndef CLOTHID_COSTS_ROWS_LATEST_ROLLOUT_H_
#define CLOTHID_COSTS_ROWS_LATEST_ROLLOUT_H_

#include <Eigen/Core>

#include "costs/prediction/recording_model.h"
#include "costs/prediction/rollout_cost_options.h"
#include "sim/rollout/rollout.h"

namespace clothid {

struct LatestRollout {
  Rollout rollout;
  // [R x T] m, m/s and N: see RecordingModel::Simulate.
  Eigen::MatrixXd predicted, velocities;
  ForceTrack forces;
  Eigen::VectorXd coordinates;  // whose rollout it is; empty: there is none
  Precision precision = Precision::kFull;
  // A journal has told whose rollout it was, and counted it: it has yet to be made again.
  bool is_pending = false;

  // Whether it is the one at this point, made or pending.
  bool IsAt(const Eigen::VectorXd& point) const {
    return coordinates.size() > 0 && coordinates.size() == point.size() && coordinates == point;
  }
  void Drop();
  // A rollout of another precision is not kept.
  void DropUnless(Precision wanted);
  void Resume(const Eigen::VectorXd& point, Precision wanted);
};

}  // namespace clothid

#endif  // CLOTHID_COSTS_ROWS_LATEST_ROLLOUT_H_
