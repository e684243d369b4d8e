#include "sim/rollout/segment.h"

#include <algorithm>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include "sim/cloth/cloth_model.h"
#include "sim/contact/intersections.h"
#include "sim/rollout/correction.h"
#include "sim/rollout/simulator.h"
#include "sim/step/second_start.h"
#include "sim/step/step_problem.h"
#include "sim/step/step_solver.h"

namespace clothid {
namespace {

// How often a solve is repeated with pairs of the cloth that it lacked.
constexpr int kMaxSecondSolves = 3;
// The smallest share of a correction that is tried where more of it lets the cloth cut itself.
constexpr double kLeastCorrection = 0.125;

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
        num_stages_(NumStages(scene_.integrator)),
        simulator_(simulator),
        tolerance_(segment.step_tolerance.value_or(scene_.solver.step_tolerance)) {
    if (scene_.self_contact) counter_ = std::make_unique<IntersectionCounter>(scene_.mesh);
  }

  SegmentOutcome Run(const StepVisitor& visitor, StepState* state) {
    simulator_->step_solver().Reset(segment_.end_with_factors);
    is_clean_ = IsClean(*state);
    const std::string problem = Indefinite(parameters_, scene_);
    if (!problem.empty()) {
      outcome_.failure = FailureWithout(segment_.first_step, "was not tried: " + problem);
      return std::move(outcome_);
    }
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
      if (segment_.correction != nullptr && segment_.correction->Corrects(step)) {
        Correct(step, state->positions, &records.back());
      }
      const CorrectedState* const corrected = records.back().correction.get();
      state->positions = corrected == nullptr ? records.back().positions : corrected->positions;
      state->velocities = corrected == nullptr ? records.back().velocities : corrected->velocities;
      visitor(step, std::move(records));
    }
    return std::move(outcome_);
  }

 private:
  // On success `records` are the solves; of a failure, the first attempt is told.
  std::optional<StepFailure> Advance(int step, const StepState& start, std::vector<StepRecord>* records) {
    std::vector<Eigen::VectorXd> guesses;
    if (segment_.guesses) guesses = segment_.guesses(step);
    const int first = std::max(1, static_cast<int>(guesses.size()) / num_stages_);
    const int most = 1 << scene_.solver.max_substep_halvings;
    if (first > most) {
      return FailureWithout(step, "is cut into " + std::to_string(first) +
                                      " solves in the rollout that it follows; expected at most " +
                                      std::to_string(most) + ", as the scene's max_substep_halvings says");
    }
    std::optional<StepFailure> failure;
    std::vector<StepRecord> crossing;  // of an attempt that lets the cloth pass through itself
    for (int num_parts = first; num_parts <= most; num_parts *= 2) {
      StepFailure attempt;
      const bool solved = SolveInParts(step, num_parts, start, guesses, records, &attempt);
      const bool ends_clean = solved && IsClean(records->back());
      if (solved && (ends_clean || !is_clean_)) {
        is_clean_ = ends_clean;
        return std::nullopt;
      }
      if (solved) crossing.swap(*records);
      if (num_parts == first) failure = std::move(attempt);
    }
    if (crossing.empty()) return failure;
    is_clean_ = false;
    records->swap(crossing);
    return std::nullopt;
  }

  // Corrects the end of `step`, which has started from `start` [3N].
  void Correct(int step, const Eigen::VectorXd& start, StepRecord* record) {
    for (double scale = 1.0; scale >= kLeastCorrection; scale *= 0.5) {
      auto corrected = std::make_shared<const CorrectedState>(
          CorrectState(*segment_.correction, step, start, *record, parameters_, simulator_->model(), scale));
      const bool ends_clean = IsClean(*corrected);
      if (ends_clean || !is_clean_) {
        is_clean_ = ends_clean;
        record->correction = std::move(corrected);
        return;
      }
      if (scale == 1.0) ++outcome_.cut_corrections;
    }
  }

  template <class State>
  bool IsClean(const State& state) {
    return counter_ == nullptr || counter_->Count(state.positions).count == 0;
  }

