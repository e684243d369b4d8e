// How sure a fit is of its parameters: standard deviations, intervals, and what the measurements do not determine.
//
// At a solution, with the whitened residuals e of m measurements and their Jacobian J = de/dq [m x p] in the internal
// coordinates q of costs/prediction/parameter_block.h:
//   covariance of q = s^2 (J^T J)^-1,   s^2 = |e|^2/(m - p), at least 1 where the sigma of the measurements is known
//   std(q)^2        = its diagonal + r^2,   r the resolution of the fit (`ParameterBlock::Resolution`): without noise
//                     an estimate is no better than the steps at which the optimiser stops
//   95 % interval   = value(q -+ 1.96 std(q)), cut at the bounds;   std of the value = dvalue/dq std(q)
//
// Priors (`ParameterBlock::prior`) of precision P = diag(1/std^2) are residuals of true standard deviation 1, which s
// does not scale. With H = J^T J + P the estimate then has
//   covariance of q = H^-1 (s^2 J^T J + P) H^-1,
// which for s = 1 is H^-1: precisions add up. identify/uncertainty/told_beside_prior.h says what a parameter owes to
// its own prior.
//
// Links of knots (`ParameterBlock::linked_to`) are rows of J, as sure as the measurements turn out to be. A knot is
// judged by what is left without its own.
//
// That takes residuals as independent. Where they are not, because successive ones have a correlation above 0.3 or
// those of one frame belong together (identify/uncertainty/correlated_scores.h), the covariance of q is the sandwich
// over frames of that room, nowhere less than the one above, and Student's t takes the place of 1.96. A correlation
// within frames alone is looked for where the residuals are not the rounding of a recording without noise.
//
// Identifiability asks how much the prediction can tell. Parameter i is moved from its lower to its upper bound. All
// others move along, in the way that best undoes the change of the whitened prediction. What is left of the change is
//   c_i = 1/sqrt([((J D)^T J D)^-1]_ii),   D = diag(range of q_i between its bounds).
// It is visible where c_i > 2 max(1, s): two standard deviations of the noise, or of what the model leaves
// unexplained. The right singular vectors of J D with singular values below that are the directions nobody sees:
// multiplying all stiffnesses, damping, density and drag by one factor is one of them in every recording.
//
// Priors are rows of J here, scaled by max(1, s). A parameter is judged without its own: so it is never identifiable
// for what was believed of it, but may be for what is believed of another, as stiffness is where the density is known.
//
// A visible parameter may still be told too little to be called identifiable:
//   - Its interval reaches a bound: what ends it there is the bound, not the recording.
//   - Its interval is hardly narrower than what was believed before: that every value of q between the bounds is as
//     likely, which has the standard deviation range/sqrt(12), the range of a logarithmic q at most that of a factor of
//     1e4, for bounds that are wider only keep the optimiser from wandering. Identifiable asks for a third of that: a
//     variance above 1/9 of that of the belief adds little to it. In numbers: an interval of mu narrower than 0.75 with
//     bounds of 0 and 2, ends of a stiffness that differ by less than a factor of 32.
//   - The fit stalled. At a minimum the model |e + J d|^2/2 promises no lower cost. Where it promises one lower by more
//     than 0.1 s^2 the fit stopped early, or at a kink of the cost, whose derivative is that of one side. The decrease
//     that the model promises by the step d = -(J^T J)^-1 J^T e over the parameters off their bounds is
//       1/2 d . C^-1 d,   C = s^2 (J^T J)^-1 + diag((10 r)^2),
//     in which steps of some resolutions of the fit count for next to nothing; d_i^2/(2 C_ii) is the part that a single
//     parameter has in it. Fits that converge stay far below. Up to 2 s^2 the promised minimum lies within two standard
//     deviations of the estimate: nobody knows on which side of the kink the truth is, and |d_i| enters the interval
//     like a standard deviation of its own. Beyond, the covariance is not that of the cost, and no interval is given.
#ifndef CLOTHID_IDENTIFY_UNCERTAINTY_UNCERTAINTY_H_
#define CLOTHID_IDENTIFY_UNCERTAINTY_UNCERTAINTY_H_

#include <ceres/problem.h>

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "costs/prediction/parameter_block.h"
#include "identify/uncertainty/hidden_direction.h"
#include "identify/uncertainty/told_beside_prior.h"

