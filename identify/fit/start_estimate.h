// What a fit says of unknown starts, from the linearization at its estimate.
#ifndef CLOTHID_IDENTIFY_FIT_START_ESTIMATE_H_
#define CLOTHID_IDENTIFY_FIT_START_ESTIMATE_H_

#include "identify/fit/fit_summary.h"
#include "identify/fit/problem.h"
#include "identify/uncertainty/uncertainty.h"

namespace clothid {

// Fills FitSummary::starts. `linearization` [r x (p + n)] at the summary's coordinates.
void FillStarts(const FitProblem& problem, const Linearization& linearization, FitSummary* summary);

// Takes the priors of parameters out of gradient and residuals of a linearization [r x (p + n)] at `coordinates`.
void RemovePriors(const FitProblem& problem, const Eigen::VectorXd& coordinates, Linearization* linearization);

// As if the starts were known to be what they are estimated to be, and this were the minimum of what was measured: the
// first p columns.
Linearization KnownStart(const Linearization& linearization, int num_parameters);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_FIT_START_ESTIMATE_H_
