// Nodes that contacts held where a factor was made and have let go since.
//
// The factor has nothing but diagonals for what was held: a sticking node, and the normal of a slipping one. With it
// alone as a preconditioner, each of those that has come free costs a linear solve about an iteration, and where cloth
// comes to slide one row of nodes after the other, every Newton iteration would want a factor of its own. So the
// reduced matrix A of the point is factored once more among F alone, the freed nodes and those beside them, which is
// cheap as long as they are few. With R_F the restriction to F, A0 the factor, of which freed directions get nothing,
// and S = R_F^T (R_F A R_F^T)^-1 R_F, the preconditioner is
//   S + (I - S A) A0^-1 (I - A S),
// symmetric and positive definite as A0 and A are: Schwarz's multiplicative method over two overlapping parts of the
// cloth, F first and last (Smith, Bjorstad and Gropp, Domain Decomposition, 1996, section 1.2).
#ifndef CLOTHID_SIM_STEP_FREED_NODES_H_
#define CLOTHID_SIM_STEP_FREED_NODES_H_

#include <Eigen/Core>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <vector>

#include "sim/contact/contact_elimination.h"
#include "sim/matrix/block_matrix.h"
#include "sim/matrix/krylov.h"

namespace clothid {

class FreedNodes {
 public:
  void Clear();
  // Those that `contacts` have let go since `held` was held; `hessian` is K at the point.
  void Find(const BlockMatrix& hessian, const ContactElimination& contacts, const HeldBlocks& held);

  bool empty() const { return freed_.empty(); }
  // So many that a new factor costs less than going on; `Apply` then takes them as if they were held.
  bool are_too_many() const { return are_too_many_; }

  // The preconditioner on [3 Nf x s]; `apply` is A0^-1.
  Eigen::MatrixXd Apply(const LinearMap& apply, const Eigen::MatrixXd& vectors) const;

 private:
  void RemoveFreed(Eigen::MatrixXd* vectors) const;

  std::vector<FreedBlock> freed_;
  std::vector<int> blocks_;                                   // F
  Eigen::SparseMatrix<double> columns_;                       // A R_F^T
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> factor_;  // of R_F A R_F^T
  bool are_too_many_ = false;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_STEP_FREED_NODES_H_
