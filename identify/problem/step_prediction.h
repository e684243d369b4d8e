// What recordings are predicted to be at another time step, everything else as it is.
#ifndef CLOTHID_IDENTIFY_PROBLEM_STEP_PREDICTION_H_
#define CLOTHID_IDENTIFY_PROBLEM_STEP_PREDICTION_H_

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "costs/rollout_cost.h"
#include "datasets/motion/recorded_motion.h"
#include "identify/base/options.h"
#include "identify/problem/problem.h"

namespace clothid {

class FitEvaluator;
struct QuadraticModel;

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

// The Gauss-Newton model of the cost of `problem`, of parameters alone, at `factor` times the step. One forward sweep
// along with a rollout of every recording; the work is added to `statistics`. False where one fails: `failure` says
// why.
bool ModelAtStep(double factor, const std::vector<RecordedMotion>& motions, const FitOptions& options,
                 const FitProblem& problem, const Eigen::VectorXd& coordinates, CostStatistics* statistics,
                 QuadraticModel* model, std::vector<StepPrediction>* predictions, std::string* failure);

// Where half the step would move the blocks to from the point of the evaluator's model, less that point [p], as far as
// the cost is quadratic: the step of Gauss and Newton by that change alone. `statistics`: as above. Nothing where a
// rollout fails or the model is singular.
std::optional<Eigen::VectorXd> HalfStepMove(const std::vector<RecordedMotion>& motions, const FitOptions& options,
                                            const FitProblem& problem, FitEvaluator* evaluator,
                                            CostStatistics* statistics);

// An end of a fit [p + n + f], and what half the step would move it by [p].
struct MovedEnd {
  const Eigen::VectorXd& coordinates;
  const Eigen::VectorXd& move;
};
// Whether half the step moves `a` less than `b`, by the largest change of a block in resolutions, and both agree as far
// as such errors, at the first order with one standard deviation to spare, let anybody tell.
bool IsMovedLess(const FitProblem& problem, const MovedEnd& a, const MovedEnd& b);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_PROBLEM_STEP_PREDICTION_H_
