#include "identify/fit/fit.h"

#include <ceres/evaluation_callback.h>
#include <ceres/solver.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "identify/fit/continued_fit.h"
#include "identify/fit/estimate.h"
#include "identify/fit/evaluator.h"
#include "identify/fit/fit_recorder.h"
#include "identify/fit/gauss_newton.h"
#include "identify/fit/growing_horizon.h"
#include "identify/fit/start_estimate.h"
#include "identify/fit/start_stage.h"

namespace clothid {
namespace {

// Of a stage that starts near the solution, as far as the region grows on the way there.
constexpr double kNearTrustRegion = 1e4;
// The loose stage ends where the next step is shorter than this, in resolutions of the parameters: 5 %. Its square is
// what a Gauss-Newton step misses, and about what loose rollouts do.
constexpr double kShortStep = 5e4;

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
  summary->message = type == ceres::NO_CONVERGENCE ? "stopped at max_iterations" : message;
  if (recorder.failure().empty()) return;
  if (summary->status == FitStatus::kFailed) summary->message = recorder.failure();
  if (summary->status == FitStatus::kConverged) {
    summary->status = FitStatus::kNotConverged;
    summary->message = "stopped where the points ahead fail: " + recorder.failure();
  }
}

// Lets the evaluator fill the caches of the costs before Ceres asks them.
class CacheFiller : public ceres::EvaluationCallback {
 public:
  // All must outlive it. `coordinates`: the memory that Ceres changes.
  CacheFiller(const StageGoal& goal, const Eigen::VectorXd* coordinates, FitEvaluator* evaluator)
      : goal_(goal), coordinates_(coordinates), evaluator_(evaluator) {}

  void PrepareForEvaluation(bool evaluate_jacobians, bool /*new_evaluation_point*/) override {
    double cost = 0.0;
    auto derivative = evaluate_jacobians ? FitEvaluator::Derivative::kRows : FitEvaluator::Derivative::kNone;
    if (goal_.has_exact_rows) derivative = FitEvaluator::Derivative::kExactRows;
    // A failure shows again when Ceres asks the costs themselves.
    evaluator_->Evaluate(*coordinates_, derivative, &cost, nullptr, goal_.precision);
  }

