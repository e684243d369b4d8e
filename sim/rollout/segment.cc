#include "sim/rollout/segment.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

#include "sim/cloth/cloth_model.h"
#include "sim/rollout/simulator.h"
#include "sim/step/step_problem.h"
#include "sim/step/step_solver.h"

namespace clothid {
namespace {

StepFailure FailureWithout(int step, const std::string& reason) {
  StepFailure failure;
  failure.step = step;
  failure.reason = reason;
  return failure;
}

StepFailure DescribeFailure(int step, double tolerance, const StepPoint& point) {
  StepFailure failure = FailureWithout(step, "did not converge");
  failure.residual = point.relative_residual;
  failure.tolerance = tolerance;
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

class StepLoop {
 public:
  StepLoop(const Parameters& parameters, const Segment& segment, Simulator* simulator)
      : parameters_(parameters),
        segment_(segment),
        scene_(simulator->scene()),
        simulator_(simulator),
        tolerance_(segment.step_tolerance.value_or(scene_.solver.step_tolerance)) {}

  SegmentOutcome Run(const StepVisitor& visitor, StepState* state) {
    simulator_->step_solver().Reset(segment_.end_with_factors);
    std::vector<StepRecord> records;
    for (int step = segment_.first_step; step <= segment_.last_step; ++step) {
      if (segment_.cancel != nullptr && segment_.cancel->load()) {
        outcome_.failure = FailureWithout(step, "was cancelled");
        break;
      }
      outcome_.failure = Advance(step, *state, &records);
      if (!outcome_.ok()) {
        ++outcome_.counts.failed_steps;
        break;
      }
      CountStep(records, state);
      state->positions = records.back().positions;
      state->velocities = records.back().velocities;
      visitor(step, std::move(records));
    }
    return std::move(outcome_);
  }

 private:
  // On success `records` are the solves; of a failure, the first attempt is told.
  std::optional<StepFailure> Advance(int step, const StepState& start, std::vector<StepRecord>* records) {
    std::vector<Eigen::VectorXd> guesses;
    if (segment_.guesses) guesses = segment_.guesses(step);
    const int first = std::max(1, static_cast<int>(guesses.size())), most = 1 << scene_.solver.max_substep_halvings;
    if (first > most) {
      return FailureWithout(step, "is cut into " + std::to_string(first) +
                                      " solves in the rollout that it follows; expected at most " +
                                      std::to_string(most) + ", as the scene's max_substep_halvings says");
    }
    std::optional<StepFailure> failure;
    for (int num_solves = first; num_solves <= most; num_solves *= 2) {
      StepFailure attempt;
      if (SolveInParts(step, num_solves, start, guesses, records, &attempt)) return std::nullopt;
      if (num_solves == first) failure = std::move(attempt);
    }
    return failure;
  }

  // The step as `num_solves` solves of the same length, each from its guess where there are as many.
  bool SolveInParts(int step, int num_solves, const StepState& start, const std::vector<Eigen::VectorXd>& guesses,
                    std::vector<StepRecord>* records, StepFailure* failure) {
    StepSolver& solver = simulator_->step_solver();
    const double h = scene_.time_step / num_solves;
    StepPoint point;
    records->clear();
    for (int i = 1; i <= num_solves; ++i) {
      const Eigen::VectorXd& x = i == 1 ? start.positions : records->back().positions;
      const Eigen::VectorXd& v = i == 1 ? start.velocities : records->back().velocities;
      const double end_time = scene_.start_time + ((step - 1) + static_cast<double>(i) / num_solves) * scene_.time_step;
      const StepProblem problem(simulator_->model(), parameters_, x, v, h, end_time, &simulator_->step_workspace(),
                                segment_.handle_offsets);
      const Eigen::VectorXd* guess = num_solves == static_cast<int>(guesses.size()) ? &guesses[i - 1] : nullptr;
      if (!solver.Solve(problem, tolerance_, guess, &point, &outcome_.counts)) {
        *failure = DescribeFailure(step, StepSolver::Tolerance(problem, tolerance_, point), point);
        return false;
      }
      StepRecord record{end_time, h, point.positions, problem.AllVelocities(point), {}, solver.end_factor()};
      if (problem.may_touch()) record.contacts = RecordContacts(problem.ActiveContacts(point));
      records->push_back(std::move(record));
    }
    return true;
  }

  void CountStep(const std::vector<StepRecord>& records, StepState* state) {
    ++outcome_.counts.steps;
    outcome_.counts.substeps += static_cast<int>(records.size()) - 1;
    if (!simulator_->model().has_contact()) return;
    const std::vector<ContactRecord>* before = state->contacts ? &*state->contacts : &records.front().contacts;
    for (const StepRecord& record : records) {
      CountContactChanges(*before, record.contacts, &outcome_.counts);
      before = &record.contacts;
    }
    state->contacts = *before;
  }

  const Parameters& parameters_;
  const Segment& segment_;
  const Scene& scene_;
  Simulator* simulator_;
  double tolerance_;
  SegmentOutcome outcome_;
};

}  // namespace

StepState StartState(const Scene& scene, const Eigen::VectorXd* initial_positions,
                     const Eigen::VectorXd* initial_velocities) {
  const auto choose = [](const Eigen::VectorXd& own, const Eigen::VectorXd* given, const std::string& what) {
    if (given == nullptr) return own;
    if (given->size() == own.size()) return *given;
    throw std::logic_error(std::to_string(given->size()) + " initial " + what + "; expected " +
                           std::to_string(own.size()));
  };
  return {choose(scene.initial_positions, initial_positions, "positions"),
          choose(scene.initial_velocities, initial_velocities, "velocities")};
}

SegmentOutcome AdvanceSegment(const Parameters& parameters, const Segment& segment, const StepVisitor& visitor,
                              Simulator* simulator, StepState* state) {
  const HandlePath* const offsets = segment.handle_offsets;
  if (offsets != nullptr && offsets->num_handles() != simulator->scene().handles.path.num_handles()) {
    throw std::logic_error("offsets of " + std::to_string(offsets->num_handles()) + " handles; expected " +
                           std::to_string(simulator->scene().handles.path.num_handles()));
  }
  return StepLoop(parameters, segment, simulator).Run(visitor, state);
}

}  // namespace clothid
