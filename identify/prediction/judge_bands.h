// The rollouts behind identify/prediction/held_bands.h.
#ifndef CLOTHID_IDENTIFY_PREDICTION_JUDGE_BANDS_H_
#define CLOTHID_IDENTIFY_PREDICTION_JUDGE_BANDS_H_

#include <Eigen/Core>
#include <vector>

#include "costs/prediction/parameter_block.h"
#include "datasets/motion/recorded_motion.h"
#include "identify/checks/holdout.h"
#include "identify/prediction/held_bands.h"
#include "identify/prediction/posterior.h"

namespace clothid {

// Arguments as of `EvaluateHoldout`; `posterior` is `PosteriorOf` the same fit. Where each recording of the fit has a
// parameter for itself, a draw of another recording takes those of one of them, in turns. At most some millions of
// measurements are looked at, evenly chosen. Where it was cancelled the result is not to be used.
HeldBands JudgeByBands(const std::vector<RecordedMotion>& motions, const std::vector<ParameterBlock>& blocks,
                       const Eigen::VectorXd& values, const FitPosterior& posterior, HeldOut held_out,
                       const std::vector<HeldOutStart>& starts, const HeldBandOptions& options);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_PREDICTION_JUDGE_BANDS_H_
