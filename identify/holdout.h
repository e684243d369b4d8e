// How well do the estimates predict a recording that they have not seen?
#ifndef CLOTHID_IDENTIFY_HOLDOUT_H_
#define CLOTHID_IDENTIFY_HOLDOUT_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "costs/parameter_block.h"
#include "datasets/recorded_motion.h"

namespace clothid {

struct Holdout {
  double rmse = 0.0;          // m, at the estimate; NaN: its rollout failed
  double nominal_rmse = 0.0;  // m, at the starting values; NaN: its rollout failed
  std::string failure;        // one line; empty: both rollouts worked
};

// `values` [p] are the estimates of `blocks`; parameters that the recording's scene does not have are left out, all
// others stay at its nominal values. Throws `Error` where `RecordingModel` does.
Holdout EvaluateHoldout(const RecordedMotion& motion, const std::vector<ParameterBlock>& blocks,
                        const Eigen::VectorXd& values);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_HOLDOUT_H_
