// What time step and mesh do to an estimate: the fit again with others, and its intervals with what that moves.
//
// From the estimate, each fit taking some iterations: at half the time step; at twice the step, where that works, which
// tells the order at which the error falls; and on a mesh of twice the density (sim/scene/refinement.h), where a start
// that is estimated is estimated from its base again. How errors follow from these, and what they do to intervals, says
// identify/uncertainty/discretization_error.h.
#ifndef CLOTHID_IDENTIFY_CHECKS_DISCRETIZATION_CHECK_H_
#define CLOTHID_IDENTIFY_CHECKS_DISCRETIZATION_CHECK_H_

#include <optional>
#include <vector>

#include "identify/checks/repeated_fit.h"

namespace clothid {

// Absent: not asked for, or stopped before it ended.
struct DiscretizationCheck {
  std::optional<RepeatedFit> half_step, double_step;
  std::optional<RepeatedFit> fine_mesh;
};

// The fits of `parts`, but for those of the time step that `known` has, of which the errors go into the intervals of
// `summary`, and their work into its counts. `problem` is that of `summary`, which must have an estimate. Ends early
// where options.cancel is true. Throws `Error` where `FitProblem` does, and for a mesh where `ExpectRefinable` does.
DiscretizationCheck CheckDiscretization(const std::vector<RecordedMotion>& motions, const FitOptions& options,
                                        const DiscretizationParts& parts, const FitProblem& problem,
                                        FitSummary* summary, DiscretizationCheck known = {});

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_CHECKS_DISCRETIZATION_CHECK_H_
