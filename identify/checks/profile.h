// Profile likelihood: how much worse does the best fit get when one parameter is held off its estimate?
//
// For the parameter i at q_i the profile is  2 (min over the other parameters of L - L at the estimate)/(s w)^2,  L
// with the priors, s (with priors `ParameterUncertainty::cost_scale`) and, where residuals are correlated, the widening
// w of identify/uncertainty/uncertainty.h. It is 3.84 at the ends of the 95 % interval (chi-square, one degree of
// freedom), which, unlike the interval from the covariance, holds for costs that are not quadratic: it is lopsided
// where the cost is, and open where no value within the bounds is excluded.
#ifndef CLOTHID_IDENTIFY_CHECKS_PROFILE_H_
#define CLOTHID_IDENTIFY_CHECKS_PROFILE_H_

#include <Eigen/Core>
#include <limits>
#include <string>
#include <vector>

#include "identify/base/options.h"
#include "identify/fit/fit.h"
#include "identify/problem/problem.h"

namespace clothid {

struct ProfilePoint {
  double value = 0.0;      // of the held parameter, in its own unit
  double cost_rise = 0.0;  // the profile; negative: the estimate was not the minimum
  Eigen::VectorXd values;  // [p] of all parameters, the others at their best
};

struct Profile {
  std::string parameter;
  std::vector<ProfilePoint> points;  // by rising value, the estimate among them
  // The ends of the interval; NaN where it is open: the profile stays below 3.84 up to the bound.
  double lower95 = std::numeric_limits<double>::quiet_NaN();
  double upper95 = std::numeric_limits<double>::quiet_NaN();
  // The standard deviation is that of the optimiser: a cost without noise has no scale to judge a rise by. The interval
  // is that of the covariance, and the estimate the only point.
  bool has_no_noise = false;
  int num_failed = 0;  // points at which the fit of the others did not converge; they are left out
};

// Of parameter `name` of a fit that has an uncertainty. Adds its work to `statistics`. Leaves the problem as it was.
// Throws `Error` (kUsage) where the parameter is not fitted or is frozen.
Profile ProfileParameter(const FitOptions& options, const FitSummary& summary, const std::string& name,
                         FitProblem* problem, CostStatistics* statistics);

// The value on one side of the estimate, -1 below or +1 above, beyond which the profile of parameter `index` is above
// 3.84; NaN: it stays below up to the bound, or the fit of the others fails on the way. Likewise.
double ProfileEnd(const FitOptions& options, const FitSummary& summary, int index, int side, FitProblem* problem,
                  CostStatistics* statistics);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_CHECKS_PROFILE_H_
