#include "identify/fit/start_estimate.h"

#include <algorithm>
#include <cmath>

#include "costs/start/unknown_start.h"
#include "identify/uncertainty/marginal.h"
#include "identify/uncertainty/priors.h"

namespace clothid {
namespace {

// Of the rows of a quantity  D s:  the root mean square of D s and of its standard deviations.
struct Spread {
  double size = 0.0, std = 0.0;
};

Spread SpreadOf(const Eigen::MatrixXd& directions, const Eigen::VectorXd& unknowns, const Eigen::MatrixXd& covariance) {
  const Eigen::Index num_rows = (directions.rowwise().squaredNorm().array() > 0.0).count();
  if (num_rows == 0) return {};
  const double variance = directions.cwiseProduct(directions * covariance).sum();
  return {std::sqrt((directions * unknowns).squaredNorm() / static_cast<double>(num_rows)),
          std::sqrt(std::max(variance, 0.0) / static_cast<double>(num_rows))};
}

StartEstimate EstimateOf(const UnknownStart& start, const Eigen::VectorXd& unknowns,
                         const Eigen::MatrixXd& covariance) {
  const SensitivityDirections& directions = start.directions();
  StartEstimate estimate;
  const Spread positions = SpreadOf(directions.initial_positions, unknowns, covariance);
  estimate.moved = positions.size;
  estimate.position_std = positions.std;
  if (directions.handle_offsets.cols() > 0) {
    const Spread handles = SpreadOf(directions.handle_offsets, unknowns, covariance);
    estimate.handles_moved = handles.size;
    estimate.handle_std = handles.std;
  }
  if (directions.initial_velocities.cols() > 0) {
    const Spread velocities = SpreadOf(directions.initial_velocities, unknowns, covariance);
    estimate.speed_change = velocities.size;
    estimate.velocity_std = velocities.std;
  }
  return estimate;
}

}  // namespace

void FillStarts(const FitProblem& problem, const Linearization& linearization, FitSummary* summary) {
  std::vector<int> free;
  for (int i = 0; i < problem.num_blocks(); ++i) {
    if (!problem.blocks()[i].frozen) free.push_back(i);
  }
  const double degrees = linearization.num_measurements - static_cast<double>(free.size());
  const double fitted = degrees > 0.0 ? linearization.squared_residual / degrees : 1.0;
  const Eigen::MatrixXd covariance = (linearization.sigma_is_known ? std::max(1.0, fitted) : fitted) *
                                     UnknownsCovariance(linearization, free, problem.num_blocks());
  summary->starts.clear();
  Eigen::Index first = 0;
  for (int r = 0; r < problem.num_recordings(); ++r) {
    const UnknownStart* const start = problem.cost(r).model().unknown_start();
    if (start == nullptr) continue;
    const Eigen::VectorXd unknowns = summary->coordinates.segment(problem.num_blocks() + first, start->size());
    summary->starts.push_back(
        EstimateOf(*start, unknowns, covariance.block(first, first, start->size(), start->size())));
    summary->starts.back().recording = r;
    first += start->size();
  }
}

void RemovePriors(const FitProblem& problem, const Eigen::VectorXd& coordinates, Linearization* linearization) {
  linearization->gradient.head(problem.num_blocks()) -= PriorGradient(problem.blocks(), coordinates);
  linearization->squared_residual -= 2.0 * PriorCost(problem.blocks(), coordinates);
}

Linearization KnownStart(const Linearization& linearization, int num_parameters) {
  Linearization known = linearization;
  known.jacobian = linearization.jacobian.leftCols(num_parameters);
  known.gradient = Eigen::VectorXd::Zero(num_parameters);
  known.frame_scores.clear();
  return known;
}

}  // namespace clothid
