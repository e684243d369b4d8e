// What is kept of a solve that succeeded, and what is said of one that failed.
#ifndef CLOTHID_SIM_ROLLOUT_STEP_RECORD_H_
#define CLOTHID_SIM_ROLLOUT_STEP_RECORD_H_

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "sim/contact/contact_set.h"
#include "sim/scene/parameters.h"
#include "sim/step/stage.h"

namespace clothid {

class ClothModel;
struct CorrectedState;  // sim/rollout/correction.h
struct ReducedFactor;   // sim/step/step_jacobian.h

// One implicit solve: a time step, or one of the substeps into which a difficult step was cut, or a stage of either.
// With stages the first comes before the second, whose start is not the state of the record before it: see
// RecordReader.
struct StepRecord {
  double time = 0.0;           // at the end of the solve, s
  double time_step = 0.0;      // h of this solve, eta of a stage, s
  Eigen::VectorXd positions;   // x_{n+1} [3N] m
  Eigen::VectorXd velocities;  // v_{n+1} [3N] m/s
  ContactRecords contacts;     // those that stick or slip
  // Of the step Jacobian at the end of the step, or so near to it that few iterations make up for that. Steps that did
  // not need a factor of their own share one. Null: none is kept.
  std::shared_ptr<const ReducedFactor> factor;
  Stage stage = Stage::kOnly;
  // What the next solve starts from where the end of the step is corrected; null: positions and velocities.
  std::shared_ptr<const CorrectedState> correction = nullptr;

  SolveTimes times() const { return {time_step, time, stage}; }
  bool ends_step() const { return stage != Stage::kFirst; }  // or a substep
  bool is_kept() const { return positions.size() > 0; }
};

// The contacts at the end of `record`, of a solve from `start_positions` x_n [3N] over which obstacles have `motions`:
// the numbers of its solver to the last bit.
ContactSet RestoreContacts(const StepRecord& record, const Eigen::VectorXd& start_positions,
                           const std::vector<ObstacleMotion>& motions, const Parameters& parameters,
                           const ClothModel& model);

// Why and where a rollout ended early.
struct StepFailure {
  int step = 0;            // 1-based
  double residual = 0.0;   // relative, the best one reached
  double tolerance = 0.0;  // that was asked for; 0: the step was not tried
  int num_stick = 0, num_slip = 0, num_take_off = 0;
  std::string reason;

  std::string ToString() const;  // one line
};

}  // namespace clothid

#endif  // CLOTHID_SIM_ROLLOUT_STEP_RECORD_H_
