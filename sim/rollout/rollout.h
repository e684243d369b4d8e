// The simulated sequence and what is needed to differentiate it.
#ifndef CLOTHID_SIM_ROLLOUT_ROLLOUT_H_
#define CLOTHID_SIM_ROLLOUT_ROLLOUT_H_

#include <Eigen/Core>
#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "sim/path/handle_path.h"
#include "sim/rollout/step_record.h"
#include "sim/scene/parameters.h"
#include "sim/step/step_counts.h"

namespace clothid {

class ClothModel;
class Correction;
class Simulator;

struct Rollout {
  Parameters parameters;
  double start_time = 0.0;                       // s
  double time_step = 0.0;                        // h, s
  double step_tolerance = 0.0;                   // relative residual asked of the steps
  Eigen::VectorXd initial_positions;             // x_0 [3N]
  Eigen::VectorXd initial_velocities;            // v_0 [3N]
  HandlePath handle_offsets;                     // see RolloutOptions; no handles: none
  std::shared_ptr<const Correction> correction;  // see RolloutOptions; null: none
  // In order of time; as many per step as its integrator has stages, more where substeps were taken. With checkpoints
  // those before the last one are empty, but for the checkpoints themselves; RecordReader (sim/rollout/record_reader.h)
  // makes them again.
  std::vector<StepRecord> records;
  std::vector<int> last_record;    // [T] the record that ends step n + 1
  int checkpoint_interval = 0;     // in steps; 0: none
  bool ends_with_factors = false;  // see RolloutOptions::factor_memory
  RolloutCounts counts;
  int cut_corrections = 0;             // those that would have let the cloth cut itself
  std::optional<StepFailure> failure;  // set: the rollout is not to be used

  bool ok() const { return !failure.has_value(); }
  int num_steps() const { return static_cast<int>(last_record.size()); }
  // x after `step` steps, before it is corrected; step 0 is the start. Throws `std::logic_error` for a step that is not
  // kept.
  const Eigen::VectorXd& positions(int step) const;
  std::size_t bytes() const;  // of the memory that it holds
};

struct RolloutOptions {
  // Relative residual asked of a step. Absent: the scene's.
  std::optional<double> step_tolerance;
  // x_0 [3N] m, handles and all, and v_0 [3N] m/s, in place of the scene's. Null: the scene's.
  const Eigen::VectorXd* initial_positions = nullptr;
  const Eigen::VectorXd* initial_velocities = nullptr;
  // Added to the path of the scene's handles, of which there must be one. Null: nothing.
  const HandlePath* handle_offsets = nullptr;
  // Corrects the state at the end of some steps (sim/rollout/correction.h). What visitors and `Rollout::positions` tell
  // is what the step has come to, before that. Null: none.
  std::shared_ptr<const Correction> correction = nullptr;
  // 0: every step is kept. c > 0: of every c steps the last one, a checkpoint, and all after the last checkpoint;
  // PullBack simulates the others again, c at a time.
  int checkpoint_interval = 0;
  // Positive: every step ends with a factor of its Jacobian, which starts the next step, and up to so many bytes of
  // them are kept for PullBack, which then factors hardly any. It pays for a gradient of few columns. Within the
  // tolerance of the steps, the states are others than those without.
  std::size_t factor_memory = 0;
  // Called with x [3N] after `step` steps, from step 0 on, kept or not. May be empty.
  std::function<void(int step, const Eigen::VectorXd& positions)> visitor;
  // Called with the last solve of every step. May be empty.
  std::function<void(int step, const StepRecord& end)> end_visitor = {};
  // A rollout of the same scene with other parameters: every step is cut into substeps as there and starts from its
  // velocities. A stiff step may have several solutions; near by the parameters this finds the one that goes over into
  // that of `followed`. May be null; not with checkpoints.
  const Rollout* followed = nullptr;
};

// The checkpoint interval with which a rollout of `num_steps` steps and its PullBack hold at most `memory_limit` bytes
// of records, as if every free node touched an obstacle where there are some, and the cloth where that may meet itself:
// 0 where all steps fit, else the largest that fits, so that the fewest are simulated again, or that of the least need.
int CheckpointInterval(const ClothModel& model, int num_steps, std::size_t memory_limit);

// Runs the scene of `simulator` with `parameters` from its start state, `num_steps` steps. Never throws on a step that
// does not converge: see `Rollout::failure`. `cancel` (may be null) ends the rollout as failed when it turns true.
// Throws `Error` for parameters out of range.
Rollout Simulate(const Parameters& parameters, int num_steps, Simulator* simulator,
                 const std::atomic<bool>* cancel = nullptr, const RolloutOptions& options = {});

}  // namespace clothid

#endif  // CLOTHID_SIM_ROLLOUT_ROLLOUT_H_
