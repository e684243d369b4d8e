// The fit: from a problem to estimates.
#ifndef CLOTHID_IDENTIFY_FIT_FIT_H_
#define CLOTHID_IDENTIFY_FIT_FIT_H_

#include "identify/base/options.h"
#include "identify/estimate/fit_summary.h"
#include "identify/problem/problem.h"

namespace clothid {

// From the starting values of the problem's unknowns, by the stages of its plan (identify/fit/plan.h, descent.h). How
// the fit ends never throws: see the status; but it throws `Error` where FitOptions::journal_folder is set and a
// journal cannot be written or is of another fit. The estimate is the point of lowest cost of all that were evaluated
// with the precision and the weights of the end, and the start is one of them: loose costs are biased, so a start that
// loose stages have left for a higher cost is where the last stage goes on from. On the same problem it gives the same
// result on any number of threads.
//
// Where FitOptions::estimate_uncertainty asks for it, `FinishFit` follows.
FitSummary Fit(const FitOptions& options, FitProblem* problem);

// `motions` (may be null) are those of the problem: then the fit is led by their first frames where
// FitOptions::growing_horizon says so, unless the cost is higher where they lead, and where recordings correct rollouts
// it is known what the time step does to that. What it takes counts with the rest.
FitSummary Fit(const FitOptions& options, FitProblem* problem, const std::vector<RecordedMotion>* motions);

// What comes after a fit that has an estimate, each step where it is needed: where it leaves more than noise, rollouts
// that the recordings correct (identify/problem/memory_trial.h); how sure it is; a fit from where the check of its
// interval meets a point of lower cost; and where what is left is still more than noise, fits whose frames count by
// that (identify/fit/continued_fit.h), and how sure these are.
void FinishFit(const FitOptions& options, FitProblem* problem, FitSummary* summary,
               const std::vector<RecordedMotion>* motions = nullptr);

// The last part of it, of a fit with an uncertainty.
void WeighFit(const FitOptions& options, FitProblem* problem, FitSummary* summary,
              const std::vector<RecordedMotion>* motions = nullptr);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_FIT_FIT_H_
