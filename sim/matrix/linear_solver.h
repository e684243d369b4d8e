// Sparse factorisations behind a small face: analyse a pattern once, factor values, solve, solve again.
#ifndef CLOTHID_SIM_MATRIX_LINEAR_SOLVER_H_
#define CLOTHID_SIM_MATRIX_LINEAR_SOLVER_H_

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

#include "sim/matrix/block_matrix.h"

namespace clothid {

// The order in which to number the nodes of a graph so that a Cholesky factor of a matrix on it fills in little: nested
// dissection (METIS), postordered. Element k is the node that comes k-th. `neighbours`: as of BlockPattern.
std::vector<int> FillReducingOrder(const std::vector<std::vector<int>>& neighbours);

// A numeric factor L L^T, made by a CholeskySolver, whose analysis and work space it shares: for one thread at a time.
class CholeskyFactor {
 public:
  ~CholeskyFactor();
  CholeskyFactor(const CholeskyFactor&) = delete;
  CholeskyFactor& operator=(const CholeskyFactor&) = delete;

  // `right` [n x s], solved together.
  void Solve(const Eigen::MatrixXd& right, Eigen::MatrixXd* solution) const;

  std::size_t bytes() const;  // of the numeric values

 private:
  friend class CholeskySolver;
  struct Numeric;
  explicit CholeskyFactor(std::unique_ptr<Numeric> numeric);
  std::unique_ptr<Numeric> numeric_;
};

// Supernodal Cholesky (CHOLMOD) of symmetric matrices with one pattern, analysed once, in the order in which the
// pattern comes (see FillReducingOrder). Factorising is also a test of the matrix' inertia. The memory of factors that
// are gone is used again.
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

// Sparse LU (UMFPACK) of a matrix with the pattern of `pattern` and any values.
class LuFactor {
 public:
  explicit LuFactor(std::shared_ptr<const BlockPattern> pattern);
  ~LuFactor();
  LuFactor(const LuFactor&) = delete;
  LuFactor& operator=(const LuFactor&) = delete;

  // `values` by columns; false where the matrix is singular.
  bool Factor(const Eigen::VectorXd& values);
  void Solve(const Eigen::MatrixXd& right, Eigen::MatrixXd* solution) const;            // A x = b
  void SolveTransposed(const Eigen::MatrixXd& right, Eigen::MatrixXd* solution) const;  // A^T x = b

 private:
  struct State;
  std::unique_ptr<State> state_;
};

using LinearMap = std::function<Eigen::MatrixXd(const Eigen::MatrixXd&)>;

struct GmresResult {
  bool converged = false;  // every column
  int iterations = 0;      // of the slowest column
};

// Right-preconditioned GMRES (Saad and Schultz 1986) from x = 0, without restart: A P^-1 u = b, x = P^-1 u, until
// |b - A x| <= tolerance |b|, for the columns of `right` [n x s] side by side: each has its own Krylov space, and the
// products are taken with all of them at once. `precondition` applies P^-1.
GmresResult Gmres(const LinearMap& multiply, const LinearMap& precondition, const Eigen::MatrixXd& right,
                  double tolerance, int max_iterations, Eigen::MatrixXd* solution);

using VectorMap = std::function<Eigen::VectorXd(const Eigen::VectorXd&)>;

struct ConjugateGradientResult {
  bool converged = false;
  bool indefinite = false;  // a direction of no or negative curvature was met: the matrix is not positive definite
  int iterations = 0;
};

// Preconditioned conjugate gradients (Hestenes and Stiefel 1952) from x = 0 for a symmetric A and a symmetric positive
// definite P, until |b - A x| <= tolerance |b|. Ends at the first direction of negative curvature.
ConjugateGradientResult ConjugateGradients(const VectorMap& multiply, const VectorMap& precondition,
                                           const Eigen::VectorXd& right, double tolerance, int max_iterations,
                                           Eigen::VectorXd* solution);

}  // namespace clothid

#endif  // CLOTHID_SIM_MATRIX_LINEAR_SOLVER_H_
