#include "identify/estimate/fit_uncertainty.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "identify/estimate/estimate.h"
#include "identify/estimate/unknowns_estimate.h"
#include "identify/problem/evaluator.h"
#include "identify/uncertainty/marginal.h"
#include "identify/uncertainty/priors.h"

namespace clothid {
namespace {

// The parameters alone at the estimate: all else eliminated, how it follows, and what would be known with the starts.
struct EstimateLinearization {
  Linearization parameters, known_start;
  Eigen::MatrixXd follow;  // [(n + f) x p]
};

// Where recordings correct the rollouts, no unknown start is fitted.
bool HasStarts(const FitProblem& problem) {
  return problem.num_start_unknowns() > 0 && !problem.assimilation().is_on();
}

// Over all unknowns, at or near the estimate.
bool LinearizeAll(const FitProblem& problem, FitEvaluator* evaluator, FitSummary* summary, BasisLinearization* all) {
  std::optional<BasisLinearization> known = std::exchange(summary->linearization, std::nullopt);
  all->basis = MakeBasis(problem, HasStarts(problem), problem.num_field_unknowns() > 0 ? kPosteriorModes : 0);
  if (known && known->basis.combinations.cols() == all->basis.combinations.cols()) {
    all->linearization = std::move(known->linearization);
    return true;
  }
  return evaluator->Linearize(summary->coordinates, all->basis.combinations, &all->linearization);
}

// H of all unknowns says how the others follow the parameters. Along with them, the parameters get derivatives of their
// own at the estimate: what H misses there counts in second order only, since the others follow so as to undo the most.
bool LinearizeEstimate(const FitProblem& problem, FitEvaluator* evaluator, FitSummary* summary,
                       EstimateLinearization* estimate) {
  BasisLinearization all;
  if (!LinearizeAll(problem, evaluator, summary, &all)) return false;
  const int p = problem.num_blocks();
  if (!HasStarts(problem) && problem.num_field_unknowns() == 0) {
    estimate->parameters = std::move(all.linearization);
    estimate->follow = Eigen::MatrixXd::Zero(problem.num_unknowns(), p);
    return true;
  }
  DescribeUnknowns(problem, all, summary);
  AddFieldRows(problem, all.basis.combinations, p, &all.linearization.jacobian);
  if (HasStarts(problem)) {
    estimate->known_start = Marginalize(KnownStart(all, problem), p).parameters;
    estimate->known_start.gradient = -PriorGradient(problem.blocks(), summary->coordinates);
  }
  estimate->follow = all.basis.combinations * Marginalize(std::move(all.linearization), p).follow;
  return LinearizeAlong(problem, summary->coordinates, estimate->follow, evaluator, &estimate->parameters);
}

// Of q, of an interval that noise cannot leave: rollouts that corrections drive may amplify without bound.
constexpr double kIncredible = 1e-6;

// Whether the cost is what the covariance takes it for, near the estimate and farther away.
void CheckCost(const FitProblem& problem, const EstimateLinearization& estimate, FitEvaluator* evaluator,
               FitSummary* summary) {
  const Uncertainty& uncertainty = *summary->uncertainty;
  summary->interval_check =
      CheckInterval(problem.blocks(), summary->coordinates, summary->cost, uncertainty, estimate.follow, evaluator);
  summary->bound_checks = CheckBounds(problem.blocks(), summary->coordinates, summary->cost, uncertainty,
                                      estimate.parameters.jacobian, estimate.follow, evaluator);
  const bool is_explained = !problem.has_model_error() && !uncertainty.is_widened &&
                            !(estimate.parameters.sigma_is_known && uncertainty.residual_scale >= kExplainedScale);
  const auto is_incredible = [&](const ParameterUncertainty& own) { return own.half_width95 < kIncredible; };
  const bool has_incredible = problem.assimilation().is_on() &&
                              std::any_of(uncertainty.parameters.begin(), uncertainty.parameters.end(), is_incredible);
  if (is_explained && !has_incredible) return;
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
    // How the model errs is told in multiples of the sigma that was guessed: it stands.
    estimate.parameters.sigma_is_known |= problem.has_model_error();
    estimate.known_start.sigma_is_known |= problem.has_model_error();
    estimate.parameters.autocorrelation = WeightedAutocorrelation(options.loss, problem, *summary);
    const Eigen::VectorXd blocks = summary->coordinates.head(problem.num_blocks());
    summary->uncertainty = EstimateUncertainty(problem.blocks(), blocks, estimate.parameters);
    if (HasStarts(problem)) {
      const Uncertainty known = EstimateUncertainty(problem.blocks(), blocks, estimate.known_start);
      for (int i = 0; i < problem.num_blocks(); ++i) {
        summary->uncertainty->parameters[i].known_start_std = known.parameters[i].std;
      }
    }
    const Eigen::MatrixXd& jacobian = estimate.parameters.jacobian;
    summary->marginal = {estimate.follow, jacobian.transpose() * jacobian + PriorHessian(problem.blocks())};
    problem.KeepOnly(summary->coordinates);
    if (options.check_interval) CheckCost(problem, estimate, &evaluator, summary);
  }
  summary->statistics += evaluator.statistics();
  summary->total_seconds += evaluator.seconds();
}

}  // namespace clothid
