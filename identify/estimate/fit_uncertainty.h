// How sure a fit is of its estimate. Not installed.
#ifndef CLOTHID_IDENTIFY_ESTIMATE_FIT_UNCERTAINTY_H_
#define CLOTHID_IDENTIFY_ESTIMATE_FIT_UNCERTAINTY_H_

#include "identify/base/options.h"
#include "identify/estimate/fit_summary.h"
#include "identify/problem/problem.h"

namespace clothid {

// Fills `uncertainty` and `interval_check` of a fit that has an estimate, unless the derivative fails there or
// options.cancel is true, and adds the work to its counts.
void AddUncertainty(const FitOptions& options, const FitProblem& problem, FitSummary* summary);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_ESTIMATE_FIT_UNCERTAINTY_H_
