// Sparse Cholesky factorisation A = L L^T: analyse a pattern once, factor values, solve, solve again.
#ifndef CLOTHID_SIM_MATRIX_CHOLESKY_H_
#define CLOTHID_SIM_MATRIX_CHOLESKY_H_

#include <Eigen/Core>
#include <cstddef>
#include <memory>

#include "sim/matrix/block_matrix.h"

namespace clothid {

// A numeric factor L L^T, made by a CholeskySolver, whose analysis and work space it shares: one thread at a time may
// solve with the factors of a solver or make another one. Any thread may destroy a factor at any time.
class CholeskyFactor {
 public:
  ~CholeskyFactor();
  CholeskyFactor(const CholeskyFactor&) = delete;
  CholeskyFactor& operator=(const CholeskyFactor&) = delete;

  // `right` [n x s], solved together. Throws as CholeskySolver does.
  void Solve(const Eigen::MatrixXd& right, Eigen::MatrixXd* solution) const;

  std::size_t bytes() const;  // of the numeric values

 private:
  friend class CholeskySolver;
  struct Numeric;
  explicit CholeskyFactor(std::unique_ptr<Numeric> numeric);
  std::unique_ptr<Numeric> numeric_;
};

// Supernodal Cholesky (CHOLMOD) of symmetric matrices with one pattern, analysed once, in the order in which the
// pattern comes (see fill_reducing_order.h). Factorising is also a test of the matrix' inertia. The memory of factors
// that are gone is used again. Throws `std::runtime_error`, which names CHOLMOD's routine, where it is out of memory.
class CholeskySolver {
 public:
  explicit CholeskySolver(std::shared_ptr<const BlockPattern> pattern);
  ~CholeskySolver();
  CholeskySolver(const CholeskySolver&) = delete;
  CholeskySolver& operator=(const CholeskySolver&) = delete;

  // `values` [pattern.num_values()]; null where the matrix is not positive definite.
  std::shared_ptr<const CholeskyFactor> Factor(const Eigen::VectorXd& values);

  // Of one factorisation, without the zeros that supernodes add: operations (an addition and a multiplication are two)
  // and entries of L.
  double num_flops() const;
  double num_entries() const;

 private:
  friend class CholeskyFactor;
  struct State;
  std::shared_ptr<State> state_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_MATRIX_CHOLESKY_H_
