// The orthonormal basis B that turns one block adjoint sweep into a small least-squares problem.
//
// An adjoint sweep gives B^T J, the gradients of s scalars b_i . e, never the whole Jacobian J [m x p] of the residual
// e [m]. With e in the span of B, for any choice of the other columns:
//   |B^T e| = |e|,   (B^T J)^T (B^T e) = J^T e,
// so the small problem has the cost and the gradient of the large one exactly; only its Gauss-Newton matrix J^T B B^T J
// is that of the subspace. The other columns are chosen to hold as much of the range of J as they can: smooth modes of
// the motion, and differences between recent rollouts of the same fit, which span the range of J near the solution.
#ifndef CLOTHID_COSTS_RESIDUAL_BASIS_H_
#define CLOTHID_COSTS_RESIDUAL_BASIS_H_

#include <Eigen/Core>

#include "datasets/observation.h"

namespace clothid {

// Equal spans of the recording that modes are cut into.
inline constexpr int kNumTimeWindows = 4;
inline constexpr int kNumDisplacementModes = 3 * kNumTimeWindows;
inline constexpr int kNumResidualModes = kNumTimeWindows - 1;

// [m x kNumDisplacementModes]: the whitened residual of moving every seen point by 1 m along one axis during one of
// four equal spans of the recording.
Eigen::MatrixXd DisplacementModes(const Observation& observation);

// [m x kNumResidualModes]: the residual [m] in one time window, zero elsewhere. Far from the solution e is roughly J
// times the way to go, and so are its parts, window by window; the last window is e less the others.
Eigen::MatrixXd ResidualModes(const Observation& observation, const Eigen::VectorXd& residuals);

// An orthonormal basis [m x r], r <= s, of the span of `vectors` [m x s], whose column j is in the span of the first
// vectors. A vector that depends on those before it, or is zero or not finite, is left out. Column 0 is the first
// vector, normalised, where that is not zero. Classical Gram-Schmidt with one repetition: orthonormal to rounding at
// any condition.
Eigen::MatrixXd OrthonormalBasis(const Eigen::MatrixXd& vectors);

}  // namespace clothid

#endif  // CLOTHID_COSTS_RESIDUAL_BASIS_H_
