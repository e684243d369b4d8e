#include "identify/fit/fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "identify/fit/continued_fit.h"
#include "identify/fit/estimate.h"
#include "identify/fit/first_frames.h"
#include "identify/fit/fit_recorder.h"
#include "identify/fit/joint_stage.h"
#include "identify/fit/plan.h"
#include "identify/fit/stage_rows.h"
#include "identify/problem/evaluator.h"
#include "identify/problem/gauss_newton.h"
#include "identify/problem/memory_trial.h"
#include "identify/problem/model_errors.h"
#include "identify/problem/step_prediction.h"
#include "identify/uncertainty/discretization_error.h"

namespace clothid {
namespace {

// Of a stage that starts near the solution, as far as the region grows on the way there.
constexpr double kNearTrustRegion = 1e4;
// Of the parameters after all unknowns were moved together: what is believed of knots that nothing tells is exact.
constexpr double kJointTrustRegion = 1e8;
// The loose stage ends where the next step is shorter than this, in resolutions of the parameters: 5 %. Its square is
// what a Gauss-Newton step misses, and about what loose rollouts do.
constexpr double kShortStep = 5e4;
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

// The stages of a plan, one after the other.
class PlannedFit {
 public:
  PlannedFit(const FitOptions& options, const std::vector<RecordedMotion>* motions, FitProblem* problem)
      : options_(options),
        motions_(motions),
        problem_(problem),
        coordinates_(problem->StartCoordinates()),
        evaluator_(problem, options.num_threads),
        recorder_(options, *problem, evaluator_) {
    summary_.plan =
        MakePlan(options, *problem, motions != nullptr && options.growing_horizon && options.max_iterations > 0);
  }

  // The trials of memories (identify/problem/memory_trial.h) after `exact`, a fit without corrections. It ends with
  // `summary.memory_trials` alone where that explains the recordings as well.
  PlannedFit(const FitOptions& options, const std::vector<RecordedMotion>* motions, const FitSummary& exact,
             FitProblem* problem)
      : PlannedFit(options, motions, problem) {
    summary_.plan = PlanMemoryTrials(*problem);
    exact_end_ = exact.coordinates;
    exact_.coordinates = exact.coordinates.head(problem->num_blocks());
    exact_.std = Eigen::VectorXd::Constant(problem->num_blocks(), std::numeric_limits<double>::quiet_NaN());
    exact_.cost = exact.cost - problem->PriorCost(exact.coordinates);
    if (!summary_.plan.empty()) problem->Assimilate({summary_.plan.front().memory});
  }

  FitSummary Run() {
    problem_->Restart();
    if (Start()) {
      for (stage_ = 0; stage_ < static_cast<int>(summary_.plan.size()) && !options_.is_cancelled(); ++stage_) {
        RunStage();
      }
      if (!tries_memories() || has_answer()) GoOnFromLowerStart();
    }
    if (options_.is_cancelled()) {
      summary_.status = FitStatus::kInterrupted;
      summary_.message = kInterruptedMessage;
    }
    Finish();
    return std::move(summary_);
  }

 private:
  // Before anything runs, so that a start that does not work is told with its reason. The first stage finds it cached,
  // with the rows that it asks for, unless it is led away from there.
  bool Start() {
    const bool asks_for_rows =
        !summary_.plan.empty() && summary_.plan.front().share == 1.0 && !problem_->is_all_frozen();
    precision_ = summary_.plan.empty() ? Precision::kFull : summary_.plan.front().precision;
    const auto derivative = asks_for_rows ? FitEvaluator::Derivative::kRows : FitEvaluator::Derivative::kNone;
    if (!evaluator_.Evaluate(coordinates_, derivative, &start_cost_, nullptr, precision_)) {
      summary_.message = "the rollout at the starting values failed: " + evaluator_.last_failure();
      return false;
    }
    if (tries_memories()) StartTrials(derivative);
    if (!summary_.plan.empty()) return true;
    summary_.status = FitStatus::kConverged;
    summary_.message = "every parameter is frozen";
    return true;
  }

