#include "sim/rollout/rollout.h"

#include <algorithm>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include "sim/cloth/cloth_model.h"
#include "sim/rollout/correction.h"
#include "sim/rollout/segment.h"
#include "sim/rollout/simulator.h"
#include "sim/step/step_jacobian.h"

namespace clothid {
namespace {

// Drops the factors beyond so many bytes. One that several records share counts once.
class FactorBudget {
 public:
  explicit FactorBudget(std::size_t bytes) : left_(bytes) {}

  void Keep(std::shared_ptr<const ReducedFactor>* factor) {
    if (*factor == nullptr || *factor == last_) return;
    const std::size_t bytes = (*factor)->bytes();
    if (bytes > left_) {
      factor->reset();
      return;
    }
    left_ -= bytes;
    last_ = *factor;
  }

 private:
  std::size_t left_;
  std::shared_ptr<const ReducedFactor> last_;
};

// The velocities [3 Nf] of the solves of `step` in `followed`; none where it does not keep them.
std::vector<Eigen::VectorXd> Guesses(const ClothModel& model, const Rollout& followed, int step) {
  std::vector<Eigen::VectorXd> guesses;
  if (step > followed.num_steps()) return guesses;
  const int first = step == 1 ? 0 : followed.last_record[step - 2] + 1;
  for (int i = first; i <= followed.last_record[step - 1]; ++i) {
    if (!followed.records[i].is_kept()) return {};
    guesses.push_back(model.Gather(followed.records[i].velocities));
  }
  return guesses;
}

// Empties the records from step `first_step` on, all but the last.
void KeepCheckpoint(int first_step, Rollout* rollout) {
  const int first = first_step == 1 ? 0 : rollout->last_record[first_step - 2] + 1;
  for (std::size_t i = first; i + 1 < rollout->records.size(); ++i) {
    const StepRecord& record = rollout->records[i];
    rollout->records[i] = {record.time, record.time_step, {}, {}, {}, nullptr, record.stage};
  }
}

// A rollout before its first step.
Rollout EmptyRollout(const Parameters& parameters, const Scene& scene, const StepState& start,
                     const RolloutOptions& options) {
  Rollout rollout;
  rollout.parameters = parameters;
  rollout.start_time = scene.start_time;
  rollout.time_step = scene.time_step;
  rollout.step_tolerance = options.step_tolerance.value_or(scene.solver.step_tolerance);
  rollout.checkpoint_interval = options.checkpoint_interval;
  rollout.ends_with_factors = options.factor_memory > 0;
  rollout.initial_positions = start.positions;
  rollout.initial_velocities = start.velocities;
  rollout.correction = options.correction;
  if (options.handle_offsets != nullptr) rollout.handle_offsets = *options.handle_offsets;
  return rollout;
}

}  // namespace

const Eigen::VectorXd& Rollout::positions(int step) const {
  if (step == 0) return initial_positions;
  const StepRecord& record = records[last_record[step - 1]];
  if (!record.is_kept()) {
    throw std::logic_error("step " + std::to_string(step) + " is not kept; there is a checkpoint every " +
                           std::to_string(checkpoint_interval) + " steps");
  }
  return record.positions;
}

std::size_t Rollout::bytes() const {
  std::size_t numbers = initial_positions.size() + initial_velocities.size();
  std::size_t contacts = 0, factors = 0;
  const ReducedFactor* last_factor = nullptr;
  for (const StepRecord& record : records) {
    if (record.factor != nullptr && record.factor.get() != last_factor) factors += record.factor->bytes();
    last_factor = record.factor.get();
    numbers += record.positions.size() + record.velocities.size();
    if (record.correction != nullptr) numbers += 2 * record.correction->positions.size();
    contacts += record.contacts.bytes();
  }
  return factors + numbers * sizeof(double) + contacts + records.capacity() * sizeof(StepRecord) +
         last_record.capacity() * sizeof(int) + sizeof(*this);
}

int CheckpointInterval(const ClothModel& model, int num_steps, std::size_t memory_limit) {
  const std::size_t bytes_per_node = BytesPerNode(model.has_contact(), model.scene().self_contact.has_value());
  const std::size_t bytes_per_solve =
      sizeof(StepRecord) + 6 * model.num_nodes() * sizeof(double) + model.num_free() * bytes_per_node;
  const std::size_t bytes_per_step = NumStages(model.scene().integrator) * bytes_per_solve;
  const std::size_t limit = memory_limit / bytes_per_step;
  if (static_cast<std::size_t>(num_steps) <= limit) return 0;
  // The checkpoints, what follows the last one, and as many that are simulated again.
  const auto num_kept = [num_steps](int interval) {
    return static_cast<std::size_t>(num_steps / interval + 2 * interval);
  };
  int best = 1;
  for (int interval = 2; interval < num_steps; ++interval) {
    if (num_kept(interval) <= std::max(limit, num_kept(best))) best = interval;
  }
  return best;
}

Rollout Simulate(const Parameters& parameters, int num_steps, Simulator* simulator, const std::atomic<bool>* cancel,
                 const RolloutOptions& options) {
  const Scene& scene = simulator->scene();
  ValidateDomains(parameters, scene, "parameters");
  if (options.followed != nullptr && options.checkpoint_interval > 0) {
    throw std::logic_error("a rollout that follows another one cannot be made again from checkpoints");
  }
  simulator->UseParameters(parameters);
  StepState state = StartState(scene, options.initial_positions, options.initial_velocities);
  Rollout rollout = EmptyRollout(parameters, scene, state, options);
  if (options.visitor) options.visitor(0, rollout.initial_positions);
  FactorBudget budget(options.factor_memory);
  const StepVisitor append = [&](int step, std::vector<StepRecord> records) {
    if (options.visitor) options.visitor(step, records.back().positions);
    if (options.end_visitor) options.end_visitor(step, records.back());
    for (StepRecord& record : records) {
      budget.Keep(&record.factor);
      rollout.records.push_back(std::move(record));
    }
    rollout.last_record.push_back(static_cast<int>(rollout.records.size()) - 1);
  };
  Segment segment;
  segment.step_tolerance = rollout.step_tolerance;
  segment.end_with_factors = rollout.ends_with_factors;
  segment.handle_offsets = options.handle_offsets;
  segment.correction = options.correction.get();
  if (options.followed != nullptr) {
    segment.guesses = [&](int step) { return Guesses(simulator->model(), *options.followed, step); };
  }
  segment.cancel = cancel;
  const int interval = options.checkpoint_interval > 0 ? std::min(options.checkpoint_interval, num_steps) : num_steps;
  for (int first = 1; first <= num_steps && rollout.ok(); first += interval) {
    if (first > 1) KeepCheckpoint(first - interval, &rollout);
    segment.first_step = first;
    segment.last_step = std::min(first + interval - 1, num_steps);
    SegmentOutcome outcome = AdvanceSegment(parameters, segment, append, simulator, &state);
    rollout.counts += outcome.counts;
    rollout.cut_corrections += outcome.cut_corrections;
    rollout.failure = std::move(outcome.failure);
  }
  return rollout;
}

}  // namespace clothid
