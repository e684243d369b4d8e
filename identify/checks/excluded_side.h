// Values that a recording excludes, of a parameter of which the derivative at the estimate tells nothing.
//
// Cloth that sticks does not say how large friction is, but it would slide with less. Where such a parameter is worse
// at a bound (`BoundCheck`), the value beyond which its profile (identify/checks/profile.h) stays above 3.84 is an end
// of its interval, the other one being open.
#ifndef CLOTHID_IDENTIFY_CHECKS_EXCLUDED_SIDE_H_
#define CLOTHID_IDENTIFY_CHECKS_EXCLUDED_SIDE_H_

#include "identify/base/options.h"
#include "identify/estimate/fit_summary.h"
#include "identify/problem/problem.h"

namespace clothid {

// Fills lower95 or upper95, or both, of the parameters of `summary->bound_checks` that are worse at that bound: some
// ten fits of the others each, a rollout where there are none. They stay NaN where no value is excluded once the others
// have moved, too. Adds the work to the counts. Leaves the problem as it was.
void AddExcludedSides(const FitOptions& options, FitProblem* problem, FitSummary* summary);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_CHECKS_EXCLUDED_SIDE_H_
