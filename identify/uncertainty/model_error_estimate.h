// How far the model errs, from the residuals that a fit leaves.
//
// With residuals e_i over sigma_i at the times t_i and the variances (in sigma_i^2)
//   v_i = 1 + tau(t_i)^2/sigma_i^2,   tau(t)^2 = sum_k c_k phi_k(t),   c_k >= 0,
// phi_k the hat functions of knots evenly over the rollout, the c_k are where the likelihood
//   -2 log L = sum_i h log v_i + e_i^2/v_i,   h = (m - p)/m,
// is least (restricted: p of the m residuals are fitted away). At the start of the rollout c = 0: the cloth is where it
// was seen. By Fisher scoring with the bounds kept. Where the likelihood does not gain what chance could not, the model
// does not err: every c is zero then.
#ifndef CLOTHID_IDENTIFY_UNCERTAINTY_MODEL_ERROR_ESTIMATE_H_
#define CLOTHID_IDENTIFY_UNCERTAINTY_MODEL_ERROR_ESTIMATE_H_

#include <Eigen/Core>

#include "datasets/observation/model_error.h"

namespace clothid {

// Of rows of one kind.
struct ErrorRows {
  Eigen::VectorXd times;    // [m] s
  Eigen::VectorXd sigmas;   // [m] m or N
  Eigen::VectorXd squares;  // [m] e_i^2, as a loss weighs them
};

inline constexpr int kMostErrorKnots = 10;  // beside the first
// What -2 log L gains where there is nothing but noise is chi-squared of about half of the knots: above this with a
// probability below 1e-6.
inline constexpr double kLeastGain = 40.0;

// The knots are evenly from `start` to the last of the rows, no more than one for every second time of theirs.
// `degrees_of_freedom`: h.
ErrorCurve EstimateErrorCurve(const ErrorRows& rows, double start, double degrees_of_freedom);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_UNCERTAINTY_MODEL_ERROR_ESTIMATE_H_
