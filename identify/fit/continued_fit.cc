#include "identify/fit/continued_fit.h"

#include <utility>

namespace clothid {
namespace {

bool CanContinue(const FitOptions& options, const FitSummary& summary) {
  return summary.status == FitStatus::kConverged && summary.interval_check &&
         summary.interval_check->better.size() > 0 && summary.num_continuations < options.max_continuations &&
         summary.num_iterations() < options.max_iterations;
}

// An iteration of the next fit, counted from the start of the first.
FitIteration After(const FitSummary& summary, FitIteration row) {
  row.iteration += summary.num_iterations() + 1;
  row.seconds += summary.total_seconds;
  row.rollouts += summary.statistics.rollouts;
  return row;
}

FitOptions OptionsOfNext(const FitOptions& options, const FitSummary& summary) {
  FitOptions next = options;
  next.precision = FitPrecision::kFull;  // so that no point is left for one of higher cost
  next.max_continuations = 0;
  next.max_iterations = options.max_iterations - summary.num_iterations();
  if (options.on_iteration) {
    next.on_iteration = [&options, &summary](const FitIteration& row) { options.on_iteration(After(summary, row)); };
  }
  return next;
}

// Puts `next` after `summary`.
void Append(FitSummary next, FitSummary* summary) {
  std::vector<FitIteration> iterations = summary->iterations;
  for (const FitIteration& row : next.iterations) iterations.push_back(After(*summary, row));
  next.statistics += summary->statistics;
  next.lead = summary->lead;
  next.plan.insert(next.plan.begin(), summary->plan.begin(), summary->plan.end());
  next.total_seconds += summary->total_seconds;
  next.solver_seconds += summary->solver_seconds;
  const bool is_lower = next.has_estimate() && next.cost < summary->cost;
  if (is_lower) {
    for (std::size_t i = 0; i < next.parameters.size(); ++i) next.parameters[i].start = summary->parameters[i].start;
    next.iterations = std::move(iterations);
    next.start_error = summary->start_error;
    next.start_predicted = std::move(summary->start_predicted);
    next.num_continuations = summary->num_continuations;
    *summary = std::move(next);
    return;
  }
  summary->statistics = next.statistics;
  summary->plan = std::move(next.plan);
  summary->total_seconds = next.total_seconds;
  summary->solver_seconds = next.solver_seconds;
  if (next.status != FitStatus::kInterrupted) return;
  summary->status = next.status;
  summary->message = next.message;
}

}  // namespace

void ContinueFromLowerPoints(const FitOptions& options, FitFunction fit, FitProblem* problem, FitSummary* summary) {
  const Eigen::VectorXd start = problem->StartCoordinates();
  problem->HoldWeights(true);
  while (CanContinue(options, *summary)) {
    problem->SetStart(summary->interval_check->better);
    const FitOptions next = OptionsOfNext(options, *summary);
    const double cost = summary->cost;
    Append(fit(next, problem), summary);
    ++summary->num_continuations;
    if (!(summary->cost < cost)) break;
  }
  problem->HoldWeights(false);
  problem->SetStart(start);
}

}  // namespace clothid
