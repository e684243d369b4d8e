// Orthotropic stretch energy of a triangulated cloth, that of St. Venant and Kirchhoff, and its derivatives.
//
// Per triangle with rest area a and shape gradients g_i in axes along warp and weft: F = sum x_i g_i^T [3 x 2], the
// Green strain e = (F^T F - I)/2 and
//   E = a/2 (C_11 e_11^2 + C_22 e_22^2 + 2 C_12 e_11 e_22 + C_66 (2 e_12)^2)
// with the second Piola stress S = dE/de/a: S_11 = C_11 e_11 + C_12 e_22, S_22 = C_12 e_11 + C_22 e_22, S_12 = 2 C_66
// e_12, and the force -a F S g_i on node i. E is a polynomial in x, linear in every constant, and does not see
// rotations.
//
// An isotropic membrane with Young's modulus times thickness Y and Poisson's ratio nu has C_11 = C_22 = Y/(1 - nu^2),
// C_12 = nu C_11, C_66 = Y/(2 (1 + nu)). In uniaxial tension a strain of e, relative to the rest length, takes the
// force Y e (1 + e)(1 + e/2) per width. In compression the force has its maximum at a length of 1/sqrt(3) and is 0
// where the triangle is flat: the energy does not keep triangles from turning inside out.
#ifndef CLOTHID_SIM_SHELL_ORTHOTROPIC_ENERGY_H_
#define CLOTHID_SIM_SHELL_ORTHOTROPIC_ENERGY_H_

#include <Eigen/Core>
#include <memory>
#include <utility>

#include "sim/shell/triangle_element.h"

namespace clothid {

// N/m. The energy is positive where C_11, C_22, C_66 > 0 and C_12^2 < C_11 C_22.
struct OrthotropicConstants {
  double c11 = 0.0, c22 = 0.0;  // along warp and weft
  double c12 = 0.0;             // couples the two
  double c66 = 0.0;             // of shear

  // The largest eigenvalue of the constants: E <= a/2 times it times |e|^2.
  double Largest() const;
};

class OrthotropicEnergy {
 public:
  // The shape gradients of `triangles` must be in axes along warp and weft.
  explicit OrthotropicEnergy(std::shared_ptr<const TriangleElements> triangles) : triangles_(std::move(triangles)) {}

  // Adds -dE/dx to `force` [3N] and returns E for positions [3N], J.
  double AddForce(const OrthotropicConstants& constants, const Eigen::VectorXd& positions,
                  Eigen::VectorXd* force) const;

  // Adds d2E/dx2 below the diagonal of `hessian`, for `BlockMatrix::CompleteFromLower`. Clamped: the negative
  // eigenvalues of S to zero.
  void AddHessian(const OrthotropicConstants& constants, HessianKind kind, const Eigen::VectorXd& positions,
                  BlockMatrix* hessian, ThreadTeam* team = nullptr) const;

  // Adds -dE_f/dx . y of every triangle f to `products` [F x s], for columns y [3N x s].
  void AddForceProducts(const OrthotropicConstants& constants, const Eigen::VectorXd& positions,
                        const Eigen::MatrixXd& columns, Eigen::Ref<Eigen::MatrixXd> products) const;

 private:
  std::shared_ptr<const TriangleElements> triangles_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_SHELL_ORTHOTROPIC_ENERGY_H_