namespace clothid {

// The half-width of a 95 % interval of a normal distribution in standard deviations, and its square: the rise of twice
// the cost, over s^2, at the ends of an interval.
inline constexpr double kNormal95 = 1.959963984540054;
inline constexpr double kChiSquare95 = kNormal95 * kNormal95;

// A least-squares problem at one point: of what was measured, without the priors of its parameters.
struct Linearization {
  Eigen::MatrixXd jacobian;       // [r x p] de/dq, or fewer rows with the same J^T J
  Eigen::VectorXd gradient;       // [p] J^T e
  double squared_residual = 0.0;  // |e|^2, twice the cost
  int num_measurements = 0;       // m
  bool sigma_is_known = true;     // false: residuals are whitened by a guess
  // Per recording [p x T] J_i^T e_i, what each frame adds to the gradient, and the correlation of a coordinate's
  // residuals from frame to frame. Without them residuals count as independent.
  std::vector<Eigen::MatrixXd> frame_scores;
  double autocorrelation = std::numeric_limits<double>::quiet_NaN();

  // s^2 where so many coordinates are fitted.
  double SquaredScale(double num_fitted) const;
};

// That of a Ceres problem with rollouts beside residuals of the user's own. `coordinates` [p] are its parameter blocks,
// each of size 1; `num_measurements` counts the observed coordinates of all recordings (not the rows of `RolloutCost`)
// and the user's own residuals. Rollouts should use `JacobianMethod::kSensitivity`: the rows of the adjoint form span a
// subspace, which makes intervals too wide. A residual of the user's own is in its true standard deviations, so it can
// be weighed against rollouts only where their recordings know sigma; and s widens all intervals, also those of
// parameters that only the user's own residuals tell. Throws std::runtime_error where the problem cannot be evaluated.
Linearization Linearize(const std::vector<double*>& coordinates, int num_measurements, bool sigma_is_known,
                        ceres::Problem* problem);

// Changes of the prediction up to this many standard deviations are not seen.
inline constexpr double kVisibleChange = 2.0;
// Above this share of the standard deviation that was believed before a parameter is hardly told.
inline constexpr double kHardlyTold = 1.0 / 3.0;
// A fit has stalled where the model at its end promises a cost that is lower by more than this, in s^2.
inline constexpr double kStalledDecrease = 0.1;
// Up to this, in s^2, intervals count with the distance.
inline constexpr double kNearDecrease = 2.0;

struct ParameterUncertainty {
  // Of the value, in its own unit, from the noise alone. NaN: frozen, at its bound, not visible or stalled.
  double std = std::numeric_limits<double>::quiet_NaN();
  // Of the value, too: what time step and mesh do to it, which count like standard deviations
  // (identify/uncertainty/discretization_error.h). NaN: nobody looked, or it could not be told.
  double step_error = std::numeric_limits<double>::quiet_NaN();
  double mesh_error = std::numeric_limits<double>::quiet_NaN();
  // Of the value: how far it drifts with the memory of rollouts that recordings correct
  // (identify/problem/memory_trial.h). NaN: they do not.
  double memory_error = std::numeric_limits<double>::quiet_NaN();
  // Of the value: how far the fit stalled from the minimum of its model. NaN: it did not, or too far away.
  double stall_error = std::numeric_limits<double>::quiet_NaN();
  double step_order = std::numeric_limits<double>::quiet_NaN();  // at which step_error falls; NaN: no clear one
  // The interval, with these errors where they are known, and half its width in q. NaN as `std`; but of one that is not
  // visible an end is known beyond which values are excluded (identify/checks/excluded_side.h).
  double lower95 = std::numeric_limits<double>::quiet_NaN();
  double upper95 = std::numeric_limits<double>::quiet_NaN();
  double half_width95 = std::numeric_limits<double>::quiet_NaN();  // also where the fit stalled
  // Of q, from the noise; also where the fit stalled.
  double coordinate_std = std::numeric_limits<double>::quiet_NaN();
  double independent_std = std::numeric_limits<double>::quiet_NaN();  // the same if residuals were independent
  // The same if the start were known exactly; NaN where nothing about it was fitted.
  double known_start_std = std::numeric_limits<double>::quiet_NaN();
  double widening = 1.0;  // the interval of q over the one that it would have then, at least 1
  // A parameter that goes off by independent_std, all others along so as to raise the cost the least, raises twice the
  // cost by the square of this: s, unless there are priors.
  double cost_scale = std::numeric_limits<double>::quiet_NaN();
  std::optional<ToldBesidePrior> beside_prior;  // of one with a prior and a coordinate_std
  // From the estimate to the minimum of the quadratic model |e + J dq|^2/2 there, in standard deviations as of
  // independent residuals: large where a fit stopped early, or at a kink of the cost. NaN without a coordinate_std.
  double distance = std::numeric_limits<double>::quiet_NaN();
  double visible_change = 0.0;  // c_i, in standard deviations of the measurements; 0 where frozen
  // The half-width of the interval of q over that of what was believed before. NaN without a coordinate_std.
  double share_of_belief = std::numeric_limits<double>::quiet_NaN();
  double factor = std::numeric_limits<double>::quiet_NaN();  // between the ends of an interval of a logarithmic q
  bool reaches_lower = false, reaches_upper = false;         // the interval is cut at a bound
  bool at_bound = false;                                     // see `ParameterBlock::IsAtBound`
  bool visible = false;                                      // without its own prior; false where frozen, too
  bool stalled = false;  // takes part in what the model promises too far beyond the estimate
  // Visible and not at its bound, not stalled, the interval narrower than the belief and within the bounds: with a
  // prior the interval that it would have without it, too.
  bool identifiable = false;

