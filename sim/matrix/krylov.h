// Iterative solution of A x = b, of which only the products with A and with P^-1 are needed, P near A.
#ifndef CLOTHID_SIM_MATRIX_KRYLOV_H_
#define CLOTHID_SIM_MATRIX_KRYLOV_H_

#include <Eigen/Core>
#include <functional>

namespace clothid {

using LinearMap = std::function<Eigen::MatrixXd(const Eigen::MatrixXd&)>;

struct IterationLimit {
  int most;
  // Ends after six iterations or more where the mean reduction so far would not reach the tolerance in `most`: for whom
  // there is another way than to wait.
  bool gives_up = false;
};

struct GmresResult {
  bool converged = false;  // every column
  int iterations = 0;      // of the slowest column
};

// Right-preconditioned GMRES (Saad and Schultz 1986) from x = 0, without restart: A P^-1 u = b, x = P^-1 u, until
// |b - A x| <= tolerance |b|, for the columns of `right` [n x s] side by side: each has its own Krylov space, and the
// products are taken with all of them at once. `precondition` applies P^-1.
GmresResult Gmres(const LinearMap& multiply, const LinearMap& precondition, const Eigen::MatrixXd& right,
                  double tolerance, const IterationLimit& limit, Eigen::MatrixXd* solution);

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

#endif  // CLOTHID_SIM_MATRIX_KRYLOV_H_
