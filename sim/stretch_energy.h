// ARAP stretch energy of a triangulated cloth and its derivatives.
//
// Per triangle with rest area a and shape gradients g_i (in its rest plane): F = sum x_i g_i^T [3 x 2] and
//   E = k/2 a |F - R|^2,   R the polar factor of F (design: section 3; PD's stretch term in the DiffCloth paper).
// With C = F^T F, s = sqrt(det C), tau = sqrt(tr C + 2 s), S = (C + s I)/tau: F = R S, tr S = tau, so no SVD is needed.
#ifndef CLOTHID_SIM_STRETCH_ENERGY_H_
#define CLOTHID_SIM_STRETCH_ENERGY_H_

#include <Eigen/Core>
#include <vector>

#include "sim/block_matrix.h"
#include "sim/mesh.h"

namespace clothid {

enum class HessianKind {
  kExact,    // the second derivative; indefinite in compression
  kClamped,  // 1/tau clamped to 1/2 and the eigenvalues of S^-1 to 1: positive semidefinite, for directions only
};

class StretchEnergy {
 public:
  // `pattern` is the pattern of the Hessian over the free nodes, `free_index` [N] maps nodes to it (-1: a handle).
  StretchEnergy(const Mesh& mesh, const std::vector<int>& free_index, const BlockPattern& pattern);

  // E/k for positions [3N], m^2.
  double Energy(const Eigen::VectorXd& positions) const;

  // Adds stiffness * (-d(E/k)/dx) to `force` [3N] and returns E/k.
  double AddForce(double stiffness, const Eigen::VectorXd& positions, Eigen::VectorXd* force) const;

  // Adds stiffness * d2(E/k)/dx2 to `hessian`.
  void AddHessian(double stiffness, HessianKind kind, const Eigen::VectorXd& positions, BlockMatrix* hessian) const;

  // Diagonal of the constant PD matrix L, L_ij = sum a g_i . g_j [N], 1.
  Eigen::VectorXd LaplacianDiagonal() const;

 private:
  struct Triangle {
    int nodes[3];
    double area;                                  // m^2
    Eigen::Matrix<double, 2, 3> shape_gradients;  // column i: g_i, 1/m
    BlockPosition blocks[3][3];                   // of (i, j), invalid where one of them is a handle
  };
  using Gradient = Eigen::Matrix<double, 3, 2>;  // F

  static Gradient DeformationGradient(const Triangle& triangle, const Eigen::VectorXd& positions);

  std::vector<Triangle> triangles_;
  int num_nodes_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_STRETCH_ENERGY_H_
