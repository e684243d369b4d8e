// The orthonormal basis B that turns one block adjoint sweep into a small least-squares problem.
//
// An adjoint sweep gives B^T J, the gradients of s scalars b_i . e, never the whole Jacobian J [m x p] of the residual
// e [m]. With e in the span of B, for any choice of the other columns:
//   |B^T e| = |e|,   (B^T J)^T (B^T e) = J^T e,
// so the small problem has the cost and the gradient of the large one exactly; only its Gauss-Newton matrix J^T B B^T J
// is that of the subspace. The other columns are chosen to hold as much of the range of J as they can:
//   - the last Jacobian as far as it is known, J ~ B (B^T J), [m x p]: J changes slowly near the solution, and what its
//     basis held need not be found again;
//   - differences between recent rollouts of the same fit, which are J times small changes of the parameters;
//   - where there is no last Jacobian, smooth modes of the motion.
// A fit gets its first Jacobian from a forward sweep instead. On `datasets/drape.motion.bin` the modes hold 10 % of J
// in its worst direction there; from the second point on last Jacobian, e and two differences hold 73 to 99.99 %.
#ifndef CLOTHID_COSTS_ROWS_RESIDUAL_BASIS_H_
#define CLOTHID_COSTS_ROWS_RESIDUAL_BASIS_H_

#include <Eigen/Core>

#include "datasets/observation/observation.h"
#include "datasets/observation/residual_derivative.h"

namespace clothid {

// Equal spans of the recording that modes are cut into.
inline constexpr int kNumTimeWindows = 4;
inline constexpr int kNumDisplacementModes = 3 * kNumTimeWindows;

// [m x kNumDisplacementModes]: the whitened residual of moving every seen point by 1 m along one axis during one of
// four equal spans of the recording: to first order the cloth moves there, nodes and all. Forces likewise, by 1 N.
Eigen::MatrixXd DisplacementModes(const Observation& observation, const ResidualDerivative& derivative);

// An orthonormal basis [m x r], r <= s, of the span of `vectors` [m x s], whose column j is in the span of the first
// vectors. A vector that depends on those before it, or is zero or not finite, is left out. Column 0 is the first
// vector, normalised, where that is not zero. Classical Gram-Schmidt with one repetition: orthonormal to rounding at
// any condition. It takes the memory of `vectors`, no more: in a large recording a column has a hundred megabytes.
Eigen::MatrixXd OrthonormalBasis(Eigen::MatrixXd vectors);

}  // namespace clothid

#endif  // CLOTHID_COSTS_ROWS_RESIDUAL_BASIS_H_
