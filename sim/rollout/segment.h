// A run of steps, one after the other: the loop that rollouts, forward sweeps and the way back from a checkpoint share.
#ifndef CLOTHID_SIM_ROLLOUT_SEGMENT_H_
#define CLOTHID_SIM_ROLLOUT_SEGMENT_H_

#include <Eigen/Core>
#include <atomic>
#include <functional>
#include <optional>
#include <vector>

#include "sim/rollout/step_record.h"
#include "sim/scene/parameters.h"
#include "sim/step/step_counts.h"

namespace clothid {

struct Scene;
class Correction;
class HandlePath;
class Simulator;

// What one step hands to the next.
struct StepState {
  Eigen::VectorXd positions;   // x_n [3N] m
  Eigen::VectorXd velocities;  // v_n [3N] m/s
  // At the end of the last solve. Absent at the start of a rollout: the contacts of its first solve have not joined.
  std::optional<ContactRecords> contacts = std::nullopt;
};

// The start of a rollout: that of the scene, but with `initial_positions` [3N] m and `initial_velocities` [3N] m/s
// where they are not null. Throws `std::logic_error` where these are not as many.
StepState StartState(const Scene& scene, const Eigen::VectorXd* initial_positions,
                     const Eigen::VectorXd* initial_velocities);

struct Segment {
  int first_step = 1, last_step = 1;           // 1-based
  std::optional<double> step_tolerance;        // relative residual asked of a step; absent: the scene's
  bool end_with_factors = false;               // see RolloutOptions::factor_memory
  const HandlePath* handle_offsets = nullptr;  // as of RolloutOptions
  // For a step the velocities [3 Nf] from which its solves start: it is cut into as many. None, or an empty function:
  // the solver finds a start of its own.
  std::function<std::vector<Eigen::VectorXd>(int step)> guesses;
  const Correction* correction = nullptr;     // as of RolloutOptions
  const std::atomic<bool>* cancel = nullptr;  // ends the segment as failed when it turns true
};

struct SegmentOutcome {
  RolloutCounts counts;
  std::optional<StepFailure> failure;  // set: the segment ended early
  int cut_corrections = 0;             // as of Rollout

  bool ok() const { return !failure.has_value(); }
};

// Takes the solves of step number `step`.
using StepVisitor = std::function<void(int step, std::vector<StepRecord> records)>;

// Runs the steps of `segment` with a solver that was reset: they do not depend on what it did before. A step is one
// solve or, where that does not converge, 2, 4, .. substeps. `state` is that before the first step and becomes that
// after the last one that succeeded, and its correction, `visitor` sees the steps that succeeded. Throws
// `std::logic_error` where the scene has no path for as many handles as have offsets.
SegmentOutcome AdvanceSegment(const Parameters& parameters, const Segment& segment, const StepVisitor& visitor,
                              Simulator* simulator, StepState* state);

}  // namespace clothid

#endif  // CLOTHID_SIM_ROLLOUT_SEGMENT_H_
