// What a fit says of starts and fields, from the linearization at its estimate.
#ifndef CLOTHID_IDENTIFY_ESTIMATE_UNKNOWNS_ESTIMATE_H_
#define CLOTHID_IDENTIFY_ESTIMATE_UNKNOWNS_ESTIMATE_H_

#include "identify/estimate/fit_summary.h"
#include "identify/problem/problem.h"
#include "identify/problem/unknown_basis.h"

namespace clothid {

// Half waves a side of the modes of fields over which standard deviations are told; of rougher ones there is what is
// believed.
inline constexpr int kPosteriorModes = 16;

// The values of the fields at the summary's coordinates, as FitSummary::fields, without standard deviations. Nothing
// where none are fitted.
void FillFields(const FitProblem& problem, FitSummary* summary);

// Fills FitSummary::starts, and the deviations of FitSummary::fields. `known`: over a basis with starts and
// kPosteriorModes, at the summary's coordinates.
void DescribeUnknowns(const FitProblem& problem, const BasisLinearization& known, FitSummary* summary);

// As if the starts were known to be what they are estimated to be, and this were the minimum of what was measured: the
// columns of the parameters and of fields.
Linearization KnownStart(const BasisLinearization& known, const FitProblem& problem);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_ESTIMATE_UNKNOWNS_ESTIMATE_H_
