// The cost of a prediction:  L = 1/2 sum_p rho(|e_p|^2)  over the points p of all frames, e the whitened residual of
// datasets/observation/observation.h, rho the loss of costs/prediction/robust_loss.h; without a loss  L = 1/2 |e|^2.
#ifndef CLOTHID_COSTS_PREDICTION_PREDICTION_COST_H_
#define CLOTHID_COSTS_PREDICTION_PREDICTION_COST_H_

#include <Eigen/Core>

#include "costs/prediction/robust_loss.h"
#include "datasets/observation/observation.h"

namespace clothid {

struct PredictionCost {
  double value = 0.0;         // L
  Eigen::VectorXd residuals;  // [m] e
  Eigen::VectorXd weights;    // [m] w = sqrt(rho') of each row's point; 1 without a loss

  Eigen::VectorXd WeightedResiduals() const { return weights.cwiseProduct(residuals); }   // [m] w e
  Eigen::VectorXd Gradient() const { return weights.cwiseProduct(WeightedResiduals()); }  // [m] dL/de = w^2 e
};

// `predicted` [R x T] m and `forces` [3G x F] N, of `observation`.
PredictionCost CostOfPrediction(const RobustLoss& loss, const Observation& observation,
                                const Eigen::MatrixXd& predicted, const Eigen::MatrixXd& forces);

}  // namespace clothid

#endif  // CLOTHID_COSTS_PREDICTION_PREDICTION_COST_H_