 private:
  const StageGoal& goal_;
  const Eigen::VectorXd* coordinates_;
  FitEvaluator* evaluator_;
};

void RunLevenbergMarquardt(const FitOptions& options, const StageGoal& goal, FitProblem* problem,
                           Eigen::VectorXd* coordinates, FitEvaluator* evaluator, FitRecorder* recorder,
                           FitSummary* summary) {
  CacheFiller filler(goal, coordinates, evaluator);
  const std::unique_ptr<ceres::Problem> ceres_problem = problem->MakeCeresProblem(&filler, coordinates, goal.precision);
  ceres::Solver::Options solver;
  solver.minimizer_type = ceres::TRUST_REGION;
  solver.linear_solver_type = ceres::DENSE_QR;
  solver.initial_trust_region_radius = goal.trust_region;
  solver.max_num_iterations = std::max(0, options.max_iterations - goal.first_iteration);
  solver.function_tolerance = options.function_tolerance;
  solver.parameter_tolerance = options.parameter_tolerance;
  solver.num_threads = 1;  // the evaluator has its own
  solver.logging_type = ceres::SILENT;
  solver.callbacks.push_back(recorder);
  recorder->StartStage(goal);
  ceres::Solver::Summary result;
  ceres::Solve(solver, ceres_problem.get(), &result);
  SetStatus(result.termination_type, result.message, *recorder, summary);
}

bool IsAt(const QuadraticModel& model, const Eigen::VectorXd& coordinates) {
  return model.coordinates.size() == coordinates.size() && model.coordinates == coordinates;
}

// Moves to `point` where that works.
bool MoveTo(const Eigen::VectorXd& point, FitEvaluator::Derivative derivative, Eigen::VectorXd* coordinates,
            FitEvaluator* evaluator) {
  double cost = 0.0;
  if (!evaluator->Evaluate(point, derivative, &cost, nullptr)) return false;
  *coordinates = point;
  return true;
}

// The rows of a point near the solution: where they are cheap, those that the intervals of the last one need.
FitEvaluator::Derivative NearDerivative(const FitProblem& problem) {
  return problem.has_few_blocks() ? FitEvaluator::Derivative::kExactRows : FitEvaluator::Derivative::kRows;
}

StageGoal LooseGoal(int first_iteration) {
  return {Precision::kLoose, kShortStep, kLooseStepTolerance, kInitialTrustRegion, first_iteration};
}

// Where its next step leads is the start of another fit.
void RunLooseStage(const FitOptions& options, const StageGoal& goal, FitProblem* problem, Eigen::VectorXd* coordinates,
                   FitEvaluator* evaluator, FitRecorder* recorder, FitSummary* summary) {
  RunLevenbergMarquardt(options, goal, problem, coordinates, evaluator, recorder, summary);
  if (IsAt(evaluator->model(), *coordinates)) summary->next = NextPoint(*problem, evaluator->model(), kShortStep);
}

// To the end with full precision, from a point near the solution or from any other.
void RunFullStage(const FitOptions& options, bool is_near, int first_iteration, FitProblem* problem,
                  Eigen::VectorXd* coordinates, FitEvaluator* evaluator, FitRecorder* recorder, FitSummary* summary) {
  StageGoal full{Precision::kFull, 1.0, options.function_tolerance, kInitialTrustRegion, first_iteration};
  if (is_near) {
    full.trust_region = kNearTrustRegion;
    full.has_exact_rows = problem->has_few_blocks();
  }
  RunLevenbergMarquardt(options, full, problem, coordinates, evaluator, recorder, summary);
}

// The loose stage, and the full one from where its last step leads, so that no point is simulated with both. Points
// that work loosely may fail with full precision; where these do, the full stage starts where the fit did.
void RunWithIncreasingPrecision(const FitOptions& options, FitProblem* problem, Eigen::VectorXd* coordinates,
                                FitEvaluator* evaluator, FitRecorder* recorder, FitSummary* summary) {
  RunLooseStage(options, LooseGoal(recorder->next_iteration()), problem, coordinates, evaluator, recorder, summary);
  if (options.is_cancelled()) return;
  const int last_iteration = recorder->last_iteration();
  evaluator->SupersedeBest();
  const Eigen::VectorXd last = *coordinates, next = std::exchange(summary->next, Eigen::VectorXd());
  const bool has_next = last_iteration < options.max_iterations && next.size() > 0;
  const auto derivative = NearDerivative(*problem);
  const bool is_near = (has_next && MoveTo(next, derivative, coordinates, evaluator)) ||
                       MoveTo(last, derivative, coordinates, evaluator);
  if (!is_near) *coordinates = problem->StartCoordinates();
  RunFullStage(options, is_near, last_iteration + 1, problem, coordinates, evaluator, recorder, summary);
}

bool IsAllFrozen(const FitProblem& problem) {
  return std::all_of(problem.blocks().begin(), problem.blocks().end(),
                     [](const ParameterBlock& block) { return block.frozen; });
}

bool StartsLoosely(const FitOptions& options, const FitProblem& problem) {
  return options.precision != FitPrecision::kFull && options.jacobian != JacobianMethod::kNumeric &&
         !IsAllFrozen(problem);
}

bool IsAdaptive(const FitOptions& options, const FitProblem& problem) {
  return options.precision == FitPrecision::kAdaptive && StartsLoosely(options, problem);
}

// One run of the start stage, from the best point so far.
StartStageResult EstimateStart(const FitOptions& options, Precision precision, const FitProblem& problem,
                               Linearization known, Eigen::VectorXd* coordinates, FitEvaluator* evaluator,
                               FitRecorder* recorder) {
  StageGoal goal{precision};
  goal.first_iteration = recorder->last_iteration();
  goal.has_rows = false;
  recorder->StartStage(goal);
  return RunStartStage(options, precision, options.max_iterations - goal.first_iteration, problem, std::move(known),
                       recorder, coordinates, evaluator);
}

// The parameters with every start at its base, roughly; then all unknowns together, with loose rollouts and with full
// ones. The last linearization is from near the estimate.
std::optional<Linearization> RunWithUnknownStart(const FitOptions& options, FitProblem* problem,
                                                 Eigen::VectorXd* coordinates, FitEvaluator* evaluator,
                                                 FitRecorder* recorder, FitSummary* summary) {
  const bool is_adaptive = IsAdaptive(options, *problem);
  StageGoal rough = LooseGoal(recorder->next_iteration());
  if (!is_adaptive) rough.precision = Precision::kFull;
  if (!IsAllFrozen(*problem)) {
    RunLevenbergMarquardt(options, rough, problem, coordinates, evaluator, recorder, summary);
  }
  Linearization known;
  if (is_adaptive && !options.is_cancelled()) {
    known = EstimateStart(options, Precision::kLoose, *problem, {}, coordinates, evaluator, recorder).linearization;
    if (options.is_cancelled()) return std::nullopt;
    evaluator->SupersedeBest();
  }
  if (options.is_cancelled()) return std::nullopt;
  double cost = 0.0;
  evaluator->Evaluate(*coordinates, FitEvaluator::Derivative::kNone, &cost, nullptr);
  StartStageResult last =
      EstimateStart(options, Precision::kFull, *problem, std::move(known), coordinates, evaluator, recorder);
  summary->status = last.ok ? FitStatus::kConverged : FitStatus::kFailed;
  summary->message = last.ok ? "converged" : last.failure;
  if (!last.ok) return std::nullopt;
  if (last.predicted_decrease > kStalledDecrease) {
    summary->message = "stopped at a kink of the cost";
    if (recorder->last_iteration() >= options.max_iterations) {
      summary->status = FitStatus::kNotConverged;
      summary->message = "stopped at max_iterations";
    }
  }
  RemovePriors(*problem, *coordinates, &last.linearization);
  return std::move(last.linearization);
}

// `is_near`: a point near the solution is known already.
void RunOptimiser(const FitOptions& options, bool is_near, FitProblem* problem, Eigen::VectorXd* coordinates,
                  FitEvaluator* evaluator, FitRecorder* recorder, FitSummary* summary) {
  if (IsAllFrozen(*problem)) {
    summary->status = FitStatus::kConverged;
    summary->message = "every parameter is frozen";
  } else if (is_near || !StartsLoosely(options, *problem)) {
    RunFullStage(options, is_near, recorder->next_iteration(), problem, coordinates, evaluator, recorder, summary);
  } else if (options.precision == FitPrecision::kLoose) {
    StageGoal goal = LooseGoal(recorder->next_iteration());
    goal.function_tolerance = options.function_tolerance;  // no other stage makes up for a minimum that is missed
    RunLooseStage(options, goal, problem, coordinates, evaluator, recorder, summary);
  } else {
    RunWithIncreasingPrecision(options, problem, coordinates, evaluator, recorder, summary);
  }
}

struct Lead {
  LedStart start;
  bool is_near = false;  // nothing but the full stage is left
};

// Whether the last of the first frames moved no parameter far: then all frames are not expected to, either.
bool IsSettled(const FitOptions& options, const FitProblem& problem, const LedStart& start) {
  return IsAdaptive(options, problem) && problem.num_start_unknowns() == 0 && start.last_step.size() > 0 &&
         IsShort(problem, start.coordinates, start.last_step, kShortStep);
}

// From the start, whose cost is known, to where `horizon` leads, unless the cost is higher there. That of the start may
// be loose: where this decides, the points are about as good.
Lead FollowLead(const FitOptions& options, const FitProblem& problem, double start_cost, Precision precision,
                GrowingHorizon* horizon, Eigen::VectorXd* coordinates, FitEvaluator* evaluator, FitRecorder* recorder) {
  recorder->AddStart(precision);
  Lead lead{horizon->Lead(problem, *coordinates, &Fit)};
  Eigen::VectorXd led = *coordinates;
  led.head(problem.num_blocks()) = lead.start.coordinates;
  if (options.is_cancelled() || led == *coordinates) return lead;
  const bool is_settled = IsSettled(options, problem, lead.start);
  const auto derivative = is_settled ? NearDerivative(problem) : FitEvaluator::Derivative::kRows;
  double cost = 0.0;
  const bool works = evaluator->Evaluate(led, derivative, &cost, nullptr, is_settled ? Precision::kFull : precision);
  if (!works || !(cost < start_cost)) return lead;
  *coordinates = led;
  lead.is_near = is_settled && NextStepIsNegligible(problem, evaluator->model(), kShortStep, kLooseStepTolerance);
  return lead;
}

bool CanBeLed(const FitOptions& options, const FitProblem& problem) {
  return options.max_iterations > 0 && !IsAllFrozen(problem);
}

}  // namespace

