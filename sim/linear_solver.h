// Sparse factorisations behind a small face: analyse a pattern once, factor values, solve, solve again.
#ifndef CLOTHID_SIM_LINEAR_SOLVER_H_
#define CLOTHID_SIM_LINEAR_SOLVER_H_

#include <Eigen/Core>
#include <functional>
#include <memory>

#include "sim/block_matrix.h"

namespace clothid {

// Supernodal Cholesky (CHOLMOD, nested dissection by METIS) of a symmetric matrix, which is also a test of its inertia.
class CholeskyFactor {
 public:
  explicit CholeskyFactor(std::shared_ptr<const BlockPattern> pattern);
  ~CholeskyFactor();
  CholeskyFactor(const CholeskyFactor&) = delete;
  CholeskyFactor& operator=(const CholeskyFactor&) = delete;

  // `values` [pattern.num_values()]; false where the matrix is not positive definite.
  bool Factor(const Eigen::VectorXd& values);
  // After a Factor that returned true. `right` [n x s].
  void Solve(const Eigen::MatrixXd& right, Eigen::MatrixXd* solution);

 private:
  struct State;
  std::unique_ptr<State> state_;
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

}  // namespace clothid

#endif  // CLOTHID_SIM_LINEAR_SOLVER_H_
