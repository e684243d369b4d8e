// Fits that go on: from a lower point, and with other weights.
//
// The check of an interval evaluates the cost away from the estimate (identify/estimate/interval_check.h). On a rough
// cost, where a fit may end in a dent, it may meet a point of lower cost there. That point is no answer, but a start
// for one.
//
// What a fit leaves of the residuals tells how far the model errs, and frames that count by that
// (datasets/observation/model_error.h) give another fit, which leaves other residuals.
#ifndef CLOTHID_IDENTIFY_FIT_CONTINUED_FIT_H_
#define CLOTHID_IDENTIFY_FIT_CONTINUED_FIT_H_

#include "identify/base/options.h"
#include "identify/estimate/fit_summary.h"
#include "identify/problem/problem.h"

namespace clothid {

// Of a fit that goes on from `summary`, with full precision, so that no point is left for one of higher cost, and with
// what is left of the iterations, which are told as its.
FitOptions OptionsOfNext(const FitOptions& options, const FitProblem& problem, const FitSummary& summary);

// Puts `next` after `summary`, and in its place where it `is_taken`: the work and the plans of both count, and of one
// that is not taken nothing else does but that it was interrupted and the memories that it has tried.
void AppendFit(FitSummary next, bool is_taken, FitSummary* summary);

// While the check of the interval of a converged fit has met a lower point: fits again from there with full precision,
// at most options.max_continuations times and with what is left of options.max_iterations. `summary` becomes that of
// the last fit, with the start of the first and the iterations and the work of all; every one has a lower cost than the
// one before. A fit from a lower point that gives no estimate leaves `summary` as it was but for the work. Leaves the
// start of the problem as it was.
void ContinueFromLowerPoints(const FitOptions& options, FitProblem* problem, FitSummary* summary);

// Fits again from a converged estimate with the weights that its residuals give (identify/problem/model_errors.h),
// until these are steady; not at all where they are those of noise, or of a fit that is no
// nearer to the recorded motion than a cloth at rest. The weights stay in the problem. A fit that does
// not converge leaves `summary` and the weights as they were but for the work. What was said of the uncertainty before
// is void where the weights have changed. Leaves the start of the problem as it was.
void WeighByModelError(const FitOptions& options, FitProblem* problem, FitSummary* summary);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_FIT_CONTINUED_FIT_H_
