// The memory of rollouts that the recordings correct, and the fit with it: the trials of
// identify/problem/memory_trial.h and what follows from them. A memory whose rollouts amplify changes without bound, so
// that a unit of a coordinate moves what is measured by more than a hundred times the cloth, does not serve, and trials
// do not begin at the end of the first fit where that is so there. Internal to identify/fit.
#ifndef CLOTHID_IDENTIFY_FIT_MEMORY_SEARCH_H_
#define CLOTHID_IDENTIFY_FIT_MEMORY_SEARCH_H_

#include <vector>

#include "datasets/motion/recorded_motion.h"
#include "identify/base/options.h"
#include "identify/estimate/fit_summary.h"
#include "identify/problem/problem.h"

namespace clothid {

// Whether a fit is asked to try memories, has not, and leaves more than noise.
bool MayAssimilate(const FitOptions& options, const FitProblem& problem, const FitSummary& summary);

// Puts a fit with corrections in the place of `summary`, a fit without, where that explains the recordings better, and
// leaves the problem as the fit that stands has it. `motions` (may be null): those of the problem; then it is known
// what the time step does to corrected rollouts. `summary` says why nothing was tried, or which memories were.
void AssimilateFit(const FitOptions& options, const std::vector<RecordedMotion>* motions, FitProblem* problem,
                   FitSummary* summary);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_FIT_MEMORY_SEARCH_H_
