// The energy of a woven or knitted membrane that stiffens along its yarns, and its derivatives.
//
// Per triangle with rest area a and shape gradients g_i in axes along warp and weft: F = [f_1 f_2] = sum x_i g_i^T, the
// engineering strains e_k = |f_k| - 1 along the yarns, the cosine gamma = f_1 . f_2/(|f_1| |f_2|) between them, and
//   E = a (k_1 psi_1(e_1) + k_2 psi_2(e_2) + k_12 e_1 e_2 + k_s/2 gamma^2)
//   psi_k'(e) = (exp(b_k e) - 1)/b_k in tension, e in compression; psi_k(0) = 0
// k_1 and k_2 are stiffnesses at zero strain; the slope of a curve of force over strain doubles with every ln(2)/b of
// strain, b the stiffening. psi is twice continuously differentiable and convex, so that E is, along each yarn; b = 0
// is Hooke's law. E does not see rotations. In uniaxial tension the force per rest width is dE/de/a, 1 N/m over any
// width.
#ifndef CLOTHID_SIM_SHELL_YARN_ENERGY_H_
#define CLOTHID_SIM_SHELL_YARN_ENERGY_H_

#include <Eigen/Core>
#include <memory>
#include <utility>

#include "sim/shell/orthotropic_energy.h"
#include "sim/shell/triangle_element.h"

namespace clothid {

// The energy is bounded from below where k_1, k_2, k_s > 0 and k_12^2 < k_1 k_2.
struct YarnConstants {
  OrthotropicConstants k;             // k_1, k_2, k_12 and k_s at zero strain, N/m
  double stiffening[2] = {0.0, 0.0};  // b_1, b_2 >= 0
};

class YarnEnergy {
 public:
  // The shape gradients of `triangles` must be in axes along warp and weft.
  explicit YarnEnergy(std::shared_ptr<const TriangleElements> triangles) : triangles_(std::move(triangles)) {}

  // Adds -dE/dx to `force` [3N] and returns E for positions [3N], J.
  double AddForce(const YarnConstants& constants, const Eigen::VectorXd& positions, Eigen::VectorXd* force) const;

  // Adds factor * (-d2E/(dx db)) to `force` [3N], b the stiffening along the warp, 0, or the weft, 1.
  void AddStiffeningDerivative(int yarn, double factor, const YarnConstants& constants,
                               const Eigen::VectorXd& positions, Eigen::VectorXd* force) const;

  // Adds factor * d2E/dx2 below the diagonal of `hessian`, for `BlockMatrix::CompleteFromLower`. Clamped: what a yarn
  // in compression has across itself is left out, and of the shear what changes its direction.
  void AddHessian(double factor, const YarnConstants& constants, HessianKind kind, const Eigen::VectorXd& positions,
                  BlockMatrix* hessian, ThreadTeam* team = nullptr) const;

  // Adds -dE_f/dx . y of every triangle f to `products` [F x s], for columns y [3N x s].
  void AddForceProducts(const YarnConstants& constants, const Eigen::VectorXd& positions,
                        const Eigen::MatrixXd& columns, Eigen::Ref<Eigen::MatrixXd> products) const;

  // The largest psi'' of a yarn, at least 1: how many times its stiffness has grown.
  double StiffnessGrowth(const YarnConstants& constants, const Eigen::VectorXd& positions) const;

 private:
  std::shared_ptr<const TriangleElements> triangles_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_SHELL_YARN_ENERGY_H_
