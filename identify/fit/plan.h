// The plan of a fit: its stages, one after the other, as data.
//
// Far from the answer little is worth finding out exactly, and much is not worth estimating yet. So a fit goes by
// stages that differ in what they look at, how closely, and what they move:
//   - Rollouts that the recordings correct, where they are asked for: a stage for every memory that is tried
//     (identify/problem/memory_trial.h). They take the place of the first frames.
//   - The first eighth, quarter and half of the frames (identify/fit/first_frames.h), with the parameters alone.
//   - All frames with loose rollouts (`Precision`), the parameters alone, until the next step is short.
//   - Then what else is unknown with them, still loosely: the starts, the fields in their 4 x 4 smoothest modes, then
//     in 8 x 8, then in all, and the weights of what is believed to be smooth.
//   - All of it with full precision, to the end; where nothing but weights is chosen, the parameters then alone.
// Where the model errs, plans of this kind follow whose frames count by that (identify/fit/continued_fit.h).
// A stage that there is nothing for is not in the plan. One that turns out to be needless or impossible is skipped, and
// says why.
#ifndef CLOTHID_IDENTIFY_FIT_PLAN_H_
#define CLOTHID_IDENTIFY_FIT_PLAN_H_

#include <string>
#include <vector>

#include "identify/base/options.h"
#include "identify/problem/problem.h"

namespace clothid {

// `is_led`: by first frames. Of rollouts that the recordings correct where those of `problem` do.
FitPlan MakePlan(const FitOptions& options, const FitProblem& problem, bool is_led);

// The stages that find the memory of such rollouts (identify/problem/memory_trial.h); what follows depends on them.
FitPlan PlanMemoryTrials(const FitProblem& problem);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_FIT_PLAN_H_