  // Their cost has one minimum: they begin where it is lower, at the start or where the fit before them has ended.
  void StartTrials(FitEvaluator::Derivative derivative) {
    Eigen::VectorXd end = exact_end_;
    end.segment(problem_->num_blocks(), problem_->num_start_unknowns()).setZero();  // corrections find them
    double cost = 0.0;
    if (evaluator_.Evaluate(end, derivative, &cost, nullptr) && cost < start_cost_) coordinates_ = end;
  }

  void RunStage() {
    FitStage* const stage = &summary_.plan[static_cast<std::size_t>(stage_)];
    const int num_before = evaluator_.statistics().rollouts;
    if (lead_ && stage->share == 1.0 && !has_arrived_) Arrive();
    if (IsNeedless(*stage)) {
      stage->state = StageState::kSkipped;
      stage->note = "the stages before have led near enough";
      return Tell();
    }
    if (stage->is_trial && has_memory_) {
      stage->state = StageState::kSkipped;
      stage->note = "a shorter memory is the longest that serves";
      Tell();
      return EndTrials();
    }
    stage->state = StageState::kRunning;
    Tell();
    if (stage->share < 1.0) return RunFirstFrames(stage);
    if (stage->is_trial) {
      return RunTrialStage(num_before);
    } else if (stage->is_joint()) {
      RunJoint(*stage);
    } else {
      RunAlone(*stage);
    }
    EndStage(num_before);
    if (stage_ == last_exact_stage_) JudgeExact();
  }

  // Loose stages, and those with other weights, were never compared with the start as costs are at the end. Where it is
  // lower, the last stage goes on from there.
  void GoOnFromLowerStart() {
    const FitPoint& best = evaluator_.best();
    if (options_.is_cancelled() || !best.is_valid() || best.precision == Precision::kLoose ||
        evaluator_.best_is_superseded() || evaluator_.first_compares()) {
      return;
    }
    const double cost = best.cost;
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
    RunStage();
  }

  void EndStage(int rollouts_before) {
    FitStage* const stage = &summary_.plan[static_cast<std::size_t>(stage_)];
    stage->state = StageState::kDone;
    stage->note = summary_.message;
    stage->rollouts = evaluator_.statistics().rollouts - rollouts_before;
    stage->cost = evaluator_.best().is_valid() ? evaluator_.best().cost : 0.0;
    Tell();
  }

  bool is_last_stage() const { return stage_ + 1 == static_cast<int>(summary_.plan.size()); }

  // The plan may grow by it.
  void RunTrialStage(int rollouts_before) {
    const int before = recorder_.next_iteration();
    RunTrial(FitStage(summary_.plan[static_cast<std::size_t>(stage_)]));
    num_trial_iterations_ += recorder_.next_iteration() - before;
    EndStage(rollouts_before);
    EndTrials();
  }

  // With one memory, from where the one before it has led.
  void RunTrial(const FitStage& stage) {
    const Eigen::VectorXd before = coordinates_;
    problem_->Assimilate({stage.memory});
    evaluator_.SupersedeBest();
    RunAlone(stage);
    if (evaluator_.best_is_superseded() || summary_.status == FitStatus::kFailed) {
      has_memory_ = true;
      coordinates_ = before;
      return;
    }
    coordinates_ = evaluator_.best().coordinates;
    MemoryTrial trial = DescribeTrial(*problem_, evaluator_, stage.memory);
    if (trials_.empty() || Follows(problem_->blocks(), trials_.back(), trial)) {
      trials_.push_back(std::move(trial));
      return;
    }
    if (trial.cost < trials_.back().cost && !has_jumped_) return TryAgain();
    has_memory_ = true;
    coordinates_ = before;
    summary_.message = "the estimate jumps: the cost has other minima";
  }

