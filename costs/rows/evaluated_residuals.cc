#include "costs/rows/evaluated_residuals.h"

#include <algorithm>
#include <cmath>

namespace clothid {

double LossRow(double cost, double weighted_squared_norm) {
  return std::sqrt(std::max(0.0, 2.0 * cost - weighted_squared_norm));
}

void SetCost(const RobustLoss& loss, const Observation& observation, RolloutEvaluation* evaluation) {
  evaluation->residuals = observation.Residuals(evaluation->predicted);
  const Eigen::VectorXd& residuals = evaluation->residuals;
  Eigen::VectorXd weights;
  evaluation->cost = LossWeights(loss, observation, 0, residuals, &weights);
  evaluation->loss_row = LossRow(evaluation->cost, residuals.cwiseProduct(weights).squaredNorm());
}

Eigen::VectorXd WeightedResiduals(const RobustLoss& loss, const Observation& observation,
                                  const RolloutEvaluation& evaluation, Eigen::VectorXd* weights) {
  LossWeights(loss, observation, 0, evaluation.residuals, weights);
  return weights->cwiseProduct(evaluation.residuals);
}

// Distances of clouds are not linear in the prediction.
Eigen::VectorXd ResidualChange(const Observation& observation, const RolloutEvaluation& from,
                               const Eigen::MatrixXd& to) {
  if (observation.has_clouds()) return observation.Residuals(to) - from.residuals;
  return observation.Whiten(to - from.predicted);
}

}  // namespace clothid
