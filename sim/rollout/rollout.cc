#include "sim/rollout/rollout.h"

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <stdexcept>
#include <utility>

#include "sim/cloth/cloth_model.h"
#include "sim/rollout/simulator.h"
#include "sim/step/step.h"

namespace clothid {
namespace {

constexpr int RolloutCounts::*kCounts[] = {&RolloutCounts::steps,           &RolloutCounts::newton_iterations,
                                           &RolloutCounts::factorizations,  &RolloutCounts::linear_iterations,
                                           &RolloutCounts::fallbacks,       &RolloutCounts::substeps,
                                           &RolloutCounts::failed_steps,    &RolloutCounts::contacts,
                                           &RolloutCounts::nodes_joined,    &RolloutCounts::nodes_left,
                                           &RolloutCounts::branch_switches, &RolloutCounts::obstacle_switches};
static_assert(sizeof(RolloutCounts) == sizeof(int) * std::size(kCounts), "every count is listed");

StepFailure DescribeFailure(int step, double tolerance, const StepPoint& point, const std::string& reason) {
  StepFailure failure;
  failure.step = step;
  failure.residual = point.relative_residual;
  failure.tolerance = tolerance;
  failure.reason = reason;
  for (const ContactResponse& response : point.responses) {
    switch (response.branch) {
      case ContactBranch::kTakeOff:
        ++failure.num_take_off;
        break;
      case ContactBranch::kStick:
        ++failure.num_stick;
        break;
      case ContactBranch::kSlip:
        ++failure.num_slip;
        break;
    }
  }
  return failure;
}

// Adds the solves of the next step.
void Append(bool has_contact, std::vector<StepRecord> records, Rollout* rollout) {
  for (StepRecord& record : records) {
    if (has_contact) {
      const auto& before = rollout->records.empty() ? record.contacts : rollout->records.back().contacts;
      CountContactChanges(before, record.contacts, &rollout->counts);
    }
    rollout->records.push_back(std::move(record));
  }
  rollout->last_record.push_back(static_cast<int>(rollout->records.size()) - 1);
}

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

// The velocities [3 Nf] of the solves of `step` in `followed`; none where it is null or does not keep them.
std::vector<Eigen::VectorXd> Guesses(const ClothModel& model, const Rollout* followed, int step) {
  std::vector<Eigen::VectorXd> guesses;
  if (followed == nullptr || step > followed->num_steps()) return guesses;
  const int first = step == 1 ? 0 : followed->last_record[step - 2] + 1;
  for (int i = first; i <= followed->last_record[step - 1]; ++i) {
    if (!followed->records[i].is_kept()) return {};
    guesses.push_back(model.Gather(followed->records[i].velocities));
  }
  return guesses;
}

// Empties the records from step `first_step` on, all but the last.
void KeepCheckpoint(int first_step, Rollout* rollout) {
  const int first = first_step == 1 ? 0 : rollout->last_record[first_step - 2] + 1;
  for (std::size_t i = first; i + 1 < rollout->records.size(); ++i) {
    const StepRecord& record = rollout->records[i];
    rollout->records[i] = {record.time, record.time_step, {}, {}, {}, nullptr};
  }
}

}  // namespace

RolloutCounts& RolloutCounts::operator+=(const RolloutCounts& other) {
  for (int RolloutCounts::*const count : kCounts) this->*count += other.*count;
  return *this;
}

RolloutCounts& RolloutCounts::operator-=(const RolloutCounts& other) {
  for (int RolloutCounts::*const count : kCounts) this->*count -= other.*count;
  return *this;
}

std::string StepFailure::ToString() const {
  char text[256];
  std::snprintf(text, sizeof(text), "step %d %s: relative residual %.2e, tolerance %.2e, %d stick, %d slip, %d free",
                step, reason.c_str(), residual, tolerance, num_stick, num_slip, num_take_off);
  return text;
}

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
  std::size_t contacts = 0;
  std::size_t factors = 0;
  const ReducedFactor* last_factor = nullptr;
  for (const StepRecord& record : records) {
    if (record.factor != nullptr && record.factor.get() != last_factor) factors += record.factor->bytes();
    last_factor = record.factor.get();
    numbers += record.positions.size() + record.velocities.size();
    contacts += record.contacts.capacity();
  }
  return factors + numbers * sizeof(double) + contacts * sizeof(ContactRecord) +
         records.capacity() * sizeof(StepRecord) + last_record.capacity() * sizeof(int) + sizeof(*this);
}

void CountContactChanges(const std::vector<ContactRecord>& before, const std::vector<ContactRecord>& after,
                         RolloutCounts* counts) {
  counts->contacts += static_cast<int>(after.size());
  size_t i = 0, j = 0;  // both are in ascending order of nodes
  while (i < before.size() || j < after.size()) {
    const bool left = j == after.size() || (i < before.size() && before[i].node < after[j].node);
    const bool joined = i == before.size() || (j < after.size() && after[j].node < before[i].node);
    if (left) {
      ++counts->nodes_left;
    } else if (joined) {
      ++counts->nodes_joined;
    } else {
      counts->branch_switches += before[i].branch != after[j].branch;
      counts->obstacle_switches += before[i].obstacle != after[j].obstacle;
    }
    if (!joined) ++i;
    if (!left) ++j;
  }
}

