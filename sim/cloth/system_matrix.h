// P = M + h C + h^2 (k L + k_b Q + Q_s) + h eta L, the constant matrix of projective dynamics (DiffCloth paper, section
// 3).
//
// M with the added mass; drag by direction has no part in P. L_ij = sum over triangles of a g_i . g_j, Q as in
// bending_energy.h, Q_s as in seam_energy.h. P is the same for the three axes, so it is one scalar matrix over the free
// nodes that is factored once for a whole rollout.
#ifndef CLOTHID_SIM_CLOTH_SYSTEM_MATRIX_H_
#define CLOTHID_SIM_CLOTH_SYSTEM_MATRIX_H_

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <memory>

#include "sim/cloth/cloth_model.h"
#include "sim/scene/parameters.h"

namespace clothid {

// P [Nf x Nf], kg, both triangles stored.
Eigen::SparseMatrix<double> AssembleSystemMatrix(const ClothModel& model, const Material& material, double time_step);

// d_j = P_jj of node `node`, kg.
double SystemDiagonal(const ClothModel& model, const Material& material, double time_step, int node);

// The Cholesky factor of P: positive definite, as masses are positive.
class SystemMatrixFactor {
 public:
  SystemMatrixFactor(const ClothModel& model, const Material& material, double time_step);
  ~SystemMatrixFactor();
  SystemMatrixFactor(const SystemMatrixFactor&) = delete;
  SystemMatrixFactor& operator=(const SystemMatrixFactor&) = delete;

  double time_step() const { return time_step_; }

  // (P kron I3)^-1 right, [3 Nf x s].
  Eigen::MatrixXd Solve(const Eigen::MatrixXd& right) const;

 private:
  struct State;
  double time_step_;
  std::unique_ptr<State> state_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_CLOTH_SYSTEM_MATRIX_H_
