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

// A solver's work space: matrices and symbolic factorisations for the model's pattern, and the last factor, which
// serves as a preconditioner for as long as that is cheaper than a new one. So within its tolerance the solution of a
// step depends on the steps before it, since `Reset`.
class StepSolver {
 public:
  explicit StepSolver(const ClothModel& model);

  // Forgets the last factor: what follows depends on the problems to come alone.
  void Reset();

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
  // Newton's direction at `point` to `tolerance`: with the factor at hand unless `refactor`, else with one of its own.
  bool Direction(const StepProblem& problem, const std::vector<Contact>& contacts, const std::vector<double>& mu,
                 const StepPoint& point, double tolerance, bool refactor, Eigen::VectorXd* direction,
                 RolloutCounts* counts);
  bool FactorAt(const StepProblem& problem, const std::vector<Contact>& contacts, const std::vector<double>& mu,
                const StepPoint& point, RolloutCounts* counts);
  bool SolveAt(const std::vector<Contact>& contacts, const std::vector<double>& mu, const Eigen::VectorXd& residual,
               double tolerance, Eigen::VectorXd* direction, RolloutCounts* counts);
  void Assemble(const StepProblem& problem, HessianKind kind, const StepPoint& point);
  void Start(const StepProblem& problem, StepPoint* point);
  bool LineSearch(const StepProblem& problem, const Eigen::VectorXd& direction, double first_length, StepPoint* point,
                  StepPoint* trial);

  const ClothModel& model_;
  BlockMatrix hessian_;
  StepJacobian jacobian_;
  Eigen::VectorXd acceleration_;  // of the last step, over the free nodes, m/s^2; empty: none
  bool refactor_ = false;         // the last solve with the factor at hand took so long that a new one is due
};

}  // namespace clothid

#endif  // CLOTHID_SIM_STEP_H_