FitSummary Fit(const FitOptions& options, FitProblem* problem) { return Fit(options, problem, nullptr); }

FitSummary Fit(const FitOptions& options, FitProblem* problem, GrowingHorizon* horizon) {
  FitSummary summary;
  Eigen::VectorXd coordinates = problem->StartCoordinates();
  FitEvaluator evaluator(problem, options.num_threads);
  FitRecorder recorder(options, *problem, evaluator);
  std::optional<Linearization> linearization;  // at the estimate, where it is known already
  Lead lead;
  problem->Restart();

  // Before the optimiser runs, so that a start that does not work is told with its reason. The optimiser finds it
  // cached, with the rows that it asks for, unless it is led away from there.
  double cost = 0.0;
  const bool is_led = horizon != nullptr && CanBeLed(options, *problem);
  const bool asks_for_rows = !IsAllFrozen(*problem) && !is_led;
  const auto derivative = asks_for_rows ? FitEvaluator::Derivative::kRows : FitEvaluator::Derivative::kNone;
  const Precision first_precision = StartsLoosely(options, *problem) ? Precision::kLoose : Precision::kFull;
  if (!evaluator.Evaluate(coordinates, derivative, &cost, nullptr, first_precision)) {
    summary.message = "the rollout at the starting values failed: " + evaluator.last_failure();
  } else {
    if (is_led) {
      lead = FollowLead(options, *problem, cost, first_precision, horizon, &coordinates, &evaluator, &recorder);
    }
    if (problem->num_start_unknowns() > 0) {
      linearization = RunWithUnknownStart(options, problem, &coordinates, &evaluator, &recorder, &summary);
    } else {
      RunOptimiser(options, lead.is_near, problem, &coordinates, &evaluator, &recorder, &summary);
    }
  }
  if (options.is_cancelled()) {
    summary.status = FitStatus::kInterrupted;
    summary.message = kInterruptedMessage;
  }
  // A loose point is better than none only where somebody has stopped the fit there.
  const bool has_estimate = evaluator.best().is_valid() && (!evaluator.best_is_superseded() || options.is_cancelled());
  if (has_estimate) FillEstimate(*problem, evaluator, &summary);
  problem->CheckJournals();
  recorder.AddLast();
  summary.iterations = recorder.iterations();
  summary.statistics = evaluator.statistics();
  summary.statistics += lead.start.statistics;
  summary.lead = lead.start.statistics;
  summary.total_seconds = recorder.seconds();
  summary.solver_seconds = std::max(0.0, summary.total_seconds - evaluator.seconds() - lead.start.evaluation_seconds);
  summary.linearization = std::move(linearization);
  if (options.estimate_uncertainty && summary.has_estimate()) {
    AddUncertainty(options, *problem, &summary);
    ContinueFromLowerPoints(options, &Fit, problem, &summary);
  }
  return summary;
}

}  // namespace clothid
