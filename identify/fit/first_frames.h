// Leads a fit to where its optimiser starts, by stages of the first frames alone, of more and more of them.
//
// Seen to its end, a motion can be reproduced wrongly in many ways: cloth that swings once too often is in step again
// at the end, and the cost has a minimum there. Seen for its first eighth it cannot: there is one minimum, wide enough
// for any start. Its estimate is good to a part of a swing over the first quarter, that of the quarter over the half,
// and so on. Little is lost where the cost has but one minimum: a few eighths, quarters and halves of rollouts replace
// the long way that an optimiser would go with whole ones.
//
// A short motion may tell little of a parameter, of friction nothing before a contact. So that no stage carries one
// off, each believes what the stage before it has found: to an eighth of the parameter's range, as a standard
// deviation (costs/prediction/parameter_block.h, `ParameterPrior`). Priors that are given stand in place of it.
//
// A stage whose first frames hold nothing to fit, as before a gauge reads or a point is seen, is left out: the frames
// after it do.
//
// Such a stage ends where the next step is short, and leads to where it would (FitPrecision::kLoose). Its derivatives
// come by forward sweeps where parameters are few: rollout and Jacobian are one pass then.
#ifndef CLOTHID_IDENTIFY_FIT_FIRST_FRAMES_H_
#define CLOTHID_IDENTIFY_FIT_FIRST_FRAMES_H_

#include <Eigen/Core>
#include <vector>

#include "datasets/motion/recorded_motion.h"
#include "identify/base/options.h"
#include "identify/fit/descent.h"
#include "identify/problem/problem.h"

namespace clothid {

// The frames and forces of the first `share` of the time of a recording, at least kFewestFrames of each, as a recording
// of its own. Without forces where none of these was measured.
RecordedMotion FirstFrames(const RecordedMotion& motion, double share);
inline constexpr int kFewestFrames = 3;

// Where first frames lead, and what finding that took.
struct Lead {
  Eigen::VectorXd coordinates;  // [p] of the blocks
  Eigen::VectorXd last_step;    // [p] by which the last stage moved them; empty where it did not work
  CostStatistics statistics;
  double evaluation_seconds = 0.0;  // of evaluations alone
};

// A stage of first frames of `motions`, fitted as `problem` is with `options`, from and to `lead`. Other unknowns than
// the parameters stay at zero. Fills state, note, work and cost of `stage`: it is skipped where its frames hold nothing
// to fit. Goes on in the journals of `problem`, and throws where these do. False where nothing was found, and the
// frames after it are none to go on with.
bool FitFirstFrames(const std::vector<RecordedMotion>& motions, const FitOptions& options, const FitProblem& problem,
                    FitStage* stage, Lead* lead);

// Runs those stages of the plan of `descent`, which has begun, and takes it to where they lead, unless the cost is
// higher there. That of the start may be loose: the end is compared with it once more.
Lead LeadByFirstFrames(const std::vector<RecordedMotion>& motions, const FitOptions& options, const FitProblem& problem,
                       Descent* descent);

// Adds what it took to the work of a descent that it has led.
void AddLead(const Lead& lead, FitSummary* summary);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_FIT_FIRST_FRAMES_H_
