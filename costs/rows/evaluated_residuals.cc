#include "costs/rows/evaluated_residuals.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "costs/prediction/prediction_cost.h"

namespace clothid {

void SetCost(const RobustLoss& loss, const Observation& observation, RolloutEvaluation* evaluation) {
  PredictionCost cost = CostOfPrediction(loss, observation, evaluation->predicted, evaluation->forces);
  evaluation->cost = cost.value;
  // Rounding would make it imaginary.
  evaluation->loss_row =
      std::sqrt(std::max(0.0, 2.0 * cost.value - cost.weights.cwiseProduct(cost.residuals).squaredNorm()));
  evaluation->residuals = std::move(cost.residuals);
}

Eigen::VectorXd WeightedResiduals(const RobustLoss& loss, const Observation& observation,
                                  const RolloutEvaluation& evaluation, Eigen::VectorXd* weights) {
  LossWeights(loss, observation, 0, evaluation.residuals, weights);
  return weights->cwiseProduct(evaluation.residuals);
}

// Distances of clouds are not linear in the prediction.
Eigen::VectorXd ResidualChange(const Observation& observation, const RolloutEvaluation& from, const Eigen::MatrixXd& to,
                               const Eigen::MatrixXd& to_forces) {
  if (observation.has_clouds()) return observation.Residuals(to, to_forces) - from.residuals;
  return observation.Whiten(to - from.predicted, to_forces - from.forces);
}

}  // namespace clothid
