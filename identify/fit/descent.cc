#include "identify/fit/descent.h"

#include <algorithm>
#include <memory>
#include <string>
#include <utility>

#include "identify/estimate/estimate.h"
#include "identify/fit/joint_stage.h"
#include "identify/fit/plan.h"
#include "identify/fit/stage_rows.h"
#include "identify/problem/gauss_newton.h"

namespace clothid {
namespace {

// Of a stage that starts near the solution, as far as the region grows on the way there.
constexpr double kNearTrustRegion = 1e4;
// A loose start whose cost is this many times that of the end does not have a lower one: in 21 fits the loose cost of
// the start was off by .5 % at most.
constexpr double kClearlyHigher = 2.0;
// Of the parameters after all unknowns were moved together: what is believed of knots that nothing tells is exact.
constexpr double kJointTrustRegion = 1e8;
// Trials of a memory end where the next step lowers the cost by less than this share or is shorter than .5 %, and
// after so many iterations, which do not count for the others.
constexpr double kTrialTolerance = 1e-5;
constexpr double kTrialStep = 5e3;
constexpr int kMostTrialIterations = 8;

FitStatus StatusOf(ceres::TerminationType type) {
  switch (type) {
    case ceres::CONVERGENCE:
    case ceres::USER_SUCCESS:
      return FitStatus::kConverged;
    case ceres::NO_CONVERGENCE:
      return FitStatus::kNotConverged;
    case ceres::FAILURE:
    case ceres::USER_FAILURE:
      break;
  }
  return FitStatus::kFailed;
}

// Steps that lead to points that fail are cut until they meet the tolerances. That is no minimum.
void SetStatus(ceres::TerminationType type, const std::string& message, const FitRecorder& recorder,
               FitSummary* summary) {
  summary->status = StatusOf(type);
  // Ceres says it of the last stage alone.
  summary->message = type == ceres::NO_CONVERGENCE ? "stopped at max_iterations"
                     : type == ceres::USER_SUCCESS ? "the next step is negligible"
                                                   : message;
  if (recorder.failure().empty()) return;
  if (summary->status == FitStatus::kFailed) summary->message = recorder.failure();
  if (summary->status == FitStatus::kConverged) {
    summary->status = FitStatus::kNotConverged;
    summary->message = "stopped where the points ahead fail: " + recorder.failure();
  }
}

bool IsAt(const QuadraticModel& model, const Eigen::VectorXd& coordinates) {
  return model.coordinates.size() == coordinates.size() && model.coordinates == coordinates;
}

}  // namespace

Descent::Descent(const FitOptions& options, FitProblem* problem)
    : options_(options),
      problem_(problem),
      coordinates_(problem->StartCoordinates()),
      evaluator_(problem, options.num_threads),
      recorder_(options, *problem, evaluator_) {}

bool Descent::Begin(FitPlan plan) {
  summary_.plan = std::move(plan);
  problem_->Restart();
  const bool is_empty = summary_.plan.empty();
  const bool asks_for_rows = !is_empty && summary_.plan.front().share == 1.0 && !problem_->is_all_frozen();
  precision_ = is_empty ? Precision::kFull : summary_.plan.front().precision;
  const auto derivative = asks_for_rows ? FitEvaluator::Derivative::kRows : FitEvaluator::Derivative::kNone;
  if (!evaluator_.Evaluate(coordinates_, derivative, &start_cost_, nullptr, precision_)) {
    summary_.message = "the rollout at the starting values failed: " + evaluator_.last_failure();
    return false;
  }
  CountFromHere();
  if (!is_empty) return true;
  summary_.status = FitStatus::kConverged;
  summary_.message = "every parameter is frozen";
  return false;
}

void Descent::RunStages() {
  for (std::size_t i = 0; i < summary_.plan.size() && !options_.is_cancelled(); ++i) {
    if (summary_.plan[i].state != StageState::kAhead) continue;
    if (IsNeedless(summary_.plan[i])) {
      SkipStage(i, "the stages before have led near enough");
      continue;
    }
    BeginStage(i);
    Move(summary_.plan[i]);
    EndStage(i);
  }
}

bool Descent::IsNeedless(const FitStage& stage) const {
  return is_near() && !stage.is_joint() && stage.precision == Precision::kLoose && stage.share == 1.0;
}

void Descent::BeginStage(std::size_t stage) {
  summary_.plan[stage].state = StageState::kRunning;
  Tell(stage);
}

void Descent::EndStage(std::size_t stage) {
  FitStage* const ended = &summary_.plan[stage];
  ended->state = StageState::kDone;
  ended->note = summary_.message;
  ended->rollouts = evaluator_.statistics().rollouts - rollouts_before_;
  ended->cost = evaluator_.best().is_valid() ? evaluator_.best().cost : 0.0;
  CountFromHere();
  Tell(stage);
}

void Descent::SkipStage(std::size_t stage, const char* why) {
  summary_.plan[stage].state = StageState::kSkipped;
  summary_.plan[stage].note = why;
  CountFromHere();
  Tell(stage);
}

void Descent::CountFromHere() { rollouts_before_ = evaluator_.statistics().rollouts; }

void Descent::Tell(std::size_t stage) const {
  if (options_.on_stage) options_.on_stage(summary_.plan, static_cast<int>(stage));
}

void Descent::Move(const FitStage& stage) {
  if (stage.is_joint()) return MoveJointly(stage);
  const int before = recorder_.next_iteration();
  MoveAlone(stage);
  if (stage.is_trial) num_trial_iterations_ += recorder_.next_iteration() - before;
}

FitEvaluator::Derivative Descent::NearDerivative() const {
  return problem_->has_few_blocks() ? FitEvaluator::Derivative::kExactRows : FitEvaluator::Derivative::kRows;
}

StageGoal Descent::GoalOf(const FitStage& stage) const {
  StageGoal goal;
  goal.precision = stage.precision;
  goal.first_iteration = recorder_.next_iteration();
  goal.function_tolerance = options_.function_tolerance;
  if (stage.is_trial) goal.function_tolerance = kTrialTolerance;
  if (stage.is_trial) goal.step = kTrialStep;
  if (stage.is_rough) goal.function_tolerance = kLooseStepTolerance;
  // No other stage makes up for a minimum that a loose last one misses.
  if (stage.is_rough || stage.precision == Precision::kLoose) goal.step = kShortStep;
  if (is_near() && !stage.is_rough) {
    goal.trust_region = trust_region_;
    goal.has_exact_rows = problem_->has_few_blocks();
  }
  return goal;
}

// Levenberg-Marquardt over the parameters alone.
void Descent::MoveAlone(const FitStage& stage) {
  known_ = BasisLinearization();
  if (stage.precision == Precision::kFull && precision_ == Precision::kLoose) GoOverToFull();
  const StageGoal goal = GoalOf(stage);
  const UnknownBasis basis = MakeBasis(*problem_, /*with_starts=*/false, /*field_modes=*/0);
  FreshRows rows(*problem_, basis, coordinates_, goal.precision, goal.has_exact_rows, &evaluator_);
  Eigen::VectorXd free = rows.FreeCoordinates(coordinates_);
  const std::unique_ptr<ceres::Problem> ceres_problem = rows.MakeCeresProblem(free.data());
  const int most = stage.is_trial ? std::min(kMostTrialIterations, options_.max_iterations)
                                  : std::max(0, most_iterations() - goal.first_iteration);
  ceres::Solver::Options solver = StageSolver(goal.trust_region, most, options_.parameter_tolerance);
  solver.function_tolerance = options_.function_tolerance;
  solver.callbacks.push_back(&recorder_);
  recorder_.StartStage(goal);
  ceres::Solver::Summary result;
  ceres::Solve(solver, ceres_problem.get(), &result);
  coordinates_ = rows.Unknowns(free.data());
  SetStatus(result.termination_type, result.message, recorder_, &summary_);
  const bool leads_on = stage.precision == Precision::kLoose && IsAt(evaluator_.model(), coordinates_);
  if (leads_on) summary_.next = NextPoint(*problem_, evaluator_.model(), kShortStep);
}

// Goes over to full precision where the last stage was loose, from where its next step leads, so that no point is
// simulated with both. Points that work loosely may fail with full precision; where these do, the stage starts where
// the fit did.
void Descent::GoOverToFull() {
  evaluator_.SupersedeLoose();
  precision_ = Precision::kFull;
  const Eigen::VectorXd last = coordinates_, next = std::exchange(summary_.next, Eigen::VectorXd());
  const bool has_next = recorder_.last_iteration() < most_iterations() && next.size() > 0;
  const bool works = (has_next && TryPoint(next, NearDerivative())) || TryPoint(last, NearDerivative());
  trust_region_ = works ? kNearTrustRegion : kInitialTrustRegion;
  coordinates_ = works ? evaluator_.best().coordinates : problem_->StartCoordinates();
}

bool Descent::TryPoint(const Eigen::VectorXd& point, FitEvaluator::Derivative derivative) {
  double cost = 0.0;
  if (!evaluator_.Evaluate(point, derivative, &cost, nullptr)) return false;
  coordinates_ = point;
  return true;
}

// The parameters with everything else, from the best point so far.
void Descent::MoveJointly(const FitStage& stage) {
  if (stage.precision == Precision::kFull && precision_ == Precision::kLoose) {
    evaluator_.SupersedeLoose();
    precision_ = Precision::kFull;
  }
  summary_.next.resize(0);
  double cost = 0.0;
  evaluator_.Evaluate(coordinates_, FitEvaluator::Derivative::kNone, &cost, nullptr, stage.precision);
  StageGoal goal{stage.precision};
  goal.first_iteration = recorder_.last_iteration();
  goal.has_rows = false;
  recorder_.StartStage(goal);
  JointStageResult result = RunJointStage(options_, stage, most_iterations() - goal.first_iteration, std::move(known_),
                                          &recorder_, problem_, &coordinates_, &evaluator_);
  known_ = std::move(result.known);
  summary_.status = result.ok ? FitStatus::kConverged : FitStatus::kFailed;
  summary_.message = result.ok ? "converged" : result.failure;
  trust_region_ = result.ok ? kJointTrustRegion : kInitialTrustRegion;
  if (!result.ok) known_ = BasisLinearization();
  if (stage.is_rough && result.ok) summary_.message = "the next step promises little";
  if (!result.ok || stage.is_rough) return;
  const bool is_stalled = result.predicted_decrease > kStalledDecrease;
  if (is_stalled) summary_.message = "stopped at a kink of the cost";
  const bool is_cut = is_stalled || (stage.field_modes > 0 && !result.is_over);
  if (!is_cut || recorder_.last_iteration() < most_iterations()) return;
  summary_.status = FitStatus::kNotConverged;
  summary_.message = "stopped at max_iterations";
}

void Descent::MoveTo(const Eigen::VectorXd& coordinates, bool is_near) {
  coordinates_ = coordinates;
  trust_region_ = is_near ? kNearTrustRegion : kInitialTrustRegion;
  if (is_near) precision_ = Precision::kFull;
}

void Descent::ArriveAt(const Eigen::VectorXd& coordinates, bool is_settled) {
  double cost = 0.0;
  const auto derivative = is_settled ? NearDerivative() : FitEvaluator::Derivative::kRows;
  const Precision precision = is_settled ? Precision::kFull : precision_;
  if (!evaluator_.Evaluate(coordinates, derivative, &cost, nullptr, precision) || !(cost < start_cost_)) return;
  MoveTo(coordinates,
         is_settled && NextStepIsNegligible(*problem_, evaluator_.model(), kShortStep, kLooseStepTolerance));
}

void Descent::GoOn(const FitPlan& plan, bool is_near) {
  trust_region_ = is_near ? kNearTrustRegion : kInitialTrustRegion;
  precision_ = is_near ? Precision::kFull : plan.front().precision;
  summary_.plan.insert(summary_.plan.end(), plan.begin(), plan.end());
  CountFromHere();
  RunStages();
}

void Descent::GoOnFromLowerStart() {
  const FitPoint& best = evaluator_.best();
  if (options_.is_cancelled() || !best.is_valid() || best.precision == Precision::kLoose ||
      evaluator_.best_is_superseded() || evaluator_.first_compares()) {
    return;
  }
  const double cost = best.cost;
  if (!problem_->chooses_weights() && start_cost_ > kClearlyHigher * cost) return;
  const Eigen::VectorXd start = problem_->StartCoordinates();
  if (!evaluator_.SetFirst(start) || !(best.cost < cost)) return;
  summary_.plan.back().note += "; the start has a lower cost";
  FitStage last = summary_.plan.back();
  last.state = StageState::kAhead;
  last.note.clear();
  last.with_weights = false;  // costs with others would not compare
  summary_.plan.push_back(last);
  coordinates_ = start;
  known_ = BasisLinearization();
  CountFromHere();
  RunStages();
}

bool Descent::has_point() const {
  return evaluator_.best().is_valid() && (!evaluator_.best_is_superseded() || options_.is_cancelled());
}

FitSummary Descent::End(bool is_answer) {
  if (options_.is_cancelled()) {
    summary_.status = FitStatus::kInterrupted;
    summary_.message = kInterruptedMessage;
  }
  if (is_answer && has_point()) FillEstimate(*problem_, evaluator_, &summary_);
  problem_->CheckJournals();
  recorder_.AddLast();
  summary_.iterations = recorder_.iterations();
  summary_.statistics += evaluator_.statistics();
  summary_.total_seconds = recorder_.seconds();
  summary_.solver_seconds = std::max(0.0, summary_.total_seconds - evaluator_.seconds());
  if (known_.linearization.jacobian.size() > 0) summary_.linearization = std::move(known_);
  return std::move(summary_);
}

FitSummary Descend(const FitOptions& options, FitProblem* problem) {
  Descent descent(options, problem);
  if (descent.Begin(MakePlan(options, *problem, /*is_led=*/false))) {
    descent.RunStages();
    descent.GoOnFromLowerStart();
  }
  return descent.End(/*is_answer=*/true);
}

}  // namespace clothid
