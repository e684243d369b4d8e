// A^T z = w of one step by iterations on the prefactored P, as in section 5.4 of the DiffCloth paper.
//
// A = P - dP - dR, so that Eq. (29) reads  P z <- (dP + dR)^T z + w,  that is  z <- z + P^-1 (w - A^T z).
//
// These iterations want d = M in the contact law: with d_j = P_jj the fixed point diverges where every node touches.
// The step, y and s = D S^T z do not depend on d, and neither does the residual w - K y + s; only z does. So
//   S = S(d = M) from the same contacts, with f_T = f_T(d_j) + (m - d_j) u_T
//   A^T z = K y - M (y - z),   y = (I + S)^T z
//   z for d_j = y - (m/d_j)(y - z)
#ifndef CLOTHID_SIM_DERIVATIVE_ADJOINT_ITERATION_H_
#define CLOTHID_SIM_DERIVATIVE_ADJOINT_ITERATION_H_

#include <Eigen/Core>
#include <vector>

#include "sim/cloth/cloth_model.h"
#include "sim/matrix/block_matrix.h"
#include "sim/matrix/krylov.h"
#include "sim/rollout/rollout.h"

namespace clothid {

// A^T of a step, with d = M.
class AdjointSystem {
 public:
  // `hessian` is K at the end of the step and must outlive the object.
  AdjointSystem(const ClothModel& model, const std::vector<Contact>& contacts, const Eigen::VectorXd& velocities,
                const Parameters& parameters, const BlockMatrix& hessian);

  // A^T z, [3 Nf x s].
  Eigen::MatrixXd Multiply(const Eigen::MatrixXd& z) const;

  // Makes `z` the one that belongs to the record's own d and gives y, which is the same for all d.
  void Finish(Eigen::MatrixXd* z, Eigen::MatrixXd* y) const;

 private:
  struct Node {
    int row;                             // of its block
    Eigen::Matrix3d impulse_transposed;  // S^T
    double mass;                         // m, kg
    double weight;                       // d of the record, kg
  };
  Eigen::MatrixXd AddImpulseTransposed(const Eigen::MatrixXd& z) const;

  const BlockMatrix& hessian_;
  std::vector<Node> nodes_;
};

struct IterationResult {
  bool converged = false;
  int iterations = 0;  // of the slowest column
};

// x <- x + P^-1 (right - A x) from x = 0, until |right - A x| <= tolerance |right| in every column. `precondition`
// applies P^-1. Not converged: after `max_iterations`, or where it diverges.
IterationResult IterateFixedPoint(const LinearMap& multiply, const LinearMap& precondition,
                                  const Eigen::MatrixXd& right, double tolerance, int max_iterations,
                                  Eigen::MatrixXd* solution);

}  // namespace clothid

#endif  // CLOTHID_SIM_DERIVATIVE_ADJOINT_ITERATION_H_
