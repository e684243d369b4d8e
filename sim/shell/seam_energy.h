// What draws seams together and holds buttons: the links of a mesh.
//
//   E = sum over links of k_s/2 |sum_i w_i x_i - c(t) d_0|^2,   c(t) = 1 - t/T within 0 and 1; 0 with T = 0
//
// over the node p and the ends q_0, q_1 of an edge, with w = (1, s - 1, -s). d_0 = sum_i w_i X_i m: the gap between the
// `rest_positions` X of the mesh, from which it starts unless its scene says otherwise. The Hessian Q kron I3,
// Q = sum k_s w w^T, is constant; its rows have the sum zero.
#ifndef CLOTHID_SIM_SHELL_SEAM_ENERGY_H_
#define CLOTHID_SIM_SHELL_SEAM_ENERGY_H_

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <array>
#include <utility>
#include <vector>

#include "sim/matrix/block_matrix.h"
#include "sim/mesh/mesh.h"
#include "sim/shell/bending_energy.h"

namespace clothid {

// Q [N x N], N/m, symmetric positive semidefinite, both triangles stored.
Eigen::SparseMatrix<double> SeamMatrix(const Mesh& mesh);

class SeamEnergy {
 public:
  struct Link {
    std::array<int, 3> nodes;
    std::array<double, 3> weights;  // w
    double stiffness, closing_time;
    Eigen::Vector3d offset;  // d_0
  };

  // `matrix` is that of `mesh`; `pattern`, the pattern of the Hessian over the free nodes, must cover it; `free_index`
  // [N] maps nodes to it (-1: a handle).
  SeamEnergy(const Mesh& mesh, Eigen::SparseMatrix<double> matrix, const std::vector<int>& free_index,
             const BlockPattern& pattern);
  // Likewise, of links.
  SeamEnergy(std::vector<Link> links, Eigen::SparseMatrix<double> matrix, const std::vector<int>& free_index,
             const BlockPattern& pattern)
      : links_(std::move(links)), quadratic_(std::move(matrix), free_index, pattern) {}

  const std::vector<Link>& links() const { return links_; }
  const Eigen::SparseMatrix<double>& matrix() const { return quadratic_.matrix(); }  // Q
  const Eigen::VectorXd& diagonal() const { return quadratic_.diagonal(); }          // of Q [N]

  // Adds -dE/dx to `force` [3N] and returns E, J, for positions [3N] at `time`, s on the scene's clock.
  double AddForce(double time, const Eigen::VectorXd& positions, Eigen::VectorXd* force) const;

  // dE/dt where positions stay, W: the power that draws seams. At t = T that before.
  double Power(double time, const Eigen::VectorXd& positions) const;

  // Adds factor * d2E/dx2 below the diagonal of `hessian`, for `BlockMatrix::CompleteFromLower`.
  void AddHessian(double factor, BlockMatrix* hessian) const { quadratic_.AddHessian(factor, hessian); }

 private:
  // sum_i w_i x_i - c(t) d_0.
  static Eigen::Vector3d Gap(const Link& link, double time, const Eigen::VectorXd& positions);

  std::vector<Link> links_;
  BendingEnergy quadratic_;  // x^T (Q kron I3) x/2, for its Hessian
};

}  // namespace clothid

#endif  // CLOTHID_SIM_SHELL_SEAM_ENERGY_H_
