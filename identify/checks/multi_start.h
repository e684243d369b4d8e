// Fits from several starting points: does every one end in the same minimum?
#ifndef CLOTHID_IDENTIFY_CHECKS_MULTI_START_H_
#define CLOTHID_IDENTIFY_CHECKS_MULTI_START_H_

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "identify/base/options.h"
#include "identify/fit/fit.h"
#include "identify/problem/problem.h"

namespace clothid {

// One fit of several. Values in the parameters' own units.
struct StartResult {
  Eigen::VectorXd start;   // [p]
  Eigen::VectorXd values;  // [p] where it ended; empty: the rollout at the start failed
  FitStatus status = FitStatus::kFailed;
  double cost = 0.0;
  double rmse = 0.0;  // m
  int minimum = -1;   // index into `MultiStart::minima`; -1: it did not converge
};

// Where converged fits ended, within one standard deviation or 1e-3 of an internal coordinate of each other.
struct Minimum {
  Eigen::VectorXd values;  // [p] of its best fit
  double cost = 0.0;
  double rmse = 0.0;  // m
  int num_starts = 0;
  // Twice the cost above that of the first minimum, over s^2: beyond 3.84 the measurements tell the two apart at 95 %.
  double cost_rise = 0.0;
  bool is_distinguishable() const;
};

struct MultiStart {
  std::vector<StartResult> starts;  // in the order in which they ran; the first is the problem's own start
  std::vector<Minimum> minima;      // by rising cost: the first is preferred
  // [p] whether a minimum that the measurements cannot tell from the first has another value of the parameter.
  std::vector<bool> ambiguous;
};

// The internal coordinates of `count` starts: first that of the blocks, then a Latin hypercube within the bounds: a
// factor of 10 to both sides of the start in logarithmic coordinates, 0 to 1 for friction. Frozen blocks stay.
std::vector<Eigen::VectorXd> StartPoints(const std::vector<ParameterBlock>& blocks, int count, std::uint64_t seed);

// `Fit` with `motions` from options.num_starts points of `problem`, which is that of `motions` and `options`. Returns
// the converged fit of lowest cost, or else the fit of lowest cost, with the work of all of them in its counts; its
// uncertainty is estimated at the end. Stops early when options.cancel turns true. With several threads fits run side
// by side, unless they keep a journal: the result is the same, but options.on_iteration and on_progress are not called.
FitSummary FitFromStarts(const FitOptions& options, const std::vector<RecordedMotion>& motions, FitProblem* problem,
                         MultiStart* result);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_CHECKS_MULTI_START_H_
