// The simulated sequence and what is needed to differentiate it.
#ifndef CLOTHID_SIM_ROLLOUT_ROLLOUT_H_
#define CLOTHID_SIM_ROLLOUT_ROLLOUT_H_

#include <Eigen/Core>
#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/contact/contact.h"
#include "sim/scene/parameters.h"

namespace clothid {

class ClothModel;
class Simulator;
struct ReducedFactor;  // sim/step/step_jacobian.h

// One implicit solve: a time step, or one of the substeps into which a difficult step was cut.
struct StepRecord {
  double time = 0.0;                    // at the end of the step, s
  double time_step = 0.0;               // h of this solve, s
  Eigen::VectorXd positions;            // x_{n+1} [3N] m
  Eigen::VectorXd velocities;           // v_{n+1} [3N] m/s
  std::vector<ContactRecord> contacts;  // the sticking and slipping nodes, ascending
  // Of the step Jacobian at the end of the step, or so near to it that few iterations make up for that. Steps that did
  // not need a factor of their own share one. Null: none is kept.
  std::shared_ptr<const ReducedFactor> factor;

  bool is_kept() const { return positions.size() > 0; }
};

// Counts over a rollout, for reports. Those of several rollouts add up.
struct RolloutCounts {
  int steps = 0;
  int newton_iterations = 0;
  int factorizations = 0;
  int linear_iterations = 0;  // of the linear solves of steps, with friction or with the factor of an earlier point
  int fallbacks = 0;          // solves handed to continuation in the friction
  int substeps = 0;           // solves beyond one per step: each makes the cost jump a little
  int failed_steps = 0;
  int contacts = 0;  // nodes in contact at the end of a solve
  // Contact events, from the end of one solve to the end of the next. Those that the first solve finds in contact have
  // not joined.
  int nodes_joined = 0;       // the contacts
  int nodes_left = 0;         // them
  int branch_switches = 0;    // from stick to slip or back
  int obstacle_switches = 0;  // contacts that jumped from one obstacle to another

  int contact_changes() const { return nodes_joined + nodes_left + branch_switches; }

  RolloutCounts& operator+=(const RolloutCounts& other);
  RolloutCounts& operator-=(const RolloutCounts& other);
};

// Why and where a rollout ended early.
struct StepFailure {
  int step = 0;           // 1-based
  double residual = 0.0;  // relative, the best one reached
  double tolerance = 0.0;
  int num_stick = 0, num_slip = 0, num_take_off = 0;
  std::string reason;

  std::string ToString() const;  // one line
};

struct Rollout {
  Parameters parameters;
  double start_time = 0.0;             // s
  double time_step = 0.0;              // h, s
  Eigen::VectorXd initial_positions;   // x_0 [3N]
  Eigen::VectorXd initial_velocities;  // v_0 [3N]
  // In order of time; one per step, more where substeps were taken. With checkpoints those before the last one are
  // empty, but for the checkpoints themselves; RecordReader (sim/rollout/record_reader.h) makes them again.
  std::vector<StepRecord> records;
  std::vector<int> last_record;    // [T] the record that ends step n + 1
  int checkpoint_interval = 0;     // in steps; 0: none
  bool ends_with_factors = false;  // see RolloutOptions::factor_memory
  RolloutCounts counts;
  std::optional<StepFailure> failure;  // set: the rollout is not to be used

  bool ok() const { return !failure.has_value(); }
  int num_steps() const { return static_cast<int>(last_record.size()); }
  // x after `step` steps; step 0 is the start. Throws `std::logic_error` for a step that is not kept.
  const Eigen::VectorXd& positions(int step) const;
  std::size_t bytes() const;  // of the memory that it holds
};

// Advances the state (x_n, v_n) [3N] by step number `step` (1-based) of the scene's time step, in one solve or, where
// that does not converge, in 2, 4, .. substeps. `followed` (may be null): see RolloutOptions. On success `records`
// holds the solves; otherwise false and `failure` is set.
bool AdvanceStep(const Parameters& parameters, int step, const Eigen::VectorXd& positions,
                 const Eigen::VectorXd& velocities, const Rollout* followed, Simulator* simulator,
                 std::vector<StepRecord>* records, RolloutCounts* counts, std::optional<StepFailure>* failure);

// Takes the solves of step number `step`.
using StepVisitor = std::function<void(int step, std::vector<StepRecord> records)>;

// Runs the steps `first_step` .. `last_step` from (x, v) [3N] at the start of the first, with a solver that was reset:
// they do not depend on what it did before. `end_with_factors`, `followed`: see RolloutOptions. False: a step did not
// converge or `cancel` (may be null) turned true, and `failure` is set.
bool AdvanceSegment(const Parameters& parameters, int first_step, int last_step, const Eigen::VectorXd& positions,
                    const Eigen::VectorXd& velocities, bool end_with_factors, const Rollout* followed,
                    const StepVisitor& visitor, Simulator* simulator, const std::atomic<bool>* cancel,
                    RolloutCounts* counts, std::optional<StepFailure>* failure);

// Adds the contacts `after` a solve, and their changes since the one before it, to `counts`.
void CountContactChanges(const std::vector<ContactRecord>& before, const std::vector<ContactRecord>& after,
                         RolloutCounts* counts);

struct RolloutOptions {
  // 0: every step is kept. c > 0: of every c steps the last one, a checkpoint, and all after the last checkpoint;
  // PullBack simulates the others again, c at a time.
  int checkpoint_interval = 0;
  // Positive: every step ends with a factor of its Jacobian, which starts the next step, and up to so many bytes of
  // them are kept for PullBack, which then factors hardly any. It pays for a gradient of few columns. Within the
  // tolerance of the steps, the states are others than those without.
  std::size_t factor_memory = 0;
  // Called with x [3N] after `step` steps, from step 0 on, kept or not. May be empty.
  std::function<void(int step, const Eigen::VectorXd& positions)> visitor;
  // A rollout of the same scene with other parameters: every step is cut into substeps as there and starts from its
  // velocities. A stiff step may have several solutions; near by the parameters this finds the one that goes over into
  // that of `followed`. May be null; not with checkpoints.
  const Rollout* followed = nullptr;
};

// The checkpoint interval with which a rollout of `num_steps` steps and its PullBack hold at most `memory_limit` bytes
// of records, as if every free node were in contact where there are obstacles: 0 where all steps fit, else the largest
// one that fits, so that the fewest steps are simulated again, or, where none does, the one that needs the least.
int CheckpointInterval(const ClothModel& model, int num_steps, std::size_t memory_limit);

// Runs the scene of `simulator` with `parameters` from its start state, `num_steps` steps. Never throws on a step that
// does not converge: see `Rollout::failure`. `cancel` (may be null) ends the rollout as failed when it turns true.
// Throws `Error` for parameters out of range.
Rollout Simulate(const Parameters& parameters, int num_steps, Simulator* simulator,
                 const std::atomic<bool>* cancel = nullptr, const RolloutOptions& options = {});

}  // namespace clothid

#endif  // CLOTHID_SIM_ROLLOUT_ROLLOUT_H_
