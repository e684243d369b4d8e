// Does the estimate depend on the time step?
//
// An integrator dissipates energy at a rate that grows with the time step, and a fit hides that in its parameters. The
// fit is repeated at half the step, from the estimate: what moves is an error of discretisation. How large that is at
// the step of the fit says identify/checks/discretization_check.h.
#ifndef CLOTHID_IDENTIFY_CHECKS_STEP_CHECK_H_
#define CLOTHID_IDENTIFY_CHECKS_STEP_CHECK_H_

#include <vector>

#include "identify/checks/repeated_fit.h"

namespace clothid {

using StepCheck = RepeatedFit;

// The fit at half the step. `problem` is that of `summary`, which must have an estimate. Throws `Error` where
// `FitProblem` does.
StepCheck CheckStep(const std::vector<RecordedMotion>& motions, const FitOptions& options, const FitProblem& problem,
                    const FitSummary& summary);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_CHECKS_STEP_CHECK_H_
