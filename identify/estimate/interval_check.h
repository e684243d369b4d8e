// Is the cost as quadratic over an interval as the covariance takes it to be?
//
// A cloth that buckles has a rough cost: its derivative at the estimate is that of a small dent, and the interval from
// it is far too narrow. So the cost is looked at where it should have risen by 3.84 s^2/2: at both ends of the interval
// of the parameter whose interval is widest relative to its bounds, the others moved as the covariance says. An end
// with a lower cost than the estimate is a point to go on from (identify/fit/continued_fit.h).
//
// A cost may have a lower minimum behind a hill, and an interval that residuals without an explanation make wide may
// reach across. There the cost of its end says nothing, but a Gauss-Newton step from it leads down on the other side.
#ifndef CLOTHID_IDENTIFY_ESTIMATE_INTERVAL_CHECK_H_
#define CLOTHID_IDENTIFY_ESTIMATE_INTERVAL_CHECK_H_

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <vector>

#include "costs/prediction/parameter_block.h"
#include "identify/uncertainty/uncertainty.h"

namespace clothid {

class FitEvaluator;
class FitProblem;

struct IntervalCheck {
  int parameter = 0;
  // 2 (L - L at the estimate)/(s w)^2 at the two ends, w the widening of the interval; 3.84 where the cost is
  // quadratic. NaN: the rollout failed, or the end lies outside the bounds.
  double rise_below = std::numeric_limits<double>::quiet_NaN();
  double rise_above = std::numeric_limits<double>::quiet_NaN();
  // [p + n + f] the internal coordinates of the end of lower cost, or of where a step from an end leads, where that is
  // below the cost of the estimate by more than rounding, beyond the ends by a rise of -0.2; empty: none is.
  Eigen::VectorXd better;
  Eigen::VectorXd step;  // [p + n + f] from the estimate to the upper end
  // The least rise of where the steps of `LookBeyond` lead. NaN: nobody looked, or every rollout failed.
  double rise_beyond = std::numeric_limits<double>::quiet_NaN();

  // Both within a factor of two.
  bool is_quadratic() const;
  // The least of all that is known.
  double lowest_rise() const;
};

// Two evaluations of the cost, at `coordinates` [p + n + f] moved; `follow` [(n + f) x p]: how other unknowns follow
// the parameters (identify/uncertainty/marginal.h). Absent where no parameter has an interval, or where it is that of
// the optimiser: without noise there is no s to measure a rise by.
std::optional<IntervalCheck> CheckInterval(const std::vector<ParameterBlock>& blocks,
                                           const Eigen::VectorXd& coordinates, double cost,
                                           const Uncertainty& uncertainty, const Eigen::MatrixXd& follow,
                                           FitEvaluator* evaluator);

// Where neither end is lower: a Gauss-Newton step from each, within the bounds, and the cost where it leads, for fits
// of parameters alone. Two forward sweeps, and the cost where the model at an end promises a lower one.
void LookBeyond(const FitProblem& problem, const Eigen::VectorXd& coordinates, double cost,
                const Uncertainty& uncertainty, FitEvaluator* evaluator, IntervalCheck* check);

// Residuals above this many sigma are not those of noise.
inline constexpr double kExplainedScale = 3.0;

// Whether the estimate lies in a dent of a rough cost.
//
// A cloth that buckles, or swings long without damping, has a cost with dents far narrower than the distances that
// matter. The derivative at the estimate, and the interval with it, is that of one dent: too narrow by orders of
// magnitude, and the check at the ends of the interval, which lie in the same dent, sees nothing of it. So the cost is
// looked at a step of 1 % away as well, on both sides of every parameter whose interval is much narrower, the others
// held. By the quadratic model it rises there by
//   2 (L - L at the estimate)/s^2 = d^2 (C^-1)_ii,   d the step in q_i, C the covariance of independent residuals.
// A smooth cost rises by about that much; that of a dent by far less, since the step leads out of it.
//
// Where measurements are explained to their noise no dent beside the truth is as deep, so nothing is looked at.
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

// What the cost is where a parameter, or a direction, stands at its bounds that no derivative tells.
//
// A derivative knows of the place where it is taken alone: cloth that sticks tells nothing of how much larger friction
// could be, but it would slide with less. So what is not visible by its derivative
// (identify/uncertainty/uncertainty.h) is tried at both of its bounds: a parameter whose own column is too small to be
// seen, all others as they are; of the directions in which others could move unseen, the ends where the first of them
// meets a bound. Whether it is told there is for the profile to say (identify/checks/excluded_side.h).
struct BoundCheck {
  int parameter = -1;  // -1: of a direction
  int direction = -1;  // of `Uncertainty::hidden_directions`; -1: of a parameter
  // 2 (L - L at the estimate)/max(1, s)^2 at the lower and the upper end, of a direction against it and along it; zero
  // at an end where the estimate stands. NaN: the rollout failed.
  double rise_below = 0.0, rise_above = 0.0;
  Eigen::VectorXd better;  // [p + n + f] the end whose cost is lower, by a rise of -0.2; empty: none is

  // By more than the two standard deviations that are visible.
  bool is_worse_below() const { return rise_below > kVisibleChange * kVisibleChange; }
  bool is_worse_above() const { return rise_above > kVisibleChange * kVisibleChange; }
  // The change of the prediction, in max(1, s) standard deviations, that raises the cost by as much as the worse end.
  double change() const;
};

// Of a problem whose parameters have the derivative `jacobian` [r x p] at the estimate, without priors. Priors, knots
// of a wind and the unknowns of fields, which are told by what is believed of them, are left out.
std::vector<BoundCheck> CheckBounds(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates,
                                    double cost, const Uncertainty& uncertainty, const Eigen::MatrixXd& jacobian,
                                    const Eigen::MatrixXd& follow, FitEvaluator* evaluator);

// Two evaluations of the cost for every free parameter whose interval is narrower than a third of the step, in their
// order. `coordinates` [p + n + f] of the estimate, whose cost is `cost`.
std::vector<DentCheck> CheckForDents(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates,
                                     double cost, const Uncertainty& uncertainty, FitEvaluator* evaluator);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_ESTIMATE_INTERVAL_CHECK_H_
