// The stage of a fit that moves everything that is unknown together: Gauss-Newton with many unknowns.
//
// Its matrix is made over a basis (identify/problem/unknown_basis.h): all unknowns while they are few, else the
// parameters, the starts and the smoothest modes of the fields, and what a step does outside of that is one more
// direction (identify/fit/krylov_step.h). It is kept while the point moves, and made anew where steps no longer do what
// it says (`LaggedRows`). The weights of what is believed to be smooth are chosen anew with every matrix
// (identify/uncertainty/smoothness.h).
#ifndef CLOTHID_IDENTIFY_FIT_JOINT_STAGE_H_
#define CLOTHID_IDENTIFY_FIT_JOINT_STAGE_H_

#include <ceres/iteration_callback.h>

#include <Eigen/Core>
#include <limits>
#include <string>

#include "identify/base/options.h"
#include "identify/problem/evaluator.h"
#include "identify/problem/problem.h"
#include "identify/problem/unknown_basis.h"

namespace clothid {

struct JointStageResult {
  bool ok = false;       // false: a derivative failed
  std::string failure;   // why
  bool is_over = false;  // it ended where it was to, or nothing was left to gain; false: iterations ran out
  // At the last point: what the next step would lower the cost by, in s^2 (identify/uncertainty/uncertainty.h), by
  // moving the parameters, all else eliminated.
  double predicted_decrease = std::numeric_limits<double>::infinity();
  // The Jacobian from the last place where it was made; gradient and |e|^2 at the last point.
  BasisLinearization known;
};

// From `coordinates` [p + n + f], which it moves to the best point. `known`: a Jacobian from near by, or nothing; one
// of another basis is not used. `callback` is told of the iterations of Ceres, of which there are `max_iterations` at
// most. Sets the weights of `problem`.
JointStageResult RunJointStage(const FitOptions& options, const FitStage& stage, int max_iterations,
                               BasisLinearization known, ceres::IterationCallback* callback, FitProblem* problem,
                               Eigen::VectorXd* coordinates, FitEvaluator* evaluator);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_FIT_JOINT_STAGE_H_
