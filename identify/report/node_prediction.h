// Where the whole cloth is, also where a recording sees parts of it.
#ifndef CLOTHID_IDENTIFY_REPORT_NODE_PREDICTION_H_
#define CLOTHID_IDENTIFY_REPORT_NODE_PREDICTION_H_

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "datasets/motion/recorded_motion.h"
#include "identify/fit/fit.h"
#include "identify/problem/problem.h"

namespace clothid {

// Per recording every node of its cloth at its frames, at the estimate: [3N x T] m, by one rollout. Empty where
// `FitSummary::predicted` has them, because the observed points are the nodes or there are clouds, or where the rollout
// failed. `motions` are those of `problem`.
std::vector<Eigen::MatrixXd> PredictNodes(const std::vector<RecordedMotion>& motions, const FitProblem& problem,
                                          const FitSummary& summary);

// Where the recordings correct the rollouts of the fit: puts predictions without corrections, at the start and at the
// estimate, in place of those of `summary`, as what a simulation with these parameters does. The errors of `summary`
// stay. Returns how far those at the estimate are from the recordings; nothing, and changes nothing, where a rollout
// failed.
std::optional<PredictionError> PredictUncorrected(const std::vector<RecordedMotion>& motions, const FitProblem& problem,
                                                  FitSummary* summary);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_REPORT_NODE_PREDICTION_H_
