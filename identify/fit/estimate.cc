#include "identify/fit/estimate.h"

#include "datasets/observation/observation.h"
#include "identify/fit/unknowns_estimate.h"
#include "identify/uncertainty/priors.h"

namespace clothid {
namespace {

PredictionError Compare(const FitProblem& problem, const FitPoint& point) {
  PredictionError error;
  for (int r = 0; r < problem.num_recordings(); ++r) {
    error += problem.cost(r).model().observation().Compare(point.predicted[r], point.forces[r]);
  }
  return error;
}

}  // namespace

void FillEstimate(const FitProblem& problem, const FitEvaluator& evaluator, FitSummary* summary) {
  const FitPoint& best = evaluator.best();
  const Eigen::VectorXd values = problem.Values(best.coordinates);
  for (int i = 0; i < problem.num_blocks(); ++i) {
    const ParameterBlock& block = problem.blocks()[i];
    FittedParameter parameter;
    parameter.name = block.name;
    parameter.frozen = block.frozen;
    parameter.start = block.start;
    parameter.value = block.frozen ? block.start : values[i];
    parameter.at_bound = !block.frozen && block.IsAtBound(best.coordinates[i]);
    parameter.prior = block.prior;
    parameter.is_knot = IsKnot(problem.blocks(), i);
    parameter.scale = block.scale;
    parameter.measured = problem.MeasuredOf(i);
    summary->parameters.push_back(parameter);
  }
  summary->coordinates = best.coordinates;
  summary->cost = best.cost;
  summary->start_error = Compare(problem, evaluator.first());
  summary->error = Compare(problem, best);
  summary->start_predicted = evaluator.first().predicted;
  summary->predicted = best.predicted;
  summary->forces = best.forces;
  summary->counts = best.counts;
  summary->model_errors = problem.model_errors();
  FillFields(problem, summary);
}

double WeightedAutocorrelation(const RobustLoss& loss, const FitProblem& problem, const FitSummary& summary) {
  if (!loss.is_robust() && !problem.has_model_error()) return summary.error.autocorrelation();
  PredictionError error;
  for (int r = 0; r < problem.num_recordings(); ++r) {
    const Observation& observation = problem.cost(r).model().observation();
    const Eigen::VectorXd residuals = observation.Residuals(summary.predicted[r], summary.forces[r]);
    Eigen::VectorXd weights;
    LossWeights(loss, observation, 0, residuals, &weights);
    Eigen::MatrixXd predicted = summary.predicted[r];
    for (int row = 0; row < observation.first_force_row(); ++row) {
      const SeenCoordinate& seen = observation.coordinates()[row];
      if (seen.point >= observation.num_points()) continue;
      predicted(3 * seen.point + seen.axis, seen.frame) +=
          (weights[row] - 1.0) * residuals[row] * observation.sigma(seen.point);
    }
    error += observation.Compare(predicted, summary.forces[r]);
  }
  return error.autocorrelation();
}

}  // namespace clothid