  // Whether an end of its interval is known, though the derivative tells nothing of it.
  bool has_excluded_side() const { return std::isnan(std) && !(std::isnan(lower95) && std::isnan(upper95)); }
  // Noise, step, mesh, drift and stall together: root of squares, of what is known. NaN as `std`.
  double total_std() const;
  // Never of one with a prior: that its interval is hardly narrower than the prior is told otherwise.
  bool is_hardly_told() const {
    return !beside_prior && (share_of_belief > kHardlyTold || (reaches_lower && reaches_upper));
  }
};

struct Uncertainty {
  std::vector<ParameterUncertainty> parameters;    // [p]
  Eigen::MatrixXd correlation;                     // [p x p] of q; NaN in rows and columns without a coordinate_std
  Eigen::VectorXd singular_values;                 // of J D over the free parameters, decreasing
  std::vector<HiddenDirection> hidden_directions;  // the most hidden first
  double residual_scale = 0.0;                     // s
  double predicted_decrease = 0.0;                 // of the cost by the model at the estimate, in s^2

  // Residuals are not independent, and intervals are those of the sandwich.
  bool is_widened = false;
  double quantile95 = kNormal95;            // the half-width of an interval in standard deviations
  Eigen::MatrixXd independent_correlation;  // as `correlation` would be if they were

  double largest_widening() const;
  bool all_identifiable(const std::vector<ParameterBlock>& blocks) const;  // all that are not frozen
};

// `blocks` [p] with the names to speak of, bounds and scales; `coordinates` [p] the solution. A parameter at its bound
// is held there while the others get their standard deviations.
Uncertainty EstimateUncertainty(const std::vector<ParameterBlock>& blocks, const Eigen::VectorXd& coordinates,
                                const Linearization& linearization);

// The interval value(q -+ half_width), cut at the bounds.
void SetInterval(const ParameterBlock& block, double coordinate, double half_width, ParameterUncertainty* parameter);

// What the intervals of the visible parameters tell: share_of_belief, factor, bounds that are reached, identifiable.
// Those that stalled lose theirs.
void JudgeIntervals(const std::vector<ParameterBlock>& blocks, Uncertainty* uncertainty);

// Successive residuals with a higher correlation than this are not the noise of a sensor.
inline constexpr double kCorrelatedResiduals = 0.3;
// Residuals below this share of sigma are the rounding of a recording without noise.
inline constexpr double kRoundingResiduals = 1e-3;

// The standard deviation of q that was believed before anything was measured, without a prior: that of every value
// between the bounds being as likely, see above.
double BelievedStd(const ParameterBlock& block);
// Of the range of q between the bounds what was believed, without a prior: a logarithm at most by a factor of 1e4.
double BelievedRangeOf(double range, ParameterScale scale);

// Whether a standard deviation of q is that of the optimiser rather than that of noise: below two resolutions.
bool IsResolution(const ParameterBlock& block, double coordinate, double coordinate_std);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_UNCERTAINTY_UNCERTAINTY_H_
