// What the time step does to an estimate, from one more rollout of every recording, and a forward sweep along with it:
// no fit is repeated.
//
// At the estimate z of a fit at the step h, with predictions x_h and the whitened Jacobian J, weighted by the loss,
//   D = x_{h/2}(z) - x_h(z), whitened,   g = J^T D,
// a fit at half the step would end at z - H^-1 g, as far as its cost is quadratic. Of the parameters alone, all else
// following them by F (`MarginalModel`), that is
//   q_{h/2} = q - H_q^-1 (g_q + F^T g_rest).
// Where contacts and folds make a rough cost, J at the step h says little of what half the step does: the truth of
// `drape` at h/32 and noise of 1 mm, fitted at 2.5 ms, is off by 6 %, and moves by 1.7 % at half the step, of which J
// tells .03 to .3 %. So where parameters are the only unknowns, and few, the step of Gauss and Newton at h/2,
//   q_{h/2} = q - H_{h/2}^-1 J_{h/2}^T r_{h/2}(q)
// (2 to 3 % there) is taken as well, and the larger of both errors counts.
// `ErrorOfStep` (identify/uncertainty/discretization_error.h) makes an error of what that moves. Where it exceeds the
// noise of a parameter, a rollout at twice the step tells the order at which it falls. Where parameters are the only
// unknowns, J is that of the intervals; else it takes a reverse sweep for each of the two rollouts.
//
// On `drape`, recorded with steps of 0.3 ms and fitted with steps of 10, 5 and 2.5 ms, mu and k_stretch are off by 0.7
// to 1.7 times the error so told. The sign of what moves is not to be relied on: it is an error bar, no correction.
#ifndef CLOTHID_IDENTIFY_CHECKS_STEP_ERROR_H_
#define CLOTHID_IDENTIFY_CHECKS_STEP_ERROR_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "datasets/motion/recorded_motion.h"
#include "identify/base/options.h"
#include "identify/estimate/fit_summary.h"
#include "identify/problem/problem.h"
#include "identify/problem/step_prediction.h"

namespace clothid {

struct StepErrorEstimate {
  std::vector<double> errors;  // [p] of the values, as ParameterUncertainty::step_error; empty: not known
  std::string failure;         // one line: why not, where a rollout or a sweep failed

  bool is_known() const { return !errors.empty(); }
};

// Finds it and adds it to the intervals of `summary` by `AddEstimatedStepErrors`, and the work to its counts. `motions`
// are those of `problem`, which is that of `summary`. Nothing is known where the fit has no uncertainty or no parameter
// a standard deviation, and where options.cancel is true. `at_half`: what `PredictAtStep` gives of each recording at
// half the step, where it is at hand; it is counted where it was made.
StepErrorEstimate AddStepError(const std::vector<RecordedMotion>& motions, const FitOptions& options,
                               const FitProblem& problem, FitSummary* summary,
                               std::vector<StepPrediction> at_half = {});

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_CHECKS_STEP_ERROR_H_
