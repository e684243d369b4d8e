// What a Gauss-Newton step does outside of a basis, by conjugate gradients.
#ifndef CLOTHID_IDENTIFY_FIT_KRYLOV_STEP_H_
#define CLOTHID_IDENTIFY_FIT_KRYLOV_STEP_H_

#include <Eigen/Core>

#include "identify/base/options.h"
#include "identify/problem/evaluator.h"
#include "identify/problem/problem.h"
#include "identify/problem/unknown_basis.h"

namespace clothid {

// The basis V and one more direction u, orthogonal to it, with H over both.
struct WidenedBasis {
  UnknownBasis basis;
  Eigen::MatrixXd hessian;  // [(p + c + 1) x (p + c + 1)], or, where there is no such direction, of V
};

// A step solves H d = -g over all unknowns, H = J^T J with all priors. A product with H is a forward sweep with one
// column and a reverse sweep, along the rollout that is at hand. The conjugate gradients are preconditioned by H over
// V, parameters included, and by the prior of the fields across:
//   M^-1 = V (V^T H V)^-1 V^T + Q^-1 - V_f (V_f^T Q V_f)^-1 V_f^T,   Q = weight R^T R, with a little more for the means
// so that the number of products is that of what the recordings tell beyond V, and hardly grows with that of the
// control nodes; directions that trade a parameter for a field, in which H is ill-conditioned, cost nothing. They end
// where a tenth of the gradient is left. What d has outside of V is u.
//
// `basis` V has some modes of every field; `hessian` H over it [(p + c) x (p + c)]; `gradient` g [p + n + f] at
// `unknowns`; parameters that are frozen or held stay. False where a sweep fails: see evaluator->last_failure().
bool WidenBasis(const FitOptions& options, const FitProblem& problem, const UnknownBasis& basis,
                const Eigen::MatrixXd& hessian, const Eigen::VectorXd& unknowns, const Eigen::VectorXd& gradient,
                Precision precision, FitEvaluator* evaluator, WidenedBasis* widened);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_FIT_KRYLOV_STEP_H_
