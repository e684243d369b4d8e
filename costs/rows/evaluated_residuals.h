// The residuals of an evaluated point, as a robust loss weighs them.
#ifndef CLOTHID_COSTS_ROWS_EVALUATED_RESIDUALS_H_
#define CLOTHID_COSTS_ROWS_EVALUATED_RESIDUALS_H_

#include <Eigen/Core>

#include "costs/prediction/robust_loss.h"
#include "costs/rows/rollout_evaluation.h"
#include "datasets/observation/observation.h"

namespace clothid {

// Residuals, cost and loss row of `evaluation` from its prediction, whatever gave that.
void SetCost(const RobustLoss& loss, const Observation& observation, RolloutEvaluation* evaluation);

// w e [m] of an evaluation that has its residuals, and `weights` w [m].
Eigen::VectorXd WeightedResiduals(const RobustLoss& loss, const Observation& observation,
                                  const RolloutEvaluation& evaluation, Eigen::VectorXd* weights);

// The change of the residual [m] from an evaluated point to another prediction [R x T], with other forces [3G x F].
Eigen::VectorXd ResidualChange(const Observation& observation, const RolloutEvaluation& from, const Eigen::MatrixXd& to,
                               const Eigen::MatrixXd& to_forces);

}  // namespace clothid

#endif  // CLOTHID_COSTS_ROWS_EVALUATED_RESIDUALS_H_
