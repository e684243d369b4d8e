// Sweeps over the nodes in contact that correct a direction of Newton's method: nonlinear Gauss-Seidel (M. Jean 1999),
// here between the linear solves, as in truncated nonsmooth Newton methods (C. Graeser, O. Sander 2019).
//
// Newton's method takes every node to stay on its branch: to stick, to slip along one line, or to leave. Where a node
// ends on another one, the next iteration finds it there, and the one after that back again. Where the branches of
// neighbours hang together, that goes on for a dozen iterations. A sweep takes node after node and solves its own
// equation in the quadratic model of the momentum balance,
//   g(v + dv) = g + K dv,   g_i = r_i(F_i),  F_i = d_i (v_i - V_i) - g_i + (d_i gap_speed) n
// for its velocity alone, with the contact law as it is. That takes blocks of K and no linear solve. Nodes whose
// residual is below their share of what the linear solve has left are passed by.
#ifndef CLOTHID_SIM_STEP_CONTACT_SWEEPS_H_
#define CLOTHID_SIM_STEP_CONTACT_SWEEPS_H_

#include <Eigen/Core>
#include <vector>

#include "sim/matrix/block_matrix.h"
#include "sim/step/step_problem.h"

namespace clothid {

class ContactSweeps {
 public:
  // `direction` [3 Nf]: from `point`, with K in `hessian`, solved to the relative residual `tolerance`. Changes it at
  // the nodes that are in contact at `point` or at its end in the model. False, and `direction` as it was, where their
  // equations hold to what the linear solve has left anyway. `other_impulse` [3 Nf] (may be null): what the impulses of
  // pairs of the cloth with itself gain along it, which takes as much off g.
  bool Correct(const StepProblem& problem, const BlockMatrix& hessian, const StepPoint& point, double tolerance,
               Eigen::VectorXd* direction, const Eigen::VectorXd* other_impulse = nullptr);

 private:
  // The candidates to sweep over, the model at the end of `direction`, and the size of their residual there.
  double Start(const StepProblem& problem, const BlockMatrix& hessian, const StepPoint& point,
               const Eigen::VectorXd& direction, const Eigen::VectorXd* other_impulse);
  // Adds K's column of `block` times `change` to the momentum balance.
  void Move(const BlockMatrix& hessian, int block, const Eigen::Vector3d& change);

  std::vector<int> candidates_;
  Eigen::VectorXd velocities_;  // v + dv
  Eigen::MatrixXd momentum_;    // g + K dv, one column
};

}  // namespace clothid

#endif  // CLOTHID_SIM_STEP_CONTACT_SWEEPS_H_
