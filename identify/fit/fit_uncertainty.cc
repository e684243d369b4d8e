// How sure a fit is of its estimate: the second function of identify/fit/fit.h.
#include <optional>
#include <utility>

#include "identify/fit/estimate.h"
#include "identify/fit/evaluator.h"
#include "identify/fit/fit.h"
#include "identify/fit/start_estimate.h"
#include "identify/uncertainty/marginal.h"
#include "identify/uncertainty/priors.h"

namespace clothid {
namespace {

// The parameters alone at the estimate: unknown starts eliminated, how they follow, and what would be known with them.
struct EstimateLinearization {
  Linearization parameters, known_start;
  Eigen::MatrixXd follow;  // [n x p]
};

// H of all unknowns says how starts follow the parameters. Along with them, the parameters get derivatives of their own
// at the estimate: what H misses there counts in second order only, since the starts follow so as to undo the most.
bool LinearizeEstimate(const FitProblem& problem, FitEvaluator* evaluator, FitSummary* summary,
                       EstimateLinearization* estimate) {
  std::optional<Linearization> all = std::exchange(summary->linearization, std::nullopt);
  if (!all && !evaluator->Linearize(summary->coordinates, &all.emplace())) return false;
  if (problem.num_start_unknowns() == 0) {
    estimate->parameters = std::move(*all);
    estimate->follow = Eigen::MatrixXd::Zero(0, problem.num_blocks());
    return true;
  }
  estimate->known_start = KnownStart(*all, problem.num_blocks());
  estimate->known_start.gradient = -PriorGradient(problem.blocks(), summary->coordinates);
  Linearization with_priors = *all;
  with_priors.jacobian = WithPriorRows(problem.blocks(), all->jacobian, /*scale=*/1.0);
  FillStarts(problem, with_priors, summary);
  estimate->follow = Marginalize(std::move(*all), problem.num_blocks()).follow;
  return evaluator->LinearizeAlong(summary->coordinates, estimate->follow, &estimate->parameters);
}

// Whether the cost is what the covariance takes it for, near the estimate and farther away.
void CheckCost(const FitProblem& problem, const EstimateLinearization& estimate, FitEvaluator* evaluator,
               FitSummary* summary) {
  const Uncertainty& uncertainty = *summary->uncertainty;
  summary->interval_check =
      CheckInterval(problem.blocks(), summary->coordinates, summary->cost, uncertainty, estimate.follow, evaluator);
  const bool is_explained =
      estimate.parameters.sigma_is_known ? uncertainty.residual_scale < kExplainedScale : !uncertainty.is_widened;
  if (is_explained) return;
  if (summary->interval_check) {
    LookBeyond(problem, summary->coordinates, summary->cost, uncertainty, evaluator, &*summary->interval_check);
  }
  summary->dents = CheckForDents(problem.blocks(), summary->coordinates, summary->cost, uncertainty, evaluator);
}

}  // namespace

void AddUncertainty(const FitOptions& options, const FitProblem& problem, FitSummary* summary) {
  if (options.is_cancelled()) return;
  FitEvaluator evaluator(&problem, options.num_threads, EvaluationPurpose::kInterval);
  EstimateLinearization estimate;
  if (LinearizeEstimate(problem, &evaluator, summary, &estimate)) {
    estimate.parameters.autocorrelation = WeightedAutocorrelation(options.loss, problem, *summary);
    const Eigen::VectorXd blocks = summary->coordinates.head(problem.num_blocks());
    summary->uncertainty = EstimateUncertainty(problem.blocks(), blocks, estimate.parameters);
    if (problem.num_start_unknowns() > 0) {
      const Uncertainty known = EstimateUncertainty(problem.blocks(), blocks, estimate.known_start);
      for (int i = 0; i < problem.num_blocks(); ++i) {
        summary->uncertainty->parameters[i].known_start_std = known.parameters[i].std;
      }
    }
    if (options.check_interval) CheckCost(problem, estimate, &evaluator, summary);
  }
  summary->statistics += evaluator.statistics();
  summary->total_seconds += evaluator.seconds();
}

}  // namespace clothid
