// Where a parameter may be of which a fit tells no interval: what a prediction must count with that does not take it
// for known.
//
// With c the change that the prediction sees from bound to bound, R the range of q between them and s the scale of
// residuals (identify/uncertainty/uncertainty.h):
//   - Of one that stands at its bound and is visible, the recording tells that it lies near it, as far as its
//     derivative goes there: q follows the half of a normal distribution about the bound that lies inside, of the
//     standard deviation max(1, s) R/c, the others moving along.
//   - Of one whose own derivative shows nothing, and that no other undoes, every q that was believed before is as
//     likely: from bound to bound, at most a factor of 1e4 about their middle, less what is excluded
//     (identify/checks/excluded_side.h). Its estimate is where the fit has left it.
// Of others there is no range: those that are hidden together, as stiffness and density are, keep what they have in
// common, and those that stalled are not known to be anywhere.
#ifndef CLOTHID_IDENTIFY_UNCERTAINTY_UNTOLD_RANGE_H_
#define CLOTHID_IDENTIFY_UNCERTAINTY_UNTOLD_RANGE_H_

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <vector>

#include "costs/prediction/parameter_block.h"

namespace clothid {

// What a fit says of a parameter without an interval that it was free to move.
struct UntoldParameter {
  ParameterScale scale = ParameterScale::kLinear;
  double value = 0.0, lower_bound = 0.0, upper_bound = 0.0;  // in its own unit, as the ends of the interval
  bool at_bound = false;
  bool hidden_alone = false;                                                     // `IsHiddenAlone`
  double visible_change = 0.0;                                                   // c
  double residual_scale = 1.0;                                                   // s
  double lower95 = std::numeric_limits<double>::quiet_NaN(), upper95 = lower95;  // NaN: nothing is excluded there
};

// Of q: the logarithm of the value, or itself.
struct UntoldRange {
  double lower = 0.0, upper = 0.0;
  double center = 0.0;                                         // one of them, where the deviation is finite
  double deviation = std::numeric_limits<double>::infinity();  // infinite: every q between is as likely

  // The q of a number that is drawn from a normal distribution of variance 1.
  double At(double normal) const;
};

// None also where a bound is infinite.
std::optional<UntoldRange> RangeOf(const UntoldParameter& parameter);

// Whether parameter `index` makes one of these hidden directions [p], largest entry 1, by itself: the others take part
// by less than a tenth of their q.
bool IsHiddenAlone(const std::vector<Eigen::VectorXd>& directions, Eigen::Index index);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_UNCERTAINTY_UNTOLD_RANGE_H_
