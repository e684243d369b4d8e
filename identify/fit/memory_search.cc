#include "identify/fit/memory_search.h"

#include <limits>
#include <optional>
#include <utility>

#include "identify/fit/continued_fit.h"
#include "identify/fit/descent.h"
#include "identify/fit/plan.h"
#include "identify/problem/evaluator.h"
#include "identify/problem/gauss_newton.h"
#include "identify/problem/memory_trial.h"
#include "identify/problem/step_prediction.h"

namespace clothid {
namespace {

class MemorySearch {
 public:
  // After `exact`, a fit without corrections.
  MemorySearch(const FitOptions& options, const std::vector<RecordedMotion>* motions, const FitSummary& exact,
               FitProblem* problem)
      : options_(options),
        motions_(motions),
        problem_(problem),
        exact_end_(exact.coordinates),
        descent_(options, problem) {
    exact_.coordinates = exact.coordinates.head(problem->num_blocks());
    exact_.std = Eigen::VectorXd::Constant(problem->num_blocks(), std::numeric_limits<double>::quiet_NaN());
    exact_.cost = exact.cost - problem->PriorCost(exact.coordinates);
  }

  // With an estimate where that explains the recordings better than `exact`, with `memory_trials` in any case.
  FitSummary Run() {
    const FitPlan plan = PlanMemoryTrials(*problem_);
    problem_->Assimilate({plan.front().memory});
    bool has_answer = false;
    if (descent_.Begin(plan)) {
      MoveToLowerStart();
      TryMemories();
      has_answer = !IsOver() && !FirstStands();
      if (has_answer && !FitWithout()) FitWith(trials_.back().memory);
      if (has_answer) descent_.GoOnFromLowerStart();
    }
    has_answer = has_answer && !options_.is_cancelled();
    // The trials began elsewhere, and with another cost.
    if (has_answer && descent_.has_point() && !evaluator().first_compares()) {
      evaluator().SetFirst(problem_->StartCoordinates());
    }
    FitSummary summary = descent_.End(has_answer);
    summary.memory_trials = std::move(trials_);
    return summary;
  }

 private:
  FitEvaluator& evaluator() { return descent_.evaluator(); }
  bool IsOver() const { return options_.is_cancelled() || trials_.empty(); }
  // Of the recordings alone.
  double CostOf(const FitPoint& point) const { return point.cost - problem_->PriorCost(point.coordinates); }

  bool IsLostAt(const Eigen::VectorXd& point) {
    const QuadraticModel& model = evaluator().model();
    return model.coordinates.size() == point.size() && model.coordinates == point &&
           AmplifiesBeyondTheCloth(*problem_, model);
  }

  // Costs with corrections have one minimum: trials begin where theirs is lower, at the start or where the fit before
  // them has ended.
  void MoveToLowerStart() {
    Eigen::VectorXd end = exact_end_;
    end.segment(problem_->num_blocks(), problem_->num_start_unknowns()).setZero();  // corrections find them
    double cost = 0.0;
    if (evaluator().Evaluate(end, FitEvaluator::Derivative::kRows, &cost, nullptr) && cost < descent_.start_cost() &&
        !IsLostAt(end)) {
      descent_.MoveTo(end, /*is_near=*/false);
    }
  }

  // From the shortest to the longest that serves.
  void TryMemories() {
    bool has_end = false, has_jumped = false;
    for (std::size_t i = 0; i < descent_.plan().size() && !options_.is_cancelled(); ++i) {
      if (has_end) {
        descent_.SkipStage(i, "a shorter memory is the longest that serves");
        continue;
      }
      const Eigen::VectorXd before = descent_.coordinates();
      std::optional<MemoryTrial> trial = Try(i);
      if (trial && (trials_.empty() || Follows(problem_->blocks(), trials_.back(), *trial))) {
        trials_.push_back(std::move(*trial));
      } else if (trial && trial->cost < trials_.back().cost && !has_jumped) {
        has_jumped = true;
        TryAgain(i);
      } else {
        has_end = true;
        descent_.MoveTo(before, /*is_near=*/false);
        if (trial) descent_.summary().message = "the estimate jumps: the cost has other minima";
      }
      descent_.EndStage(i);
    }
  }

  // With one memory, from where the one before it has led. Nothing where that fails.
  std::optional<MemoryTrial> Try(std::size_t stage) {
    descent_.BeginStage(stage);
    const FitStage trial = descent_.plan()[stage];
    problem_->Assimilate({trial.memory});
    evaluator().SupersedeBest();
    descent_.Move(trial);
    if (evaluator().best_is_superseded() || descent_.summary().status == FitStatus::kFailed) return std::nullopt;
    descent_.MoveTo(evaluator().best().coordinates, /*is_near=*/false);
    if (IsLostAt(evaluator().best().coordinates)) return std::nullopt;
    return DescribeTrial(*problem_, evaluator(), trial.memory);
  }

  // A short memory has told too little beside the noise: the last two once more, from where the long one leads.
  void TryAgain(std::size_t stage) {
    trials_.clear();
    FitPlan* const plan = &descent_.plan();
    const auto after = static_cast<FitPlan::difference_type>(stage) + 1;
    FitPlan again(plan->begin() + after - 2, plan->begin() + after);
    for (FitStage& trial : again) trial.state = StageState::kAhead;
    plan->insert(plan->begin() + after, again.begin(), again.end());
  }

