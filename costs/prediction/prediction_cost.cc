#include "costs/prediction/prediction_cost.h"

namespace clothid {

PredictionCost CostOfPrediction(const RobustLoss& loss, const Observation& observation,
                                const Eigen::MatrixXd& predicted, const Eigen::MatrixXd& forces) {
  PredictionCost cost;
  cost.residuals = observation.Residuals(predicted, forces);
  cost.value = LossWeights(loss, observation, 0, cost.residuals, &cost.weights);
  return cost;
}

}  // namespace clothid
