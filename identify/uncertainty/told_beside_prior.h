// What a recording adds to what was believed of a parameter before.
//
// With H of identify/uncertainty/priors.h, P_i the precision of the prior of parameter i and H_o the same without it,
// all but that prior knows the parameter with the precision d = 1/(H_o^-1)_ii = 1/(H^-1)_ii - P_i: what the recordings
// tell, and what is believed of the others. To second order the cost without the prior has its minimum at
//   q_o = q + P_i (q - q_i)/d,   q the estimate, q_i the centre of the prior.
// The prior and that disagree by |q_o - q_i| over the root of the sum of their variances.
#ifndef CLOTHID_IDENTIFY_UNCERTAINTY_TOLD_BESIDE_PRIOR_H_
#define CLOTHID_IDENTIFY_UNCERTAINTY_TOLD_BESIDE_PRIOR_H_

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "costs/prediction/parameter_block.h"

namespace clothid {

// A standard deviation above this share of that of the prior adds nothing to it.
inline constexpr double kAddsNothing = 0.9;
// Beyond so many joint standard deviations prior and recordings contradict each other.
inline constexpr double kDisagreement = 3.0;

struct ToldBesidePrior {
  double share = 1.0;  // the standard deviation of the estimate over that of the prior
  // Without the prior: standard deviation of q, infinite where nothing else knows the parameter, and the value, NaN
  // there.
  double other_std = std::numeric_limits<double>::infinity();
  double other_value = std::numeric_limits<double>::quiet_NaN();
  double disagreement = 0.0;  // in joint standard deviations, >= 0; 0 where nothing else sees the parameter
  bool is_told = false;       // without its prior it would be identifiable (identify/uncertainty/uncertainty.h)

  bool adds_nothing() const { return !(share <= kAddsNothing); }
  bool disagrees() const { return disagreement > kDisagreement; }
};

// Of block `index` with a prior, its estimate `coordinates`[index] with the standard deviation `coordinate_std`, which
// correlated residuals make `widening` times wider. `jacobian` [r x p]: J; `moving`: the blocks that may move, `index`
// among them; `scale`: s; `is_visible`: whether anything but its prior sees it. Leaves is_told.
ToldBesidePrior TellBesidePrior(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates,
                                const Eigen::MatrixXd& jacobian, const std::vector<int>& moving, int index,
                                double coordinate_std, double scale, double widening, bool is_visible);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_UNCERTAINTY_TOLD_BESIDE_PRIOR_H_
