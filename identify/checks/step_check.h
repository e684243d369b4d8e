// Does the estimate depend on the time step?
//
// Backward Euler dissipates energy at a rate that grows with the time step, and a fit hides that in its parameters. The
// fit is repeated at half the step, from the estimate: what moves is an error of discretisation, of first order in the
// step, so that the limit of small steps lies about as far again beyond.
#ifndef CLOTHID_IDENTIFY_CHECKS_STEP_CHECK_H_
#define CLOTHID_IDENTIFY_CHECKS_STEP_CHECK_H_

#include <Eigen/Core>
#include <vector>

#include "datasets/motion/recorded_motion.h"
#include "identify/base/options.h"
#include "identify/fit/fit.h"
#include "identify/fit/problem.h"

namespace clothid {

struct StepCheck {
  FitStatus status = FitStatus::kFailed;  // of the fit at half the step
  Eigen::VectorXd values;                 // [p] its estimates; empty: it has none
  Eigen::VectorXd changes;  // [p] against the estimates at the full step: of mu, or relative for the others
  double rmse = 0.0;        // m
  CostStatistics statistics;
};

// `problem` is that of `summary`, which must have an estimate. Throws `Error` where `FitProblem` does.
StepCheck CheckStep(const std::vector<RecordedMotion>& motions, const FitOptions& options, const FitProblem& problem,
                    const FitSummary& summary);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_CHECKS_STEP_CHECK_H_
