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

  // (z, rho) and y = (I + S)^T z of A^T (z, rho) = `right` at the step that `record` ends and `step` is the derivative
  // of. Adds to `work` all but the seconds that the simulator counts. Throws `std::runtime_error` where A is singular,
  // and `Error` (kUsage) where the cloth touches itself and the method is other than kReduced.
  void Solve(const StepRecord& record, const StepColumns& right, StepDerivative* step, StepColumns* z,
             Eigen::MatrixXd* y, AdjointWork* work);

 private:
  bool SolveByMethod(const StepRecord& record, const StepColumns& right, StepDerivative* step, StepColumns* z,
                     Eigen::MatrixXd* y, AdjointWork* work);
  // With the factor at hand.
  bool SolveByStepJacobian(const StepColumns& right, StepDerivative* step, StepColumns* z, Eigen::MatrixXd* y,
                           AdjointWork* work);
  bool SolveByIteration(const StepRecord& record, const StepDerivative& step, const Eigen::MatrixXd& right,
                        Eigen::MatrixXd* z, Eigen::MatrixXd* y, AdjointWork* work);
  const SystemMatrixFactor& SystemMatrixOf(double time_step);

  AdjointMethod method_;
  bool use_kept_factors_;
  double threshold_;
  const Parameters& parameters_;
  Simulator* simulator_;
  std::unique_ptr<SystemMatrixFactor> system_matrix_;  // of the last step size; made when first asked for
};

}  // namespace clothid

#endif  // CLOTHID_SIM_DERIVATIVE_ADJOINT_SOLVER_H_
