// What recordings are predicted to be at another time step, everything else as it is.
#ifndef CLOTHID_IDENTIFY_PROBLEM_STEP_PREDICTION_H_
#define CLOTHID_IDENTIFY_PROBLEM_STEP_PREDICTION_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "costs/rollout_cost.h"
#include "datasets/motion/recorded_motion.h"
#include "identify/base/options.h"
#include "identify/problem/problem.h"

namespace clothid {

class FitEvaluator;

// What is predicted of one recording at another step.
struct StepPrediction {
  Eigen::MatrixXd points, forces;  // as of `RolloutCost::Predict`
  std::string failure;             // one line; empty: it worked
  CostStatistics statistics;
};

// `factor` times the step of `motion`, which is `recording` of the problem, at its coordinates [p + n + f]; with the
// corrections of the problem.
StepPrediction PredictAtStep(double factor, const RecordedMotion& motion, const FitOptions& options,
                             const FitProblem& problem, int recording, const Eigen::VectorXd& coordinates);

// The same of all recordings of the problem, side by side.
std::vector<StepPrediction> PredictAllAtStep(double factor, const std::vector<RecordedMotion>& motions,
                                             const FitOptions& options, const FitProblem& problem,
                                             const Eigen::VectorXd& coordinates);

// J^T D [p + n + f] of what changes from the predictions of `evaluator` at `coordinates` to `predictions`; the work of
// these is added to `statistics`. False where one of them has failed, or the sweep does: `failure` says why.
bool PullBackStep(const Eigen::VectorXd& coordinates, std::vector<StepPrediction> predictions, FitEvaluator* evaluator,
                  CostStatistics* statistics, Eigen::VectorXd* change, std::string* failure);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_PROBLEM_STEP_PREDICTION_H_