bool AdvanceStep(const Parameters& parameters, int step, const Eigen::VectorXd& positions,
                 const Eigen::VectorXd& velocities, const Rollout* followed, Simulator* simulator,
                 std::vector<StepRecord>* records, RolloutCounts* counts, std::optional<StepFailure>* failure) {
  const Scene& scene = simulator->scene();
  StepSolver& solver = simulator->step_solver();
  StepPoint point;
  const std::vector<Eigen::VectorXd> guesses = Guesses(simulator->model(), followed, step);
  const int first_num_solves = std::max(1, static_cast<int>(guesses.size()));
  for (int num_solves = first_num_solves; num_solves <= 1 << scene.solver.max_substep_halvings; num_solves *= 2) {
    const double h = scene.time_step / num_solves;
    records->clear();
    for (int i = 1; i <= num_solves; ++i) {
      const Eigen::VectorXd& x = i == 1 ? positions : records->back().positions;
      const Eigen::VectorXd& v = i == 1 ? velocities : records->back().velocities;
      const double end_time = scene.start_time + ((step - 1) + static_cast<double>(i) / num_solves) * scene.time_step;
      const StepProblem problem(simulator->model(), parameters, x, v, h, end_time, &simulator->step_workspace());
      const Eigen::VectorXd* guess = num_solves == static_cast<int>(guesses.size()) ? &guesses[i - 1] : nullptr;
      if (!solver.Solve(problem, parameters.friction_coefficients, guess, &point, counts)) {
        if (num_solves == first_num_solves) {
          *failure = DescribeFailure(step, solver.Tolerance(problem, point), point, "did not converge");
        }
        break;
      }
      StepRecord record{end_time, h, point.positions, problem.AllVelocities(point), {}, solver.end_factor()};
      if (problem.may_touch()) record.contacts = RecordContacts(problem.ActiveContacts(point));
      records->push_back(std::move(record));
    }
    if (static_cast<int>(records->size()) == num_solves) {
      ++counts->steps;
      counts->substeps += num_solves - 1;
      failure->reset();
      return true;
    }
  }
  ++counts->failed_steps;
  return false;
}

bool AdvanceSegment(const Parameters& parameters, int first_step, int last_step, const Eigen::VectorXd& positions,
                    const Eigen::VectorXd& velocities, bool end_with_factors, const Rollout* followed,
                    const StepVisitor& visitor, Simulator* simulator, const std::atomic<bool>* cancel,
                    RolloutCounts* counts, std::optional<StepFailure>* failure) {
  simulator->step_solver().Reset(end_with_factors);
  Eigen::VectorXd x = positions, v = velocities;
  std::vector<StepRecord> records;
  for (int step = first_step; step <= last_step; ++step) {
    if (cancel != nullptr && cancel->load()) {
      failure->emplace();
      (*failure)->step = step;
      (*failure)->reason = "was cancelled";
      return false;
    }
    if (!AdvanceStep(parameters, step, x, v, followed, simulator, &records, counts, failure)) return false;
    x = records.back().positions;
    v = records.back().velocities;
    visitor(step, std::move(records));
  }
  return true;
}

int CheckpointInterval(const ClothModel& model, int num_steps, std::size_t memory_limit) {
  const std::size_t bytes_per_step = sizeof(StepRecord) + 6 * model.num_nodes() * sizeof(double) +
                                     (model.has_contact() ? model.num_free() * sizeof(ContactRecord) : 0);
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
  ValidateParameters(parameters, scene, "parameters");
  if (options.followed != nullptr && options.checkpoint_interval > 0) {
    throw std::logic_error("a rollout that follows another one cannot be made again from checkpoints");
  }
  Rollout rollout;
  rollout.parameters = parameters;
  rollout.start_time = scene.start_time;
  rollout.time_step = scene.time_step;
  rollout.checkpoint_interval = options.checkpoint_interval;
  rollout.ends_with_factors = options.factor_memory > 0;
  rollout.initial_positions = scene.initial_positions;
  rollout.initial_velocities = scene.initial_velocities;
  if (options.visitor) options.visitor(0, rollout.initial_positions);
  FactorBudget budget(options.factor_memory);
  const StepVisitor append = [&](int step, std::vector<StepRecord> records) {
    if (options.visitor) options.visitor(step, records.back().positions);
    for (StepRecord& record : records) budget.Keep(&record.factor);
    Append(simulator->model().has_contact(), std::move(records), &rollout);
  };
  const int interval = options.checkpoint_interval > 0 ? std::min(options.checkpoint_interval, num_steps) : num_steps;
  for (int first = 1; first <= num_steps; first += interval) {
    if (first > 1) KeepCheckpoint(first - interval, &rollout);
    const Eigen::VectorXd& x = first == 1 ? rollout.initial_positions : rollout.records.back().positions;
    const Eigen::VectorXd& v = first == 1 ? rollout.initial_velocities : rollout.records.back().velocities;
    const int last = std::min(first + interval - 1, num_steps);
    if (!AdvanceSegment(parameters, first, last, x, v, rollout.ends_with_factors, options.followed, append, simulator,
                        cancel, &rollout.counts, &rollout.failure)) {
      break;
    }
  }
  return rollout;
}

}  // namespace clothid
