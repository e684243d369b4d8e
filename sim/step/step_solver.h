// The solver of one implicit step: projected semismooth Newton with a line search, and its fallback, continuation in
// the friction coefficients, of which the step is a continuous function (section 5.1 of the DiffCloth paper) as long as
// it stays on one solution. See "The solver of a step" in sim/README.md.
#ifndef CLOTHID_SIM_STEP_STEP_SOLVER_H_
#define CLOTHID_SIM_STEP_STEP_SOLVER_H_

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "sim/step/contact_sweeps.h"
#include "sim/step/newton_course.h"
#include "sim/step/past_accelerations.h"
#include "sim/step/step_counts.h"
#include "sim/step/step_jacobian.h"
#include "sim/step/step_problem.h"

namespace clothid {

// A solver's work space: matrices and symbolic factorisations for the model's pattern, and the last factor, which
// serves as a preconditioner for as long as that is cheaper than a new one. So within its tolerance the solution of a
// step depends on the steps before it, since `Reset`.
class StepSolver {
 public:
  explicit StepSolver(const ClothModel& model);

  // Forgets what earlier steps have left for later ones: a solver that was reset gives the same steps again, to the
  // last bit. `end_with_factors`: every Solve ends with a factor that serves the derivative of its step.
  void Reset(bool end_with_factors);

  // After a Solve that ended with a factor: that one. Null otherwise.
  std::shared_ptr<const ReducedFactor> end_factor() const;

  // Solves `problem` from its start velocities, or from `guess` [3 Nf], which may be null; with a guess, one iteration
  // beyond the tolerance, because how the solution differs from the guess may be what is asked for. True: `point`
  // satisfies the step to the relative residual `tolerance` (or the rounding floor, where that is larger). False:
  // `point` is the best one met. Adds its work to `counts`. `candidates` [3 Nf each]: further velocities that it may
  // start from, where it has no guess.
  bool Solve(const StepProblem& problem, double tolerance, const Eigen::VectorXd* guess, StepPoint* point,
             RolloutCounts* counts, const std::vector<Eigen::VectorXd>& candidates = {});
  // The same from the velocities of `point`, which solved the problem before it took back pairs.
  bool SolveAgain(const StepProblem& problem, double tolerance, StepPoint* point, RolloutCounts* counts);

  // What `Solve` asks for at `point`: `tolerance`, or the rounding floor where that is larger.
  static double Tolerance(const StepProblem& problem, double tolerance, const StepPoint& point);

  // Work space that the derivative sweeps share between steps.
  BlockMatrix& hessian() { return hessian_; }
  StepJacobian& jacobian() { return jacobian_; }

  // Where the time went so far, derivative sweeps included.
  const PhaseSeconds& seconds() { return jacobian_.seconds(); }

 private:
  // One Solve, or one of the solves that its continuation is made of.
  struct Task {
    const StepProblem& problem;
    double tolerance;  // relative residual
    RolloutCounts* counts;

    double ToleranceAt(const StepPoint& point) const { return Tolerance(problem, tolerance, point); }
    bool IsSolvedAt(const StepPoint& point) const { return point.relative_residual <= ToleranceAt(point); }
  };
  void Evaluate(const StepProblem& problem, const Eigen::VectorXd& velocities, StepPoint* point);
  void Assemble(const StepProblem& problem, HessianKind kind, const StepPoint& point);
  void Start(const Task& task, StepPoint* point);
  // Starts at `velocities` where the residual is smaller there, unless the step is solved already.
  void StartAtBetter(const Task& task, const Eigen::VectorXd& velocities, StepPoint* point);
  void StartAt(const StepProblem& problem, const Eigen::VectorXd& velocities, StepPoint* point);
  // `point` and `trial_` without impulses of pairs; with those that pairs in contact had in the step before; and keeps
  // those of this one.
  void ClearImpulses(const StepProblem& problem, StepPoint* point);
  void RecallImpulses(const StepProblem& problem, StepPoint* point);
  void KeepImpulses(const StepProblem& problem, const StepPoint& point);
  // From where `point` is.
  bool SolveFrom(const Task& task, StepPoint* point);
  // A full Newton iteration from a solution, kept where it is one, too.
  void Refine(const Task& task, StepPoint* point);
  bool Newton(const Task& task, StepPoint* point);
  // The frictionless step first, which minimises a potential, and from there growing shares of the friction
  // coefficients, each from the solution of the last. Leaves `point` alone where that leads nowhere.
  bool ContinueInFriction(const Task& task, StepPoint* point);
  bool SolveWithFriction(const Task& task, double share, const StepPoint& start, StepPoint* point);
  // One iteration of Newton's method: along the direction that the factor at hand gives, or, where there is none or it
  // leads nowhere, along that of a new factor.
  bool Iterate(const Task& task, const IterationPlan& plan, StepPoint* point);
  bool DirectionByFactorAtHand(const Task& task, const ContactSet& contacts, const StepPoint& point, double forcing,
                               StepColumns* direction);
  bool DirectionByNewFactor(const Task& task, const ContactSet& contacts, const StepPoint& point, double forcing,
                            StepColumns* direction);
  void EndWithFactor(const Task& task, const StepPoint& point);
  bool FactorAt(const Task& task, const ContactSet& contacts, const StepPoint& point);
  bool SolveAt(const Task& task, const ContactSet& contacts, const StepPoint& point, double forcing,
               StepColumns* direction);
  bool Search(const StepProblem& problem, const StepColumns& direction, const IterationPlan& plan, StepPoint* point);
  bool LineSearch(const StepProblem& problem, const StepColumns& direction, const IterationPlan& plan,
                  StepPoint* point);
  // Corrects `direction` by ContactSweeps; false: it stays as it was.
  bool Sweep(const StepProblem& problem, const StepPoint& point, double forcing, StepColumns* direction);
  // `trial_` at a length of `direction`.
  void Try(const StepProblem& problem, const StepPoint& point, const StepColumns& direction, double length);
  // Whether a solve to `forcing` is likely to take less than a new factor.
  bool FactorAtHandServes(double forcing) const;
  // Likewise of a derivative at the point of the last linear solve.
  bool FactorServesDerivative() const;

  const ClothModel& model_;
  BlockMatrix hessian_;
  StepJacobian jacobian_;
  double refactor_iterations_;  // a linear solve that takes more costs as much as a new factor
  StepPoint trial_;             // kept for its memory
  ContactSweeps sweeps_;        // likewise
  ContactSet contacts_;         // likewise
  PastAccelerations past_;
  PairMemory memory_;  // of the last step
  bool ends_with_factors_ = false;
  double iterations_per_digit_ = 0.0;  // of solves with the factor at hand, as far as is known
  bool new_factor_is_due_ = false;     // the last solve with the one at hand took as long as a new one
};

}  // namespace clothid

#endif  // CLOTHID_SIM_STEP_STEP_SOLVER_H_
