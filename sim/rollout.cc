#include "sim/rollout.h"

#include <cstdio>
#include <iterator>
#include <utility>

#include "sim/cloth_model.h"
#include "sim/simulator.h"
#include "sim/step.h"

namespace clothid {
namespace {

constexpr int RolloutCounts::*kCounts[] = {&RolloutCounts::steps,
                                           &RolloutCounts::newton_iterations,
                                           &RolloutCounts::factorizations,
                                           &RolloutCounts::linear_iterations,
                                           &RolloutCounts::fallbacks,
                                           &RolloutCounts::substeps,
                                           &RolloutCounts::failed_steps,
                                           &RolloutCounts::contact_changes,
                                           &RolloutCounts::obstacle_switches};
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
  return step == 0 ? initial_positions : records[last_record[step - 1]].positions;
}

void CountContactChanges(const std::vector<Contact>& before, const std::vector<Contact>& after, RolloutCounts* counts) {
  // Both are in ascending order of nodes.
  size_t i = 0, j = 0;
  while (i < before.size() || j < after.size()) {
    const bool left = j == after.size() || (i < before.size() && before[i].candidate.node < after[j].candidate.node);
    const bool joined = i == before.size() || (j < after.size() && after[j].candidate.node < before[i].candidate.node);
    if (left || joined) {
      ++counts->contact_changes;
    } else {
      if (before[i].response.branch != after[j].response.branch) ++counts->contact_changes;
      if (before[i].candidate.obstacle != after[j].candidate.obstacle) ++counts->obstacle_switches;
    }
    if (!joined) ++i;
    if (!left) ++j;
  }
}

bool AdvanceStep(const Parameters& parameters, int step, const Eigen::VectorXd& positions,
                 const Eigen::VectorXd& velocities, Simulator* simulator, std::vector<StepRecord>* records,
                 RolloutCounts* counts, std::optional<StepFailure>* failure) {
  const Scene& scene = simulator->scene();
  StepSolver& solver = simulator->step_solver();
  StepPoint point;
  for (int halvings = 0; halvings <= scene.solver.max_substep_halvings; ++halvings) {
    const int num_solves = 1 << halvings;
    const double h = scene.time_step / num_solves;
    records->clear();
    for (int i = 1; i <= num_solves; ++i) {
      const Eigen::VectorXd& x = i == 1 ? positions : records->back().positions;
      const Eigen::VectorXd& v = i == 1 ? velocities : records->back().velocities;
      const double end_time = scene.start_time + ((step - 1) + static_cast<double>(i) / num_solves) * scene.time_step;
      const StepProblem problem(simulator->model(), parameters, x, v, h, end_time);
      if (!solver.Solve(problem, parameters.friction_coefficients, &point, counts)) {
        if (halvings == 0) {
          *failure = DescribeFailure(step, solver.Tolerance(problem, point), point, "did not converge");
        }
        break;
      }
      StepRecord record{end_time, h, point.positions, problem.AllVelocities(point), {}};
      if (problem.may_touch()) record.contacts = problem.ActiveContacts(point);
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

Rollout Simulate(const Parameters& parameters, int num_steps, Simulator* simulator, const std::atomic<bool>* cancel) {
  const Scene& scene = simulator->scene();
  ValidateParameters(parameters, scene, "parameters");
  Rollout rollout;
  rollout.parameters = parameters;
  rollout.start_time = scene.start_time;
  rollout.time_step = scene.time_step;
  rollout.initial_positions = scene.initial_positions;
  rollout.initial_velocities = scene.initial_velocities;
  const bool has_contact = simulator->model().has_contact();
  std::vector<StepRecord> records;
  simulator->step_solver().Reset();
  for (int step = 1; step <= num_steps; ++step) {
    if (cancel != nullptr && cancel->load()) {
      rollout.failure = StepFailure();
      rollout.failure->step = step;
      rollout.failure->reason = "was cancelled";
      return rollout;
    }
    const bool first = rollout.records.empty();
    const Eigen::VectorXd& x = first ? rollout.initial_positions : rollout.records.back().positions;
    const Eigen::VectorXd& v = first ? rollout.initial_velocities : rollout.records.back().velocities;
    if (!AdvanceStep(parameters, step, x, v, simulator, &records, &rollout.counts, &rollout.failure)) return rollout;
    for (StepRecord& record : records) {
      if (has_contact && !rollout.records.empty()) {
        CountContactChanges(rollout.records.back().contacts, record.contacts, &rollout.counts);
      }
      rollout.records.push_back(std::move(record));
    }
    rollout.last_record.push_back(static_cast<int>(rollout.records.size()) - 1);
  }
  return rollout;
}

}  // namespace clothid
