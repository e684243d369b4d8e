#include "identify/problem/model_errors.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "identify/uncertainty/model_error_estimate.h"

namespace clothid {
namespace {

// Of the largest deviation of a curve: what the next round would change hardly moves an estimate.
constexpr double kSameDeviation = 0.1;
constexpr double kHighestCorrelation = 0.97;  // no recording is long enough to tell more

// e^2 of all rows, as a loss weighs them: where the model is known to err, gross errors stand out less.
Eigen::VectorXd SquaresOf(const RobustLoss& loss, const Observation& observation, const Eigen::VectorXd& residuals) {
  Eigen::VectorXd weights;
  LossWeights(loss, observation, 0, residuals, &weights);
  const Eigen::VectorXd& shares = observation.error_weights();
  if (shares.size() > 0) weights.array() /= shares.array();
  return weights.cwiseProduct(residuals).cwiseAbs2();
}

ErrorRows RowsOf(const Observation& observation, const Eigen::VectorXd& squares, PredictedKind kind) {
  std::vector<int> rows;
  for (int row = 0; row < observation.num_residuals(); ++row) {
    if (observation.KindOf(row) == kind) rows.push_back(row);
  }
  ErrorRows own;
  own.times = observation.RowTimes()(rows);
  own.squares = squares(rows);
  own.sigmas.resize(own.times.size());
  for (std::size_t i = 0; i < rows.size(); ++i) own.sigmas[static_cast<Eigen::Index>(i)] = observation.SigmaOf(rows[i]);
  return own;
}

// How many rows err alike: those of one frame as one displacement, and frames as they are correlated. `autocorrelation`
// from frame to frame of residuals with noise in them, which has none.
double NumAlike(const ErrorRows& rows, double autocorrelation) {
  const auto num_rows = static_cast<double>(rows.times.size());
  const auto num_times = static_cast<double>(std::set<double>(rows.times.begin(), rows.times.end()).size());
  const double noise = std::min(1.0, num_rows / rows.squares.sum());
  const double correlation = std::clamp(autocorrelation / (1.0 - noise), 0.0, kHighestCorrelation);
  return std::max(1.0, num_rows / num_times / 3.0) * (1.0 + correlation) / (1.0 - correlation);
}

double AutocorrelationOf(const PredictionError& error, PredictedKind kind) {
  switch (kind) {
    case PredictedKind::kPoints:
      return error.successive_products / error.successive_squares;
    case PredictedKind::kClouds:
      return error.cloud.successive_products / error.cloud.successive_squares;
    case PredictedKind::kForces:
      break;
  }
  return error.force.autocorrelation();
}

bool IsSameCurve(const ErrorCurve& first, const ErrorCurve& second) {
  if (first.is_zero() || second.is_zero()) return first.is_zero() && second.is_zero();
  const Eigen::ArrayXd a = first.variances.cwiseSqrt(), b = second.variances.cwiseSqrt();
  return a.size() == b.size() && (a - b).abs().maxCoeff() <= kSameDeviation * b.maxCoeff();
}

}  // namespace

std::vector<ModelError> NoModelErrors(const FitProblem& problem) {
  return std::vector<ModelError>(static_cast<std::size_t>(problem.num_recordings()));
}

std::vector<ModelError> EstimateModelErrors(const RobustLoss& loss, const FitProblem& problem, const FitPoint& point) {
  std::vector<ModelError> errors = NoModelErrors(problem);
  for (int r = 0; r < problem.num_recordings(); ++r) {
    const RecordingModel& model = problem.cost(r).model();
    const Observation& observation = model.observation();
    const double num_residuals = observation.num_residuals();
    const double free = 1.0 - std::min(1.0, model.num_blocks() / num_residuals);
    const PredictionError error = observation.Compare(point.predicted[r], point.forces[r]);
    const Eigen::VectorXd squares =
        SquaresOf(loss, observation, observation.Residuals(point.predicted[r], point.forces[r]));
    for (const PredictedKind kind : {PredictedKind::kPoints, PredictedKind::kClouds, PredictedKind::kForces}) {
      const ErrorRows rows = RowsOf(observation, squares, kind);
      if (rows.times.size() == 0) continue;
      ErrorCurve& curve = errors[r].CurveOf(kind);
      curve = EstimateErrorCurve(rows, model.scene().start_time, free);
      if (!curve.is_zero()) curve.alike = NumAlike(rows, AutocorrelationOf(error, kind));
    }
  }
  return errors;
}

bool IsSameError(const std::vector<ModelError>& first, const std::vector<ModelError>& second) {
  for (std::size_t r = 0; r < first.size(); ++r) {
    for (std::size_t k = 0; k < first[r].curves.size(); ++k) {
      if (!IsSameCurve(first[r].curves[k], second[r].curves[k])) return false;
    }
  }
  return true;
}

}  // namespace clothid
