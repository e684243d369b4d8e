// ARAP stretch energy of a triangulated cloth and its derivatives.
//
// Per triangle with rest area a and shape gradients g_i (in its rest plane): F = sum x_i g_i^T [3 x 2] and
//   E = k/2 a |F - R|^2,   R the polar factor of F (PD's stretch term in the DiffCloth paper; see sim/README.md).
// With C = F^T F, s = sqrt(det C), tau = sqrt(tr C + 2 s), S = (C + s I)/tau: F = R S, tr S = tau, so no SVD is needed.
#ifndef CLOTHID_SIM_SHELL_STRETCH_ENERGY_H_
#define CLOTHID_SIM_SHELL_STRETCH_ENERGY_H_

#include <Eigen/Core>
#include <memory>
#include <utility>

#include "sim/shell/triangle_element.h"

namespace clothid {

class StretchEnergy {
 public:
  explicit StretchEnergy(std::shared_ptr<const TriangleElements> triangles) : triangles_(std::move(triangles)) {}

  // Adds stiffness * (-d(E/k)/dx) to `force` [3N] and returns E/k for positions [3N], m^2.
  double AddForce(double stiffness, const Eigen::VectorXd& positions, Eigen::VectorXd* force) const;

  // Adds stiffness * d2(E/k)/dx2 below the diagonal of `hessian`, for `BlockMatrix::CompleteFromLower`. Clamped: 1/tau
  // to at most 1/2, the eigenvalues of S^-1 to at most 1.
  void AddHessian(double stiffness, HessianKind kind, const Eigen::VectorXd& positions, BlockMatrix* hessian,
                  ThreadTeam* team = nullptr) const;

  // Adds stiffness * (-d(E_f/k)/dx) . y of every triangle f to `products` [F x s], for columns y [3N x s].
  void AddForceProducts(double stiffness, const Eigen::VectorXd& positions, const Eigen::MatrixXd& columns,
                        Eigen::Ref<Eigen::MatrixXd> products) const;

 private:
  std::shared_ptr<const TriangleElements> triangles_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_SHELL_STRETCH_ENERGY_H_
