#include "identify/fit/continued_fit.h"

#include <cmath>
#include <utility>
#include <vector>

#include "identify/estimate/fit_uncertainty.h"
#include "identify/fit/descent.h"
#include "identify/problem/model_errors.h"
#include "sim/mesh/mesh.h"

namespace clothid {
namespace {

bool CanContinue(const FitOptions& options, const FitSummary& summary) {
  return summary.status == FitStatus::kConverged && summary.lower_point().size() > 0 &&
         summary.num_continuations < options.max_continuations && summary.num_iterations() < options.max_iterations;
}

// An iteration of the next fit, counted from the start of the first.
FitIteration After(const FitSummary& summary, FitIteration row) {
  row.iteration += summary.num_iterations() + 1;
  row.seconds += summary.total_seconds;
  row.rollouts += summary.statistics.rollouts;
  return row;
}

// A recorded motion below this share of the cloth is that of a cloth at rest.
constexpr double kRestShare = 0.02;

// Whether a fit is nearer to a recorded motion than a cloth at rest: elsewhere it is not the model that errs.
bool ExplainsMotion(const FitProblem& problem, const PredictionError& error) {
  const double motion = std::sqrt(3.0 * error.squared_motion / error.num_coordinates);
  return !(error.squared_error > error.squared_motion) ||
         motion < kRestShare * ClothSize(problem.cost(0).model().scene().mesh);
}

// Fits, each with the weights that the residuals of the one before it give.
constexpr int kMostErrorRounds = 5;

// From the estimate, with `errors`. False where it does not converge; the errors are those of before then.
bool FitWeighed(const FitOptions& options, const std::vector<ModelError>& errors, FitProblem* problem,
                FitSummary* summary) {
  const std::vector<ModelError> before = problem->model_errors();
  problem->SetModelErrors(errors);
  problem->SetStart(summary->coordinates);
  FitOptions next = OptionsOfNext(options, *problem, *summary);
  next.estimate_uncertainty = false;
  FitSummary found = Descend(next, problem);
  const bool has_converged = found.status == FitStatus::kConverged;
  if (!has_converged) problem->SetModelErrors(before);
  const int num_continuations = summary->num_continuations;
  AppendFit(std::move(found), has_converged, summary);
  summary->num_continuations = num_continuations;
  return has_converged;
}

}  // namespace

FitOptions OptionsOfNext(const FitOptions& options, const FitProblem& problem, const FitSummary& summary) {
  FitOptions next = options;
  next.assimilate = problem.assimilation_option();
  next.precision = FitPrecision::kFull;  // so that no point is left for one of higher cost
  next.max_continuations = 0;
  next.max_iterations = options.max_iterations - summary.num_iterations();
  if (options.on_iteration) {
    next.on_iteration = [&options, &summary](const FitIteration& row) { options.on_iteration(After(summary, row)); };
  }
  return next;
}

void AppendFit(FitSummary next, bool is_taken, FitSummary* summary) {
  std::vector<FitIteration> iterations = summary->iterations;
  for (const FitIteration& row : next.iterations) iterations.push_back(After(*summary, row));
  next.statistics += summary->statistics;
  next.lead = summary->lead;
  next.plan.insert(next.plan.begin(), summary->plan.begin(), summary->plan.end());
  next.total_seconds += summary->total_seconds;
  next.solver_seconds += summary->solver_seconds;
  if (is_taken) {
    for (std::size_t i = 0; i < next.parameters.size(); ++i) next.parameters[i].start = summary->parameters[i].start;
    next.iterations = std::move(iterations);
    if (IsSame(next.assimilation, summary->assimilation)) {  // else those of other rollouts
      next.start_error = summary->start_error;
      next.start_predicted = std::move(summary->start_predicted);
    }
    next.num_continuations = summary->num_continuations;
    if (next.memory_trials.empty()) next.memory_trials = std::move(summary->memory_trials);
    if (next.unweighed_values.size() == 0) next.unweighed_values = std::move(summary->unweighed_values);
    next.why_not_assimilated = summary->why_not_assimilated;
    *summary = std::move(next);
    return;
  }
  if (!next.memory_trials.empty()) summary->memory_trials = std::move(next.memory_trials);
  summary->statistics = next.statistics;
  summary->plan = std::move(next.plan);
  summary->total_seconds = next.total_seconds;
  summary->solver_seconds = next.solver_seconds;
  if (next.status != FitStatus::kInterrupted) return;
  summary->status = next.status;
  summary->message = next.message;
}

void WeighByModelError(const FitOptions& options, FitProblem* problem, FitSummary* summary) {
  if (!options.weighs_model_error || !problem->finds_model_error() || options.precision == FitPrecision::kLoose) return;
  if (!ExplainsMotion(*problem, summary->error)) return;
  const Eigen::VectorXd start = problem->StartCoordinates();
  problem->HoldWeights(true);
  for (int round = 0; round < kMostErrorRounds; ++round) {
    if (summary->status != FitStatus::kConverged || summary->num_iterations() >= options.max_iterations) break;
    const std::vector<ModelError> errors =
        EstimateModelErrors(options.loss, *problem, summary->predicted, summary->forces);
    if (IsSameError(problem->model_errors(), errors)) break;
    const Eigen::VectorXd before = summary->values();
    if (!FitWeighed(options, errors, problem, summary)) break;
    if (summary->unweighed_values.size() == 0) summary->unweighed_values = before;
  }
  problem->HoldWeights(false);
  problem->SetStart(start);
}

void ContinueFromLowerPoints(const FitOptions& options, FitProblem* problem, FitSummary* summary) {
  const Eigen::VectorXd start = problem->StartCoordinates();
  problem->HoldWeights(true);
  while (CanContinue(options, *summary)) {
    problem->SetStart(summary->lower_point());
    const FitOptions next = OptionsOfNext(options, *problem, *summary);
    FitSummary found = Descend(next, problem);
    if (next.estimate_uncertainty && found.has_estimate()) AddUncertainty(next, *problem, &found);
    const bool is_lower = found.has_estimate() && found.cost < summary->cost;
    AppendFit(std::move(found), is_lower, summary);
    ++summary->num_continuations;
    if (!is_lower) break;
  }
  problem->HoldWeights(false);
  problem->SetStart(start);
}

}  // namespace clothid
