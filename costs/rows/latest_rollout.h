// Runs and counts the rollouts of one recording, and keeps the latest.
#ifndef CLOTHID_COSTS_ROWS_LATEST_ROLLOUT_H_
#define CLOTHID_COSTS_ROWS_LATEST_ROLLOUT_H_

#include <Eigen/Core>

#include "costs/prediction/recording_model.h"
#include "costs/prediction/rollout_cost_options.h"
#include "sim/rollout/rollout.h"

namespace clothid {

class LatestRollout {
 public:
  // Both must outlive it.
  LatestRollout(RecordingModel* model, const RolloutCostOptions* options) : model_(model), options_(options) {}

  // Runs the rollout, with `passes_left` further passes to come, and adds it to `statistics`. `predicted`, `velocities`
  // (may be null) and `forces`: see RecordingModel::Simulate. Throws `std::runtime_error` where it fails.
  Rollout Run(const Eigen::VectorXd& coordinates, Precision precision, int passes_left, Eigen::MatrixXd* predicted,
              Eigen::MatrixXd* velocities, ForceTrack* forces, CostStatistics* statistics) const;

  // The kept rollout if it is that of `coordinates`, else as `Run`, and kept from then on. Trajectories are large, so
  // there is one, and never two.
  const Rollout& At(const Eigen::VectorXd& coordinates, Precision precision, int passes_left,
                    CostStatistics* statistics);
  // Of the last `At`.
  const Eigen::MatrixXd& predicted() const { return predicted_; }    // [R x T] m
  const Eigen::MatrixXd& velocities() const { return velocities_; }  // see RecordingModel::Simulate
  const ForceTrack& forces() const { return forces_; }               // likewise

  // A rollout of another precision is not kept.
  void DropUnless(Precision precision);
  void Drop();
  // Whose rollout is kept; empty: none.
  const Eigen::VectorXd& coordinates() const { return coordinates_; }
  // A journal tells whose rollout was kept, and has counted it: it is made when it is asked for.
  void Resume(const Eigen::VectorXd& coordinates, Precision precision);

 private:
  RecordingModel* model_;
  const RolloutCostOptions* options_;
  Rollout rollout_;
  Eigen::MatrixXd predicted_, velocities_;
  ForceTrack forces_;
  Eigen::VectorXd coordinates_;
  Precision precision_ = Precision::kFull;
  bool is_pending_ = false;  // `rollout_` has yet to be made
};

}  // namespace clothid

#endif  // CLOTHID_COSTS_ROWS_LATEST_ROLLOUT_H_
