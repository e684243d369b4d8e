// Leads a fit to where its optimiser starts, by fits of the first frames alone, of more and more of them.
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
// Stages end where the next step is short, and lead to where it would (FitPrecision::kLoose). Their derivatives come by
// forward sweeps where parameters are few: rollout and Jacobian are one pass then.
#ifndef CLOTHID_IDENTIFY_FIT_GROWING_HORIZON_H_
#define CLOTHID_IDENTIFY_FIT_GROWING_HORIZON_H_

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "datasets/motion/recorded_motion.h"
#include "identify/base/options.h"
#include "identify/fit/continued_fit.h"
#include "identify/fit/problem.h"

namespace clothid {

// The frames and forces of the first `share` of the time of a recording, at least kFewestFrames of each, as a recording
// of its own. Without forces where none of these was measured.
RecordedMotion FirstFrames(const RecordedMotion& motion, double share);
inline constexpr int kFewestFrames = 3;

// Where the optimiser starts, and what finding that took.
struct LedStart {
  Eigen::VectorXd coordinates;  // [p] of the blocks
  Eigen::VectorXd last_step;    // [p] by which the last stage moved them; empty where it did not work
  CostStatistics statistics;
  double evaluation_seconds = 0.0;  // of evaluations alone
};

class GrowingHorizon {
 public:
  // Both must outlive it; `options` are those of the problems that it leads.
  GrowingHorizon(const std::vector<RecordedMotion>& motions, const FitOptions& options);

  // By `fit`, from the blocks' part of `coordinates` of `problem`. Unknown starts (costs/start/unknown_start.h) stay at
  // their bases. Ends early where a stage finds nothing, and where options.cancel turns true. Stages go on in the
  // journals of `problem`, and throw where these do.
  LedStart Lead(const FitProblem& problem, const Eigen::VectorXd& coordinates, FitFunction fit);

 private:
  FitOptions StageOptions(const FitProblem& problem, const Eigen::VectorXd& coordinates) const;
  // Of the first `share` of the time, starting at `coordinates` of `problem`; null where it holds nothing to fit.
  std::unique_ptr<FitProblem> MakeStage(const FitProblem& problem, const Eigen::VectorXd& coordinates, double share,
                                        const FitOptions& options) const;

  const std::vector<RecordedMotion>& motions_;
  const FitOptions& options_;
};

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_FIT_GROWING_HORIZON_H_
