// How well do the estimates predict measurements that the fit has not seen?
#ifndef CLOTHID_IDENTIFY_CHECKS_HOLDOUT_H_
#define CLOTHID_IDENTIFY_CHECKS_HOLDOUT_H_

#include <Eigen/Core>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "costs/prediction/parameter_block.h"
#include "costs/prediction/robust_loss.h"
#include "costs/start/unknown_start.h"
#include "datasets/motion/recorded_motion.h"
#include "identify/checks/lead_time.h"

namespace clothid {

struct Holdout {
  double rmse = std::numeric_limits<double>::quiet_NaN();          // m, at the estimate; NaN: a rollout failed
  double nominal_rmse = std::numeric_limits<double>::quiet_NaN();  // m, at the nominal values of the scenes, likewise
  std::string failure;                                             // one line; empty: all rollouts worked
  double force_rms = std::numeric_limits<double>::quiet_NaN();     // N, likewise, of held-out forces
  double nominal_force_rms = std::numeric_limits<double>::quiet_NaN();
  double nodes_rmse = std::numeric_limits<double>::quiet_NaN();  // m, see CloudError::node_rmse; NaN without
  bool has_only_forces = false;                                  // nothing else was held out
  // Of a fit with a robust loss: the cost by that loss, likewise; NaN without.
  double cost = std::numeric_limits<double>::quiet_NaN();
  double nominal_cost = std::numeric_limits<double>::quiet_NaN();
  std::vector<LeadTimeError> lead_times = {};  // at the estimate; empty: nobody asked for them

  // The estimates predict no better than what was known before the fit: it has learnt the noise, or the model is wrong.
  // By the costs where they are known, else of positions where there are any.
  bool has_failed() const {
    if (cost == cost && nominal_cost == nominal_cost) return cost > nominal_cost;
    const double own = has_only_forces ? force_rms : rmse;
    const double nominal = has_only_forces ? nominal_force_rms : nominal_rmse;
    return !(own <= nominal) && !(own == own && nominal != nominal);
  }
};

enum class HeldOut {
  kRecordings,  // others than the fitted ones
  kFrames,      // of the fitted recordings, in their order
};

// The start of a recording as a fit of it has estimated it; none: that of the scene, or the base of an unknown one.
struct HeldOutStart {
  std::shared_ptr<const UnknownStart> start;
  Eigen::VectorXd unknowns;  // [n]
};

// What of `blocks` there is in a recording, and their coordinates.
struct HeldOutBlocks {
  std::vector<ParameterBlock> blocks;
  Eigen::VectorXd coordinates;
};

// Of the blocks with `values` [p] those that concern `motion`: recording number `recording` of the fit. -1: none of
// them; then it is believed to be like the fitted ones, and of a parameter that each of them has for itself
// (`FitOptions::each`) it takes the mean of their coordinates, or that of the recording number `like`.
HeldOutBlocks BlocksFor(const RecordedMotion& motion, int recording, const std::vector<ParameterBlock>& blocks,
                        const Eigen::VectorXd& values, std::optional<int> like = std::nullopt);

// The coordinates of blocks [p], with those of the start that a fit has estimated.
Eigen::VectorXd WithStart(const Eigen::VectorXd& coordinates, const HeldOutStart& start);

// Over all of `motions`. `values` [p] are the estimates of `blocks`, see `BlocksFor`; parameters that the scene of a
// recording does not have are left out, all others stay at its nominal values. `starts`: of every one, or empty; both
// predictions start there. `loss`: of the fit. `ahead`: what counts lead times; may be null. Throws `Error` where
// `RecordingModel` does.
Holdout EvaluateHoldout(const std::vector<RecordedMotion>& motions, const std::vector<ParameterBlock>& blocks,
                        const Eigen::VectorXd& values, HeldOut held_out = HeldOut::kRecordings,
                        const std::vector<HeldOutStart>& starts = {}, const RobustLoss& loss = {},
                        LeadTimes* ahead = nullptr);

// Frames by number: begin, begin + 1, .., end - 1.
struct FrameRange {
  int begin = 0, end = 0;
};

// "A:B" with 0 <= A < B. Throws `Error` (kUsage), naming `flag`.
FrameRange ParseFrameRange(const std::string& text, const std::string& flag);

// Cuts the frames of `range`, with the forces that are nearest to them in time, out of every recording of `motions`,
// where they become unseen, and returns recordings in which they alone are seen. The centroid of both is that of all
// frames. Throws `Error` (kUsage), naming the recording, where it has fewer frames.
std::vector<RecordedMotion> HoldOutFrames(const FrameRange& range, std::vector<RecordedMotion>* motions);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_CHECKS_HOLDOUT_H_
