// Internal damping of a cloth: a viscous stress proportional to the rate of strain, and its derivatives.
//
// Per triangle with rest area a, shape gradients g_i and F = sum x_i g_i^T, the metric C = F^T F (the Green strain is
// (C - I)/2). Over a step of size h from x_n to x:
//   Edot = (C(x) - C(x_n))/(2 h),   second Piola stress eta Edot,
//   W = h eta/2 a |Edot|^2 = eta a/(8 h) |C(x) - C(x_n)|^2,   force on node i: -dW/dx_i = -eta a F Edot g_i
// W is the dissipation potential of the step. C sees neither rotation nor translation, so a rigid motion from x_n to x
// of any size is not damped at all. In small strains the force is eta/k times the rate of the stretch force:
// Kelvin-Voigt damping with the relaxation time eta/k.
#ifndef CLOTHID_SIM_SHELL_STRAIN_RATE_DAMPING_H_
#define CLOTHID_SIM_SHELL_STRAIN_RATE_DAMPING_H_

#include <Eigen/Core>
#include <memory>
#include <utility>
#include <vector>

#include "sim/shell/triangle_element.h"

namespace clothid {

// C of a batch of triangles: C_00, C_01, C_11.
struct alignas(64) MetricBatch {
  double values[3][kLanes];
};

// Positions [3N] from whose C a strain rate is taken, with others: C_o = sum of share C, the shares of a sum 1.
struct StrainOrigin {
  const Eigen::VectorXd* positions;
  double share;
};

class StrainRateDamping {
 public:
  explicit StrainRateDamping(std::shared_ptr<const TriangleElements> triangles) : triangles_(std::move(triangles)) {}

  // C_o of every triangle: of one origin x_n alone C(x_n), what the functions below take as `start_metrics`.
  void SetMetrics(const std::vector<StrainOrigin>& origins, std::vector<MetricBatch>* metrics) const;

  // Adds damping * (-d(W/eta)/dx) to `force` [3N] and returns W/eta, m^2/s.
  double AddForce(double damping, double time_step, const std::vector<MetricBatch>& start_metrics,
                  const Eigen::VectorXd& positions, Eigen::VectorXd* force) const;

  // Adds damping * d2(W/eta)/dx2 below the diagonal of `hessian`, for `BlockMatrix::CompleteFromLower`. Clamped: the
  // negative eigenvalues of Edot to zero.
  void AddHessian(double damping, double time_step, HessianKind kind, const std::vector<MetricBatch>& start_metrics,
                  const Eigen::VectorXd& positions, BlockMatrix* hessian, ThreadTeam* team = nullptr) const;

  // Adds damping * d2(W/eta)/(dx dx_n) y to `product`, for columns y [3N x s]. Exchanging x and x_n transposes the
  // matrix.
  void AddMixedProduct(double damping, double time_step, const Eigen::VectorXd& positions,
                       const Eigen::VectorXd& start_positions, const Eigen::MatrixXd& columns,
                       Eigen::MatrixXd* product) const;

 private:
  std::shared_ptr<const TriangleElements> triangles_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_SHELL_STRAIN_RATE_DAMPING_H_
