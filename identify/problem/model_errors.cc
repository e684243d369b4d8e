#include "identify/problem/model_errors.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "identify/uncertainty/model_error_estimate.h"

namespace clothid {
namespace {

// Of the largest deviation of a curve: what the next round would change hardly moves an estimate.
constexpr double kSameDeviation = 0.1;

// What the loss lets every residual count for, rho' e over sigma: gross errors are none of the model.
Eigen::VectorXd InfluencesOf(const RobustLoss& loss, const Observation& observation, const Eigen::VectorXd& residuals) {
  if (!loss.is_robust()) return residuals;
  Eigen::VectorXd weights;
  LossWeights(loss, observation, 0, residuals, &weights);
  if (observation.error_weights().size() > 0) weights.array() /= observation.error_weights().array();
  return weights.cwiseAbs2().cwiseProduct(residuals);
}

std::vector<int> RowsOf(const Observation& observation, PredictedKind kind) {
  std::vector<int> rows;
  for (int row = 0; row < observation.num_residuals(); ++row) {
    if (observation.KindOf(row) == kind) rows.push_back(row);
  }
  return rows;
}

Eigen::MatrixXd Unseen(Eigen::Index rows, Eigen::Index frames) {
  return Eigen::MatrixXd::Constant(rows, frames, std::numeric_limits<double>::quiet_NaN());
}

// The rows of tracked points and of forces as `NumAlike` takes them.
Eigen::MatrixXd TrackedFrames(const Observation& observation, const Eigen::VectorXd& residuals) {
  Eigen::MatrixXd frames = Unseen(3 * observation.num_points(), observation.num_frames());
  for (const int row : RowsOf(observation, PredictedKind::kPoints)) {
    const SeenCoordinate& seen = observation.coordinates()[row];
    frames(3 * seen.point + seen.axis, seen.frame) = residuals[row];
  }
  return frames;
}

Eigen::MatrixXd ForceFrames(const Observation& observation, const Eigen::VectorXd& residuals) {
  const ForceObservation& forces = observation.forces();
  Eigen::MatrixXd frames = Unseen(3 * forces.num_groups(), forces.num_readings());
  for (int i = 0; i < forces.num_residuals(); ++i) {
    frames(forces.seen()[i].row, forces.seen()[i].reading) = residuals[observation.first_force_row() + i];
  }
  return frames;
}

// What is compared with the surface has no row of its own in the next frame: a row is of the points nearest to a node,
// their sum over the root of their number. `alike`: how many of them err alike.
Eigen::MatrixXd CloudFrames(const Observation& observation, const Eigen::MatrixXd& predicted,
                            const Eigen::VectorXd& residuals, double* alike) {
  Eigen::MatrixXd frames = Unseen(observation.num_nodes(), observation.num_frames());
  double sum_of_squares = 0.0, sum_of_nodes = 0.0, num_points = 0.0, num_nodes = 0.0;
  for (int frame = 0; frame < observation.num_frames(); ++frame) {
    Eigen::VectorXd sums = Eigen::VectorXd::Zero(observation.num_nodes()), counts = sums;
    int row = observation.first_cloud_row(frame);
    for (const SurfaceDistance& distance :
         observation.clouds().Linearize(frame, observation.Nodes(predicted).col(frame))) {
      Eigen::Index nearest = 0;
      distance.weights.head(distance.num_nodes).maxCoeff(&nearest);
      sums[distance.nodes[nearest]] += residuals[row];
      counts[distance.nodes[nearest]] += 1.0;
      sum_of_squares += std::pow(residuals[row++], 2);
    }
    for (Eigen::Index node = 0; node < counts.size(); ++node) {
      if (!(counts[node] > 0.0)) continue;
      frames(node, frame) = sums[node] / std::sqrt(counts[node]);
      sum_of_nodes += std::pow(frames(node, frame), 2);
      num_points += counts[node];
      num_nodes += 1.0;
    }
  }
  *alike = std::max(1.0, (sum_of_nodes / num_nodes - 1.0) / std::max(sum_of_squares / num_points - 1.0, 1e-3));
  return frames;
}

// The fit before had frames that all count the same, or weights that keep it from taking over what the model errs by.
double NumAlikeOf(const Observation& observation, const Eigen::MatrixXd& predicted, const Eigen::VectorXd& residuals,
                  PredictedKind kind) {
  const bool is_absorbed = observation.model_error().is_zero();
  double within = 1.0;
  switch (kind) {
    case PredictedKind::kPoints:
      return NumAlike(TrackedFrames(observation, residuals), is_absorbed);
    case PredictedKind::kForces:
      return NumAlike(ForceFrames(observation, residuals), is_absorbed);
    case PredictedKind::kClouds:
      break;
  }
  const Eigen::MatrixXd frames = CloudFrames(observation, predicted, residuals, &within);
  return within * NumAlike(frames, is_absorbed);
}

ErrorCurve CurveOf(const Observation& observation, const Eigen::VectorXd& residuals, PredictedKind kind, double start,
                   double degrees_of_freedom) {
  const Eigen::VectorXd times = observation.RowTimes();
  ErrorRows own;
  for (int row = 0; row < observation.num_residuals(); ++row) {
    if (observation.KindOf(row) != kind) continue;
    own.Add(times[row], observation.SigmaOf(row), residuals[row] * residuals[row]);
  }
  return EstimateErrorCurve(own, start, degrees_of_freedom);
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

std::vector<ModelError> EstimateModelErrors(const RobustLoss& loss, const FitProblem& problem,
                                            const std::vector<Eigen::MatrixXd>& predicted,
                                            const std::vector<Eigen::MatrixXd>& forces) {
  std::vector<ModelError> errors = NoModelErrors(problem);
  for (int r = 0; r < problem.num_recordings(); ++r) {
    const RecordingModel& model = problem.cost(r).model();
    const Observation& observation = model.observation();
    const Eigen::VectorXd residuals = InfluencesOf(loss, observation, observation.Residuals(predicted[r], forces[r]));
    const double free = 1.0 - std::min(1.0, model.num_blocks() / static_cast<double>(observation.num_residuals()));
    for (const PredictedKind kind : {PredictedKind::kPoints, PredictedKind::kClouds, PredictedKind::kForces}) {
      ErrorCurve& curve = errors[r].CurveOf(kind);
      curve = CurveOf(observation, residuals, kind, model.scene().start_time, free);
      if (curve.is_zero()) continue;
      curve.alike = NumAlikeOf(observation, predicted[r], residuals, kind);
      if (curve.alike == 1.0) curve = ErrorCurve();
    }
  }
  return errors;
}

bool IsZero(const std::vector<ModelError>& errors) {
  return std::all_of(errors.begin(), errors.end(), [](const ModelError& error) { return error.is_zero(); });
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