  // Whether the fit before the trials explains the recordings as well.
  bool FirstStands() { return IsNoWorse(exact_.cost, trials_) || IsRuledByStep(); }

  // Whether half the step would move the end of the trials so far that the fit before them stands.
  bool IsRuledByStep() {
    if (motions_ == nullptr) return false;
    const Eigen::VectorXd end = descent_.coordinates();
    const std::optional<Eigen::VectorXd> corrected = MoveByStep(end);
    if (!corrected || IsShort(*problem_, end, *corrected, kShortStep)) return false;
    const Assimilation assimilation = problem_->assimilation();
    problem_->Assimilate({});
    const std::optional<Eigen::VectorXd> exact = MoveByStep(exact_end_);
    const bool has_stalled = !exact || ExactHasStalled();
    problem_->Assimilate(assimilation);
    evaluator().SupersedeBest();
    if (has_stalled || !IsMovedLess(*problem_, {exact_end_, *exact}, {end, *corrected})) return false;
    descent_.plan().back().note = "the time step decides what is estimated with corrections";
    return true;
  }

  // Whether the fit before the trials, where the evaluator is, has ended short of its minimum: then it has no
  // intervals.
  bool ExactHasStalled() {
    const MemoryTrial end = DescribeTrial(*problem_, evaluator(), 0.0);
    return exact_.cost - end.cost > kStalledDecrease * end.residual_scale * end.residual_scale;
  }

  // Where a fit at half the step would end, from `point` [p], with the corrections of the problem.
  std::optional<Eigen::VectorXd> MoveByStep(const Eigen::VectorXd& point) {
    evaluator().SupersedeBest();
    double cost = 0.0;
    if (!evaluator().Evaluate(point, FitEvaluator::Derivative::kRows, &cost, nullptr)) return std::nullopt;
    return HalfStepMove(*motions_, options_, *problem_, &evaluator(), &descent_.summary().statistics);
  }

  // Without corrections from where the trials have led, where that may explain the recordings as well and is not where
  // the first fit has ended. Whether it does.
  bool FitWithout() {
    if (Follows(problem_->blocks(), trials_.back(), exact_) || !MayLeaveLess()) return false;
    const bool is_near = NextStepIsNegligible(*problem_, evaluator().model(), kShortStep, kLooseStepTolerance);
    if (!is_near) evaluator().SupersedeBest();
    descent_.GoOn(MakePlan(options_, *problem_, /*is_led=*/false), is_near);
    const FitPoint& best = evaluator().best();
    const bool has_end = best.is_valid() && !evaluator().best_is_superseded();
    if (options_.is_cancelled() || (has_end && IsNoWorse(CostOf(best), trials_))) return true;
    Eigen::VectorXd end = problem_->StartCoordinates();
    end.head(problem_->num_blocks()) = trials_.back().coordinates;
    descent_.MoveTo(end, /*is_near=*/true);
    return false;
  }

  // Whether rollouts that nothing corrects may explain the recordings from where the trials have led. The evaluator has
  // their rows then.
  bool MayLeaveLess() {
    problem_->Assimilate({});
    evaluator().SupersedeBest();
    double cost = 0.0;
    return evaluator().Evaluate(descent_.coordinates(), descent_.NearDerivative(), &cost, nullptr) &&
           (MayBeNoise(trials_) || LeavesAsLittle(DescribeTrial(*problem_, evaluator(), 0.0).cost, trials_));
  }

  void FitWith(double memory) {
    problem_->Assimilate({memory});
    evaluator().SupersedeBest();
    descent_.GoOn(MakePlan(options_, *problem_, /*is_led=*/false), /*is_near=*/true);
  }

  const FitOptions& options_;
  const std::vector<RecordedMotion>* motions_;
  FitProblem* problem_;
  MemoryTrial exact_;          // the fit without corrections
  Eigen::VectorXd exact_end_;  // where it has ended [p + n + f]
  Descent descent_;
  std::vector<MemoryTrial> trials_;  // those that serve
};

}  // namespace

bool MayAssimilate(const FitOptions& options, const FitProblem& problem, const FitSummary& summary) {
  return options.assimilate.kind == AssimilationOption::Kind::kAuto && summary.memory_trials.empty() &&
         options.max_iterations > 0 && !problem.is_all_frozen() && !options.is_cancelled() &&
         !LeavesNoise(problem, summary.predicted, summary.cost);
}

void AssimilateFit(const FitOptions& options, const std::vector<RecordedMotion>* motions, FitProblem* problem,
                   FitSummary* summary) {
  summary->why_not_assimilated = WhyNotAssimilated(*problem);
  if (!summary->why_not_assimilated.empty() || MemoriesOf(*problem).empty()) return;
  problem->HoldWeights(true);
  FitOptions next = OptionsOfNext(options, *problem, *summary);
  next.max_iterations = options.max_iterations;  // of the trials and of what follows
  FitSummary found = MemorySearch(next, motions, *summary, problem).Run();
  // One that does not come to its end is no better than one that did.
  const bool is_taken =
      found.has_estimate() && (found.status == FitStatus::kConverged || summary->status != FitStatus::kConverged);
  problem->Assimilate(is_taken ? found.assimilation : Assimilation());
  AppendFit(std::move(found), is_taken, summary);
  problem->HoldWeights(false);
}

}  // namespace clothid