  // A short memory has told too little beside the noise: the last two once more, from where the long one leads.
  void TryAgain() {
    has_jumped_ = true;
    trials_.clear();
    std::vector<FitStage> again(summary_.plan.begin() + stage_ - 1, summary_.plan.begin() + stage_ + 1);
    for (FitStage& stage : again) stage.state = StageState::kAhead;
    summary_.plan.insert(summary_.plan.begin() + stage_ + 1, again.begin(), again.end());
  }

  // After the last trial: what is left of the fit.
  void EndTrials() {
    if (!is_last_stage() || options_.is_cancelled() || trials_.empty()) return;
    is_exact_ = IsNoWorse(exact_.cost, trials_) || IsRuledByStep();
    if (is_exact_) return;
    if (!Follows(problem_->blocks(), trials_.back(), exact_) && MayLeaveLess()) return TryExact();
    GoOnWith({trials_.back().memory});
  }

  // Whether half the step would move the end of the trials so far that the fit before them stands.
  bool IsRuledByStep() {
    if (motions_ == nullptr) return false;
    const std::optional<Eigen::VectorXd> corrected = MoveByStep(coordinates_);
    if (!corrected || IsShort(*problem_, coordinates_, *corrected, kShortStep)) return false;
    const Assimilation assimilation = problem_->assimilation();
    problem_->Assimilate({});
    const std::optional<Eigen::VectorXd> exact = MoveByStep(exact_end_);
    const bool has_stalled = !exact || ExactHasStalled();
    problem_->Assimilate(assimilation);
    evaluator_.SupersedeBest();
    if (has_stalled || !IsMovedLess(*problem_, {exact_end_, *exact}, {coordinates_, *corrected})) return false;
    summary_.plan[static_cast<std::size_t>(stage_)].note = "the time step decides what is estimated with corrections";
    return true;
  }

  // Whether the fit before the trials, where the evaluator is, has ended short of its minimum: then it has no
  // intervals.
  bool ExactHasStalled() const {
    const MemoryTrial end = DescribeTrial(*problem_, evaluator_, 0.0);
    return exact_.cost - end.cost > kStalledDecrease * end.residual_scale * end.residual_scale;
  }

  // Where a fit at half the step would end, from `point` [p], with the corrections of the problem.
  std::optional<Eigen::VectorXd> MoveByStep(const Eigen::VectorXd& point) {
    evaluator_.SupersedeBest();
    double cost = 0.0;
    if (!evaluator_.Evaluate(point, FitEvaluator::Derivative::kRows, &cost, nullptr)) return std::nullopt;
    return HalfStepMove(*motions_, options_, *problem_, &evaluator_, &summary_.statistics);
  }

  // Whether rollouts that nothing corrects may explain the recordings from where the trials have led. The evaluator has
  // their rows then.
  bool MayLeaveLess() {
    problem_->Assimilate({});
    evaluator_.SupersedeBest();
    double cost = 0.0;
    return evaluator_.Evaluate(coordinates_, NearDerivative(), &cost, nullptr) &&
           (MayBeNoise(trials_) || LeavesAsLittle(DescribeTrial(*problem_, evaluator_, 0.0).cost, trials_));
  }

  // Plans a fit of them.
  void TryExact() {
    const FitPlan again = MakePlan(options_, *problem_, /*is_led=*/false);
    is_near_ = NextStepIsNegligible(*problem_, evaluator_.model(), kShortStep, kLooseStepTolerance);
    if (!is_near_) evaluator_.SupersedeBest();
    precision_ = is_near_ || again.empty() ? Precision::kFull : again.front().precision;
    summary_.plan.insert(summary_.plan.end(), again.begin(), again.end());
    last_exact_stage_ = static_cast<int>(summary_.plan.size()) - 1;
  }

  void JudgeExact() {
    const FitPoint& best = evaluator_.best();
    const bool has_end = best.is_valid() && !evaluator_.best_is_superseded();
    if (options_.is_cancelled() || (has_end && IsNoWorse(CostOf(best), trials_))) return;
    coordinates_ = problem_->StartCoordinates();
    coordinates_.head(problem_->num_blocks()) = trials_.back().coordinates;
    has_joint_ = false;
    GoOnWith({trials_.back().memory});
  }