  // The step as `num_parts` steps of the same length, their solves each from its guess where there are as many.
  bool SolveInParts(int step, int num_parts, const StepState& start, const std::vector<Eigen::VectorXd>& guesses,
                    std::vector<StepRecord>* records, StepFailure* failure) {
    const double h = scene_.time_step / num_parts;
    const bool has_guesses = num_parts * num_stages_ == static_cast<int>(guesses.size());
    records->clear();
    records->reserve(num_parts * num_stages_);  // ends of solves are starts of others
    for (int i = 0; i < num_parts; ++i) {
      const Eigen::VectorXd& x = i == 0 ? start.positions : records->back().positions;
      const Eigen::VectorXd& v = i == 0 ? start.velocities : records->back().velocities;
      const double end_time =
          scene_.start_time + ((step - 1) + static_cast<double>(i + 1) / num_parts) * scene_.time_step;
      const Eigen::VectorXd* guess = has_guesses ? &guesses[i * num_stages_] : nullptr;
      const bool solved = num_stages_ == 1 ? Solve(step, {x, v}, {h, end_time}, guess, {}, records, failure)
                                           : SolveInStages(step, {x, v}, h, end_time, guess, records, failure);
      if (!solved) return false;
    }
    return true;
  }

  // Both stages of a step of size h from `start`; `guesses`: null, or one for each.
  bool SolveInStages(int step, const SolveStart& start, double h, double end_time, const Eigen::VectorXd* guesses,
                     std::vector<StepRecord>* records, StepFailure* failure) {
    const double eta = kStageShare * h;
    const SolveTimes times{eta, end_time - h + eta, Stage::kFirst};
    if (!Solve(step, start, times, guesses, {}, records, failure)) return false;
    const StepRecord& first = records->back();
    const SecondStart second = StartSecondStage(simulator_->model(), parameters_.material, start, first.positions,
                                                first.velocities, eta, contacts_);
    // Where contacts do not let the stages resemble each other, the second may end near the first.
    std::vector<Eigen::VectorXd> candidates;
    if (!contacts_.nodes.empty()) candidates.push_back(point_.velocities);
    return Solve(step, {second.positions, second.velocities, &start.positions, &first.positions},
                 {eta, end_time, Stage::kSecond}, guesses == nullptr ? nullptr : guesses + 1, candidates, records,
                 failure);
  }

  // Appends the record of one solve, whose contacts stay in `contacts_`.
  bool Solve(int step, const SolveStart& start, const SolveTimes& times, const Eigen::VectorXd* guess,
             const std::vector<Eigen::VectorXd>& candidates, std::vector<StepRecord>* records, StepFailure* failure) {
    StepSolver& solver = simulator_->step_solver();
    StepProblem problem(simulator_->model(), parameters_, start, times, &simulator_->step_workspace(),
                        segment_.handle_offsets);
    bool solved = solver.Solve(problem, tolerance_, guess, &point_, &outcome_.counts, candidates);
    for (int round = 0; solved && round < kMaxSecondSolves && problem.TakesBackPairs(point_); ++round) {
      ++outcome_.counts.second_solves;
      solved = solver.SolveAgain(problem, tolerance_, &point_, &outcome_.counts);
    }
    if (!solved) {
      *failure = DescribeFailure(step, StepSolver::Tolerance(problem, tolerance_, point_), point_);
      return false;
    }
    problem.FindContacts(point_, &contacts_);
    records->push_back({times.end_time, times.time_step, point_.positions, problem.AllVelocities(point_),
                        RecordContacts(contacts_), solver.end_factor(), times.stage});
    return true;
  }

  void CountStep(const std::vector<StepRecord>& records, StepState* state) {
    ++outcome_.counts.steps;
    outcome_.counts.substeps += static_cast<int>(records.size()) / num_stages_ - 1;
    const ContactRecords* before = state->contacts ? &*state->contacts : &records[num_stages_ - 1].contacts;
    for (const StepRecord& record : records) {
      if (!record.ends_step()) continue;
      CountContactChanges(*before, record.contacts, &outcome_.counts);
      before = &record.contacts;
    }
    state->contacts = *before;
  }

  const Parameters& parameters_;
  const Segment& segment_;
  const Scene& scene_;
  const int num_stages_;  // of the scene's integrator
  Simulator* simulator_;
  double tolerance_;
  std::unique_ptr<IntersectionCounter> counter_;  // null without self-contact
  // The step starts with a cloth that does not cut itself: if it ends with one that does, it is cut into shorter ones
  // as a step that does not converge.
  bool is_clean_ = false;
  StepPoint point_;      // of the last solve
  ContactSet contacts_;  // at the end of the last solve that worked
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
