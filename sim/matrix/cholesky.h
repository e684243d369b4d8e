// Sparse Cholesky factorisation A = L L^T: analyse a pattern once, factor values, solve, solve again.
//
// Any number of threads may make factors with one solver and solve with one factor at once, and none waits for another.
// The numbers depend neither on the threads nor on the machine.
#ifndef CLOTHID_SIM_MATRIX_CHOLESKY_H_
#define CLOTHID_SIM_MATRIX_CHOLESKY_H_

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <vector>

#include "sim/base/thread_team.h"
#include "sim/matrix/block_matrix.h"

namespace clothid {

// A numeric factor L L^T, made by a CholeskySolver, whose analysis it shares.
class CholeskyFactor {
 public:
  ~CholeskyFactor();
  CholeskyFactor(const CholeskyFactor&) = delete;
  CholeskyFactor& operator=(const CholeskyFactor&) = delete;

  // `right` [n x s], solved together, which takes far less time than one after the other. How many there are does not
  // change the numbers of one, except that one alone is rounded differently. `solution` may be `right`. `team` (may be
  // null) shares the work of a large factor.
  void Solve(const Eigen::MatrixXd& right, Eigen::MatrixXd* solution, ThreadTeam* team = nullptr) const;

  std::size_t bytes() const;  // of the numeric values

 private:
  friend class CholeskySolver;
  friend class SinglePrecisionFactor;
  struct Numeric;
  explicit CholeskyFactor(std::unique_ptr<Numeric> numeric);
  std::unique_ptr<Numeric> numeric_;
};

// A copy of a factor in single precision: half the memory to read, which is what a solve with a large factor waits for,
// and an error of 1e-7 times the condition of the matrix. Good enough as a preconditioner.
class SinglePrecisionFactor {
 public:
  // Copies `factor` unless it is the one that was copied last. Null: holds none from now on.
  void Set(std::shared_ptr<const CholeskyFactor> factor, ThreadTeam* team = nullptr);
  // As CholeskyFactor::Solve.
  void Solve(const Eigen::MatrixXd& right, Eigen::MatrixXd* solution, ThreadTeam* team = nullptr) const;

 private:
  std::shared_ptr<const CholeskyFactor> factor_;
  std::vector<float> values_;
};

// Supernodal Cholesky of symmetric matrices with one pattern, analysed once by CHOLMOD, in the order in which the
// pattern comes (see fill_reducing_order.h). Factorising is also a test of the matrix' inertia. The memory of factors
// that are gone is used again.
class CholeskySolver {
 public:
  // Throws `std::runtime_error`, which names CHOLMOD's routine, where the analysis runs out of memory.
  explicit CholeskySolver(std::shared_ptr<const BlockPattern> pattern);
  ~CholeskySolver();
  CholeskySolver(const CholeskySolver&) = delete;
  CholeskySolver& operator=(const CholeskySolver&) = delete;

  // `values` [pattern.num_values()], of which the lower triangle is read; null where the matrix is not positive
  // definite. Team as CholeskyFactor::Solve.
  std::shared_ptr<const CholeskyFactor> Factor(const Eigen::VectorXd& values, ThreadTeam* team = nullptr);

  // Of one factorisation, without the zeros that supernodes add: operations (an addition and a multiplication are two)
  // and entries of L.
  double num_flops() const;
  double num_entries() const;
  // Whether a team shares the work of its factors: whether they are large.
  bool has_branches() const;

 private:
  friend class CholeskyFactor;
  struct State;
  std::shared_ptr<State> state_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_MATRIX_CHOLESKY_H_
