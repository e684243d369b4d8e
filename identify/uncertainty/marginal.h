// What is left to say of the parameters where other unknowns are fitted with them: the unknowns are eliminated.
//
// With J = [J_b J_s] of the p parameters and the n unknowns, whose priors are rows of J, and [J_s J_b] = Q R:
//   the lower right block of R [p x p] has  R^T R = H_bb - H_bs H_ss^-1 H_sb,  H = J^T J,
// so that it is the Jacobian of a problem in the parameters alone, whose covariance is their block of H^-1. The
// unknowns follow the parameters by  ds = F db,  F = -H_ss^-1 H_sb,  and the scores of a frame, J_i^T e_i, become those
// of b plus F^T times those of s. The prior adds n residuals and n unknowns, so m - p stays the number of degrees of
// freedom.
#ifndef CLOTHID_IDENTIFY_UNCERTAINTY_MARGINAL_H_
#define CLOTHID_IDENTIFY_UNCERTAINTY_MARGINAL_H_

#include <Eigen/Core>

#include "identify/uncertainty/uncertainty.h"

namespace clothid {

struct Marginal {
  Linearization parameters;  // of the first p coordinates
  Eigen::MatrixXd follow;    // F [n x p]
};

// `linearization` [r x (p + n)], the parameters first. With n = 0 it is what it was.
Marginal Marginalize(Linearization linearization, Eigen::Index num_parameters);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_UNCERTAINTY_MARGINAL_H_
