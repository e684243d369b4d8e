// The whole whitened residual of a recording, all m rows, with its full Jacobian from the forward sweep.
//
// For checks (`ceres::GradientChecker`) and for the covariance at a solution. A fit uses costs/rollout_cost.h, whose
// rows do not grow with the recording.
#ifndef CLOTHID_COSTS_FULL_RESIDUAL_COST_H_
#define CLOTHID_COSTS_FULL_RESIDUAL_COST_H_

#include <ceres/cost_function.h>

#include <memory>
#include <string>
#include <vector>

#include "costs/prediction/parameter_block.h"
#include "datasets/motion/recorded_motion.h"

namespace clothid {

class FullResidualCost : public ceres::CostFunction {
 public:
  // Throws `Error` where `RecordingModel` does.
  FullResidualCost(const RecordedMotion& motion, std::vector<ParameterBlock> blocks);
  ~FullResidualCost() override;

  // Residuals (predicted - measured)/sigma [m] and, per block, their derivative with respect to its coordinate [m x 1].
  // False where the rollout failed; see last_failure(). Nothing is cached. One thread at a time.
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

  const std::string& last_failure() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace clothid

#endif  // CLOTHID_COSTS_FULL_RESIDUAL_COST_H_
