#include "identify/estimate/estimate.h"

#include "datasets/observation/observation.h"
#include "identify/estimate/unknowns_estimate.h"
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
    parameter.id = block.id;
    parameter.frozen = block.frozen;
    parameter.start = block.start;
    parameter.lower_bound = block.lower_bound;
    parameter.upper_bound = block.upper_bound;
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
  summary->assimilation = problem.assimilation();
  FillFields(problem, summary);
}

void AddFieldRows(const FitProblem& problem, const Eigen::MatrixXd& combinations, Eigen::Index first_column,
                  Eigen::MatrixXd* jacobian) {
  const Eigen::MatrixXd rows = problem.FieldRows(combinations);
  jacobian->conservativeResize(jacobian->rows() + rows.rows(), Eigen::NoChange);
  jacobian->bottomRows(rows.rows()).setZero();
  jacobian->bottomRows(rows.rows()).middleCols(first_column, rows.cols()) = rows;
}

bool LinearizeAlong(const FitProblem& problem, const Eigen::VectorXd& coordinates, const Eigen::MatrixXd& follow,
                    FitEvaluator* evaluator, Linearization* along) {
  if (!evaluator->Linearize(coordinates, follow, along)) return false;
  const Eigen::Index p = problem.num_blocks();
  along->jacobian = (along->jacobian.leftCols(p) + along->jacobian.rightCols(p)).eval();
  along->gradient = (along->gradient.head(p) + along->gradient.tail(p)).eval();
  along->gradient += follow.transpose() * problem.PriorGradient(coordinates).tail(problem.num_unknowns());
  for (Eigen::MatrixXd& scores : along->frame_scores) scores = (scores.topRows(p) + scores.bottomRows(p)).eval();
  AddFieldRows(problem, follow, 0, &along->jacobian);
  return true;
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
