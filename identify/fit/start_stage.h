// The stage of a fit that estimates unknown starts together with the parameters: Gauss-Newton with many unknowns.
//
// A start has a few hundred unknowns (costs/start/unknown_start.h). A forward sweep with a column for each gives the
// Gauss-Newton matrix H = J^T J of all of them, at the price of 15 to 25 rollouts; a reverse sweep gives the gradient g
// at the price of one. H changes little near the solution, so it is kept while the point moves and g is always new:
// Ceres gets the rows
//   r = (0, .., 0, sqrt(2 L)),   J = [C^T; g^T/sqrt(2 L)],   C C^T = H' - g' g'^T/(2 L')
// (primes: where H was made), of which J^T r = g and J^T J = H with the part of r made new. H is made anew where steps
// no longer do what it says.
#ifndef CLOTHID_IDENTIFY_FIT_START_STAGE_H_
#define CLOTHID_IDENTIFY_FIT_START_STAGE_H_

#include <ceres/iteration_callback.h>

#include <Eigen/Core>
#include <limits>
#include <string>

#include "identify/base/options.h"
#include "identify/fit/evaluator.h"
#include "identify/fit/problem.h"
#include "identify/uncertainty/uncertainty.h"

namespace clothid {

struct StartStageResult {
  bool ok = false;      // false: a derivative failed
  std::string failure;  // why
  // At the last point: what the next step would lower the cost by, in s^2 (identify/uncertainty/uncertainty.h), by
  // moving the parameters, the starts eliminated.
  double predicted_decrease = std::numeric_limits<double>::infinity();
  // H from the last place where it was made, of the recordings; gradient and cost at the last point, with the priors of
  // parameters.
  Linearization linearization;
};

// From `coordinates` [p + n], which it moves to the best point. `known`: H from near by, or nothing. `callback` is told
// of the iterations of Ceres, of which there are `max_iterations` at most.
StartStageResult RunStartStage(const FitOptions& options, Precision precision, int max_iterations,
                               const FitProblem& problem, Linearization known, ceres::IterationCallback* callback,
                               Eigen::VectorXd* coordinates, FitEvaluator* evaluator);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_FIT_START_STAGE_H_
