// A fit that goes on from a lower point.
//
// The check of an interval evaluates the cost away from the estimate (identify/fit/interval_check.h). On a rough cost,
// where a fit may end in a dent, it may meet a point of lower cost there. That point is no answer, but a start for one.
#ifndef CLOTHID_IDENTIFY_FIT_CONTINUED_FIT_H_
#define CLOTHID_IDENTIFY_FIT_CONTINUED_FIT_H_

#include "identify/base/options.h"
#include "identify/fit/fit_summary.h"
#include "identify/problem/problem.h"

namespace clothid {

// `Fit` of identify/fit/fit.h, which calls this.
using FitFunction = FitSummary (*)(const FitOptions& options, FitProblem* problem);

// While the check of the interval of a converged fit has met a lower point: fits again from there with full precision,
// at most options.max_continuations times and with what is left of options.max_iterations. `summary` becomes that of
// the last fit, with the start of the first and the iterations and the work of all; every one has a lower cost than the
// one before. A fit from a lower point that gives no estimate leaves `summary` as it was but for the work. Leaves the
// start of the problem as it was.
void ContinueFromLowerPoints(const FitOptions& options, FitFunction fit, FitProblem* problem, FitSummary* summary);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_FIT_CONTINUED_FIT_H_