  bool tries_memories() const { return exact_end_.size() > 0; }
  // Of trials: whether they have led to one other than the fit before them.
  bool has_answer() const { return !trials_.empty() && !is_exact_ && !options_.is_cancelled(); }

  // Of the recordings alone.
  double CostOf(const FitPoint& point) const { return point.cost - problem_->PriorCost(point.coordinates); }

  // Plans the stages that end the fit, from where it is.
  void GoOnWith(const Assimilation& assimilation) {
    problem_->Assimilate(assimilation);
    evaluator_.SupersedeBest();
    const FitPlan rest = MakePlan(options_, *problem_, /*is_led=*/false);
    precision_ = Precision::kFull;
    is_near_ = true;
    summary_.plan.insert(summary_.plan.end(), rest.begin(), rest.end());
  }

  void Tell() const {
    if (options_.on_stage) options_.on_stage(summary_.plan, stage_);
  }

  bool IsNeedless(const FitStage& stage) const {
    return is_near_ && !stage.is_joint() && stage.precision == Precision::kLoose && stage.share == 1.0;
  }

  void RunFirstFrames(FitStage* stage) {
    if (!lead_) {
      recorder_.AddStart();
      lead_.emplace();
      lead_->coordinates = coordinates_.head(problem_->num_blocks());
    }
    const bool goes_on = !is_lost_ && FitFirstFrames(*motions_, options_, *problem_, &Fit, stage, &*lead_);
    if (is_lost_) {
      stage->state = StageState::kSkipped;
      stage->note = "the frames before found nothing";
    }
    is_lost_ = !goes_on;
    Tell();
  }

  // Whether the last of the first frames moved no parameter far: then all frames are not expected to, either.
  bool IsSettled() const {
    return options_.precision == FitPrecision::kAdaptive && precision_ == Precision::kLoose &&
           problem_->num_unknowns() == 0 && lead_->last_step.size() > 0 &&
           IsShort(*problem_, lead_->coordinates, lead_->last_step, kShortStep);
  }

  // From the start to where the first frames lead, unless the cost is higher there. That of the start may be loose: the
  // end is compared with it once more.
  void Arrive() {
    has_arrived_ = true;
    Eigen::VectorXd led = coordinates_;
    led.head(problem_->num_blocks()) = lead_->coordinates;
    if (options_.is_cancelled() || led == coordinates_) return;
    const bool is_settled = IsSettled();
    const Precision precision = is_settled ? Precision::kFull : precision_;
    double cost = 0.0;
    if (!evaluator_.Evaluate(led, is_settled ? NearDerivative() : FitEvaluator::Derivative::kRows, &cost, nullptr,
                             precision) ||
        !(cost < start_cost_)) {
      return;
    }
    coordinates_ = led;
    is_near_ = is_settled && NextStepIsNegligible(*problem_, evaluator_.model(), kShortStep, kLooseStepTolerance);
    if (is_near_) precision_ = Precision::kFull;
  }

  // The rows of a point near the solution: where they are cheap, those that the intervals of the last one need.
  FitEvaluator::Derivative NearDerivative() const {
    return problem_->has_few_blocks() ? FitEvaluator::Derivative::kExactRows : FitEvaluator::Derivative::kRows;
  }

  // Moves to `point` where that works.
  bool MoveTo(const Eigen::VectorXd& point, FitEvaluator::Derivative derivative) {
    double cost = 0.0;
    if (!evaluator_.Evaluate(point, derivative, &cost, nullptr)) return false;
    coordinates_ = point;
    return true;
  }

  // Goes over to full precision where the last stage was loose, from where its next step leads, so that no point is
  // simulated with both. Points that work loosely may fail with full precision; where these do, the stage starts where
  // the fit did.
  void GoOverToFull() {
    evaluator_.SupersedeLoose();
    precision_ = Precision::kFull;
    const Eigen::VectorXd last = coordinates_, next = std::exchange(summary_.next, Eigen::VectorXd());
    const bool has_next = recorder_.last_iteration() < most_iterations() && next.size() > 0;
    is_near_ = (has_next && MoveTo(next, NearDerivative())) || MoveTo(last, NearDerivative());
    coordinates_ = is_near_ ? evaluator_.best().coordinates : problem_->StartCoordinates();
  }

