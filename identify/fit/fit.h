// The fit: from a problem to estimates.
#ifndef CLOTHID_IDENTIFY_FIT_FIT_H_
#define CLOTHID_IDENTIFY_FIT_FIT_H_

#include "identify/base/options.h"
#include "identify/fit/fit_summary.h"
#include "identify/problem/problem.h"

namespace clothid {

// From the starting values of the problem's unknowns, by the stages of its plan (identify/fit/plan.h). How the fit ends
// never throws: see the status; but it throws `Error` where FitOptions::journal_folder is set and a journal cannot be
// written or is of another fit. The estimate is the point of lowest cost of all that were evaluated with the precision
// and the weights of the end, and the start is one of them: loose costs are biased, so a start that loose stages have
// left for a higher cost is where the last stage goes on from. On the same problem it gives the same result on any
// number of threads.
//
// The parameters alone: Ceres' Levenberg-Marquardt with their bounds, with loose rollouts until the Gauss-Newton step
// changes no parameter by more than 5 %, and from where that step leads with full ones. Where first frames have led it
// so near, it runs with full ones alone. With few parameters, points near the solution get exact rows along with their
// rollout: the sweep that the intervals of the last one need. Forward differences need full precision throughout.
// With other unknowns: identify/fit/joint_stage.h.
//
// Where FitOptions::estimate_uncertainty asks for it, `FinishFit` follows.
FitSummary Fit(const FitOptions& options, FitProblem* problem);

// `motions` (may be null) are those of the problem: then the fit is led by their first frames where
// FitOptions::growing_horizon says so, unless the cost is higher where they lead, and where recordings correct rollouts
// it is known what the time step does to that. What it takes counts with the rest.
FitSummary Fit(const FitOptions& options, FitProblem* problem, const std::vector<RecordedMotion>* motions);

// What comes after a fit that has an estimate: how sure it is; a fit from where the check of its interval meets a point
// of lower cost; and where what is left is more than noise, fits whose frames count by that
// (identify/fit/continued_fit.h), and how sure these are.
void FinishFit(const FitOptions& options, FitProblem* problem, FitSummary* summary,
               const std::vector<RecordedMotion>* motions = nullptr);

// The last part of it, of a fit with an uncertainty.
void WeighFit(const FitOptions& options, FitProblem* problem, FitSummary* summary,
              const std::vector<RecordedMotion>* motions = nullptr);

// Fills `uncertainty` and `interval_check` of a fit that has an estimate, unless the derivative fails there or
// options.cancel is true, and adds the work to its counts.
void AddUncertainty(const FitOptions& options, const FitProblem& problem, FitSummary* summary);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_FIT_FIT_H_
