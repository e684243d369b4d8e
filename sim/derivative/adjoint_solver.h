// The linear systems A^T z = w of a reverse sweep, by any of its methods, with what that took.
#ifndef CLOTHID_SIM_DERIVATIVE_ADJOINT_SOLVER_H_
#define CLOTHID_SIM_DERIVATIVE_ADJOINT_SOLVER_H_

#include <Eigen/Core>
#include <memory>

#include "sim/cloth/system_matrix.h"
#include "sim/derivative/adjoint_options.h"
#include "sim/derivative/step_derivative.h"
#include "sim/rollout/rollout.h"

namespace clothid {

// For one sweep. Borrows the simulator's matrices.
class AdjointSolver {
 public:
  // `parameters` and `simulator` must outlive the object.
  AdjointSolver(const AdjointOptions& options, const Parameters& parameters, Simulator* simulator);
  AdjointSolver(const AdjointSolver&) = delete;
  AdjointSolver& operator=(const AdjointSolver&) = delete;

  // z and y = (I + S)^T z of A^T z = `right` [3 Nf x s] at the step that `record` ends and `step` is the derivative of.
  // Adds to `work` all but the seconds that the simulator counts. Throws `std::runtime_error` where A is singular.
  void Solve(const StepRecord& record, const Eigen::MatrixXd& right, StepDerivative* step, Eigen::MatrixXd* z,
             Eigen::MatrixXd* y, AdjointWork* work);

  // The same where the cloth touches itself, with rho of its pairs [3c x s]. `by_impulse` and `by_pairs` (may be
  // empty): gradients by the impulses of obstacles and pairs. Throws `Error` (kUsage) for a method other than
  // kReduced.
  void SolveWithPairs(const StepRecord& record, const Eigen::MatrixXd& right, const Eigen::MatrixXd& by_impulse,
                      const Eigen::MatrixXd& by_pairs, const StepDerivative& step, Eigen::MatrixXd* z,
                      Eigen::MatrixXd* y, Eigen::MatrixXd* rho, AdjointWork* work);

 private:
  bool SolveByMethod(const StepRecord& record, const Eigen::MatrixXd& right, StepDerivative* step, Eigen::MatrixXd* z,
                     Eigen::MatrixXd* y, AdjointWork* work);
  bool SolveByStepJacobian(StepJacobian::Method method, const Eigen::MatrixXd& right, StepDerivative* step,
                           Eigen::MatrixXd* z, Eigen::MatrixXd* y, AdjointWork* work);
  bool SolveByKeptFactor(const StepRecord& record, const Eigen::MatrixXd& right, StepDerivative* step,
                         Eigen::MatrixXd* z, Eigen::MatrixXd* y, AdjointWork* work);
  bool SolveByIteration(const StepRecord& record, const StepDerivative& step, const Eigen::MatrixXd& right,
                        Eigen::MatrixXd* z, Eigen::MatrixXd* y, AdjointWork* work);
  const SystemMatrixFactor& SystemMatrixOf(double time_step);

  AdjointMethod method_;
  bool use_kept_factors_;
  double threshold_;
  const Parameters& parameters_;
  Simulator* simulator_;
  PairJacobian pair_jacobian_;
  std::unique_ptr<SystemMatrixFactor> system_matrix_;  // of the last step size; made when first asked for
};

}  // namespace clothid

#endif  // CLOTHID_SIM_DERIVATIVE_ADJOINT_SOLVER_H_
