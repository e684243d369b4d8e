// Does the estimate lie in a dent of a rough cost?
//
// A cloth that buckles, or swings long without damping, has a cost with dents far narrower than the distances that
// matter. The derivative at the estimate, and the interval with it, is that of one dent: too narrow by orders of
// magnitude, and the check at the ends of the interval (identify/fit/interval_check.h), which lie in the same dent,
// sees nothing of it. So the cost is looked at a step of 1 % away as well, on both sides of every parameter whose
// interval is much narrower, the others held. By the quadratic model it rises there by
//   2 (L - L at the estimate)/s^2 = d^2 (C^-1)_ii,   d the step in q_i, C the covariance of independent residuals.
// A smooth cost rises by about that much; that of a dent by far less, since the step leads out of it.
//
// Where measurements are explained to their noise no dent beside the truth is as deep, so nothing is looked at.
#ifndef CLOTHID_IDENTIFY_FIT_DENT_CHECK_H_
#define CLOTHID_IDENTIFY_FIT_DENT_CHECK_H_

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "costs/prediction/parameter_block.h"
#include "identify/uncertainty/uncertainty.h"

namespace clothid {

class FitEvaluator;

// Residuals above this many sigma are not those of noise.
inline constexpr double kExplainedScale = 3.0;

struct DentCheck {
  int parameter = 0;
  double step = 0.0;           // d, of q
  double expected_rise = 0.0;  // by the quadratic model, in s^2
  // What it is at both ends. NaN: the rollout failed, or the end lies outside the bounds.
  double rise_below = std::numeric_limits<double>::quiet_NaN();
  double rise_above = std::numeric_limits<double>::quiet_NaN();

  // One of them is below a tenth of what was expected.
  bool is_dent() const;
};

// Two evaluations of the cost for every free parameter whose interval is narrower than a third of the step, in their
// order. `coordinates` [p + n] of the estimate, whose cost is `cost`.
std::vector<DentCheck> CheckForDents(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates,
                                     double cost, const Uncertainty& uncertainty, FitEvaluator* evaluator);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_FIT_DENT_CHECK_H_
