// The solver of one implicit step: projected semismooth Newton with a line search, and its fallback (design: section
// 4).
#ifndef CLOTHID_SIM_STEP_H_
#define CLOTHID_SIM_STEP_H_

#include <Eigen/Core>
#include <vector>

#include "sim/rollout.h"
#include "sim/step_jacobian.h"
#include "sim/step_problem.h"

namespace clothid {

// A solver's work space: matrices and symbolic factorisations for the model's pattern. Results depend on the problem
// alone.
class StepSolver {
 public:
  explicit StepSolver(const ClothModel& model);

  // Solves `problem` from its start velocities. True: `point` satisfies the step to the scene's tolerance (or the
  // rounding floor, where that is larger). False: `point` is the best one met. Adds its work to `counts`.
  bool Solve(const StepProblem& problem, const std::vector<double>& friction_coefficients, StepPoint* point,
             RolloutCounts* counts);

  // The tolerance that `Solve` asks for at `point`.
  double Tolerance(const StepProblem& problem, const StepPoint& point) const;

  // Work space that the derivative sweeps share between steps.
  BlockMatrix& hessian() { return hessian_; }
  StepJacobian& jacobian() { return jacobian_; }

  // Where the time went so far, derivative sweeps included.
  const PhaseSeconds& seconds() { return jacobian_.seconds(); }

 private:
  void Evaluate(const StepProblem& problem, const Eigen::VectorXd& velocities, StepPoint* point);
  bool IsSolved(const StepProblem& problem, const StepPoint& point) const;
  bool Newton(const StepProblem& problem, const std::vector<double>& mu, int max_iterations, StepPoint* point,
              RolloutCounts* counts);
  bool SequentialQuadratic(const StepProblem& problem, const std::vector<double>& mu, int max_iterations,
                           StepPoint* point, RolloutCounts* counts);
  bool FactorAt(const StepProblem& problem, const std::vector<Contact>& contacts, const std::vector<double>& mu,
                const StepPoint& point, RolloutCounts* counts);
  bool Direction(const std::vector<Contact>& contacts, const std::vector<double>& mu, const Eigen::VectorXd& residual,
                 Eigen::VectorXd* direction);
  bool LineSearch(const StepProblem& problem, const Eigen::VectorXd& direction, double first_length, StepPoint* point,
                  StepPoint* trial);

  const ClothModel& model_;
  BlockMatrix hessian_;
  StepJacobian jacobian_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_STEP_H_
