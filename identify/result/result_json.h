// result.json, what programs read of a fit.
#ifndef CLOTHID_IDENTIFY_RESULT_RESULT_JSON_H_
#define CLOTHID_IDENTIFY_RESULT_RESULT_JSON_H_

#include <string>
#include <vector>

#include "datasets/motion/recorded_motion.h"
#include "identify/fit/fit.h"
#include "identify/verdict/verdict.h"

namespace clothid {

// The text of result.json, schema "clothid.result/1". Numbers are written so that they read back exactly, NaN as null.
// All but "seconds", "flags" and "threads" is the same on repeated runs and on any number of threads. `std`, `lower95`
// and `upper95` are null where a parameter has no interval (`HasInterval`); `std` is from the noise alone, and the
// interval has `step_error` in it, and `mesh_error`, which is there where it was asked for. "verdict" has the overall
// line first; "usable", of the whole and of every parameter, is "yes", "with care" or "no". "contact_events"
// counts those of the rollouts at the estimate (see RolloutCounts). "uncertainty", "starts", "profiles", "step_check"
// and "holdout" are null where they were not asked for. "step_check", "double_step" and "fine_mesh" are the fits at
// half and at twice the time step and on a finer mesh.
std::string ResultJson(const FitSummary& summary, const FitChecks& checks, const std::vector<RecordedMotion>& motions);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_RESULT_RESULT_JSON_H_