  // The number of the last one that a stage may end with.
  int most_iterations() const { return options_.max_iterations + num_trial_iterations_; }

  // Levenberg-Marquardt over the parameters alone.
  void RunAlone(const FitStage& stage) {
    known_ = BasisLinearization();
    if (stage.precision == Precision::kFull && precision_ == Precision::kLoose) GoOverToFull();
    StageGoal goal;
    goal.precision = stage.precision;
    goal.first_iteration = recorder_.next_iteration();
    goal.function_tolerance = options_.function_tolerance;
    if (stage.is_trial) goal.function_tolerance = kTrialTolerance;
    if (stage.is_trial) goal.step = kTrialStep;
    if (stage.is_rough) goal.function_tolerance = kLooseStepTolerance;
    // No other stage makes up for a minimum that a loose last one misses.
    if (stage.is_rough || stage.precision == Precision::kLoose) goal.step = kShortStep;
    if (is_near_ && !stage.is_rough) {
      goal.trust_region = has_joint_ ? kJointTrustRegion : kNearTrustRegion;
      goal.has_exact_rows = problem_->has_few_blocks();
    }
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

  // The parameters with everything else, from the best point so far.
  void RunJoint(const FitStage& stage) {
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
    JointStageResult result = RunJointStage(options_, stage, most_iterations() - goal.first_iteration,
                                            std::move(known_), &recorder_, problem_, &coordinates_, &evaluator_);
    known_ = std::move(result.known);
    summary_.status = result.ok ? FitStatus::kConverged : FitStatus::kFailed;
    summary_.message = result.ok ? "converged" : result.failure;
    is_near_ = result.ok;
    has_joint_ = true;
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

  void Finish() {
    // A loose point is better than none only where somebody has stopped the fit there.
    const bool has_estimate = evaluator_.best().is_valid() &&
                              (!evaluator_.best_is_superseded() || options_.is_cancelled()) &&
                              (!tries_memories() || has_answer());
    // The trials began elsewhere, and with another cost.
    if (has_estimate && tries_memories() && !evaluator_.first_compares())
      evaluator_.SetFirst(problem_->StartCoordinates());
    if (has_estimate) FillEstimate(*problem_, evaluator_, &summary_);
    summary_.memory_trials = trials_;
    problem_->CheckJournals();
    recorder_.AddLast();
    summary_.iterations = recorder_.iterations();
    summary_.statistics += evaluator_.statistics();
    summary_.total_seconds = recorder_.seconds();
    const double led_seconds = lead_ ? lead_->evaluation_seconds : 0.0;
    if (lead_) {
      summary_.statistics += lead_->statistics;
      summary_.lead = lead_->statistics;
    }
    summary_.solver_seconds = std::max(0.0, summary_.total_seconds - evaluator_.seconds() - led_seconds);
    if (known_.linearization.jacobian.size() > 0) summary_.linearization = std::move(known_);
  }

  const FitOptions& options_;
  const std::vector<RecordedMotion>* motions_;
  FitProblem* problem_;
  Eigen::VectorXd coordinates_;
  FitEvaluator evaluator_;
  FitRecorder recorder_;
  FitSummary summary_;
  int stage_ = 0;
  Precision precision_ = Precision::kFull;  // of the point
  double start_cost_ = 0.0;
  std::optional<Lead> lead_;
  bool has_arrived_ = false, is_lost_ = false;  // of first frames
  std::vector<MemoryTrial> trials_;             // those that serve
  int num_trial_iterations_ = 0;
  bool has_memory_ = false;    // no longer one serves
  bool has_jumped_ = false;    // a longer one has led elsewhere, and down
  MemoryTrial exact_;          // the fit without corrections that has led to the trials
  Eigen::VectorXd exact_end_;  // where it has ended [p + n + f]; empty: there are no trials
  bool is_exact_ = false;      // it explains the recordings as well
  int last_exact_stage_ = -1;  // of another one, from where the trials have led
  bool is_near_ = false;       // a point near the solution is known
  bool has_joint_ = false;     // from a joint stage
  BasisLinearization known_;
};

// A fit that goes on from another, and how sure it is. What else follows a fit comes after the last of them.
FitSummary FitOn(const FitOptions& options, FitProblem* problem) {
  FitSummary summary = PlannedFit(options, /*motions=*/nullptr, problem).Run();
  if (options.estimate_uncertainty && summary.has_estimate()) AddUncertainty(options, *problem, &summary);
  return summary;
}

// Where what `summary` leaves is no noise: with the recordings correcting the rollouts, if they can, and if that
// explains them better.
void AssimilateFit(const FitOptions& options, const std::vector<RecordedMotion>* motions, FitProblem* problem,
                   FitSummary* summary) {
  if (options.assimilate.kind != AssimilationOption::Kind::kAuto || !summary->memory_trials.empty() ||
      options.max_iterations == 0 || problem->is_all_frozen() || options.is_cancelled() ||
      LeavesNoise(*problem, summary->predicted, summary->cost)) {
    return;
  }
  summary->why_not_assimilated = WhyNotAssimilated(*problem);
  if (!summary->why_not_assimilated.empty() || MemoriesOf(*problem).empty()) return;
  problem->HoldWeights(true);
  FitOptions next = OptionsOfNext(options, *problem, *summary);
  next.max_iterations = options.max_iterations;  // of the trials and of what follows
  FitSummary found = PlannedFit(next, motions, *summary, problem).Run();
  // One that does not come to its end is no better than one that did.
  const bool is_taken =
      found.has_estimate() && (found.status == FitStatus::kConverged || summary->status != FitStatus::kConverged);
  problem->Assimilate(is_taken ? found.assimilation : Assimilation());
  AppendFit(std::move(found), is_taken, summary);
  problem->HoldWeights(false);
}

}  // namespace

FitSummary Fit(const FitOptions& options, FitProblem* problem) { return Fit(options, problem, nullptr); }

FitSummary Fit(const FitOptions& options, FitProblem* problem, const std::vector<RecordedMotion>* motions) {
  if (options.assimilate.kind == AssimilationOption::Kind::kAuto) problem->Assimilate({});
  if (problem->finds_model_error() && problem->has_model_error()) problem->SetModelErrors(NoModelErrors(*problem));
  FitSummary summary = PlannedFit(options, motions, problem).Run();
  if (options.estimate_uncertainty && summary.has_estimate()) FinishFit(options, problem, &summary, motions);
  return summary;
}

void FinishFit(const FitOptions& options, FitProblem* problem, FitSummary* summary,
               const std::vector<RecordedMotion>* motions) {
  AssimilateFit(options, motions, problem, summary);
  AddUncertainty(options, *problem, summary);
  ContinueFromLowerPoints(options, &FitOn, problem, summary);
  WeighFit(options, problem, summary, motions);
}

void WeighFit(const FitOptions& options, FitProblem* problem, FitSummary* summary,
              const std::vector<RecordedMotion>* motions) {
  AssimilateFit(options, motions, problem, summary);
  WeighByModelError(options, &FitOn, problem, summary);
  const bool is_weighed = problem->finds_model_error() && problem->has_model_error();
  if (is_weighed || !summary->uncertainty) {
    AddUncertainty(options, *problem, summary);
    ContinueFromLowerPoints(options, &FitOn, problem, summary);
  }
  if (!summary->uncertainty || !problem->assimilation().is_on() || summary->memory_trials.empty()) return;
  const Eigen::VectorXd blocks = summary->coordinates.head(problem->num_blocks());
  AddMemoryErrors(problem->blocks(), blocks, DriftOf(summary->memory_trials, blocks), &*summary->uncertainty);
}

}  // namespace clothid
