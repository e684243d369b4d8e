// The solver of a step whose cloth may touch itself: semismooth Newton on (v, r).
//
// The residual rises on the way of an iteration that changes branches of pairs, so these are taken whole unless the
// merit |Phi|^2/P + sum |R|^2/d explodes. Where it has not fallen for three of them, branches go in a circle, and
// shorter steps lead out of it. Once pairs stay on their branches and |R| is small beside |Phi|, obstacles and the
// cloth are what is left to solve: a line search then takes the first length at which the merit falls, or the potential
// at the normal impulses of the point (StepProblem::HeldPotential).
#ifndef CLOTHID_SIM_STEP_PAIR_NEWTON_H_
#define CLOTHID_SIM_STEP_PAIR_NEWTON_H_

#include <Eigen/Core>
#include <map>
#include <memory>

#include "sim/step/contact_sweeps.h"
#include "sim/step/pair_jacobian.h"
#include "sim/step/step_counts.h"
#include "sim/step/step_problem.h"

namespace clothid {

class PairNewton {
 public:
  // Borrows `hessian`, of the model's pattern, and the threads and the timers of `shared`.
  PairNewton(const ClothModel& model, BlockMatrix* hessian, StepJacobian* shared);

  // Forgets what earlier steps have left for later ones.
  void Reset();

  // From the velocities of `point`, which it overwrites. True: it satisfies the step to `tolerance`.
  bool Solve(const StepProblem& problem, double tolerance, StepPoint* point, RolloutCounts* counts);

  // A full iteration from a solution, kept where it is one, too.
  void Refine(const StepProblem& problem, double tolerance, StepPoint* point, RolloutCounts* counts);
  // Makes a factor at the solution `point`, unless the one at hand serves the derivative of the step.
  void EndWithFactor(const StepProblem& problem, const StepPoint& point, RolloutCounts* counts);
  // The factor at hand, null where there is none.
  const std::shared_ptr<const ReducedFactor>& factor() const { return jacobian_.factor(); }
  // The same if it is likely to serve the derivative of the last step, else its pattern.
  std::shared_ptr<const ReducedFactor> factor_or_pattern() const;

 private:
  // r of the pairs from the step before, where they were in contact.
  Eigen::Matrix3Xd WarmStart(const StepProblem& problem) const;
  void Keep(const StepProblem& problem, const StepPoint& point);
  // An iteration along the direction of the linear system, solved to `forcing`, and, `is_swept`, ContactSweeps at the
  // obstacles.
  bool Iterate(const StepProblem& problem, double forcing, double length, bool is_swept, StepPoint* point,
               RolloutCounts* counts);
  // The direction as sweeps correct it, at the impulses `dr` that it ends at.
  Eigen::VectorXd Swept(const StepProblem& problem, double forcing, const StepPoint& point, const Eigen::VectorXd& dv,
                        const Eigen::MatrixXd& dr);
  // The first length at which the merit or the potential falls; false: none.
  bool LineSearch(const StepProblem& problem, const Eigen::VectorXd& dv, const Eigen::Matrix3Xd& dr, double length,
                  StepPoint* point);
  // The first length at which the merit does not explode.
  bool Explore(const StepProblem& problem, const Eigen::VectorXd& dv, const Eigen::Matrix3Xd& dr, double length,
               StepPoint* point);
  void Try(const StepProblem& problem, const StepPoint& point, const Eigen::VectorXd& dv, const Eigen::Matrix3Xd& dr,
           double length);  // trial_
  void Evaluate(const StepProblem& problem, const Eigen::VectorXd& velocities, StepPoint* point);
  // (dv, dr) with the factor at hand where that serves, else with one of the point.
  bool SolveLinearized(const StepProblem& problem, double forcing, const StepPoint& point, RolloutCounts* counts,
                       Eigen::MatrixXd* dv, Eigen::MatrixXd* dr);
  bool SolveWithNewFactor(const StepProblem& problem, double forcing, const StepPoint& point, RolloutCounts* counts,
                          Eigen::MatrixXd* dv, Eigen::MatrixXd* dr);
  bool SolveAt(const StepPoint& point, double forcing, RolloutCounts* counts, Eigen::MatrixXd* dv, Eigen::MatrixXd* dr);
  void SetPoint(const StepProblem& problem, HessianKind kind, const StepPoint& point);
  // Whether a derivative is likely to take less with the factor at hand than with a new one.
  bool FactorServesDerivative() const;

  const ClothModel& model_;
  BlockMatrix& hessian_;
  PhaseSeconds& seconds_;
  PairJacobian jacobian_;
  ContactSweeps sweeps_;
  std::map<PairFeatures, Eigen::Vector3d> impulses_;  // of the last step, over its size, N
  double iterations_per_digit_ = 0.0;                 // of solves with the factor at hand, as far as is known
  bool is_settled_ = false;                           // pairs have stayed on their branches and R is small
  StepPoint trial_;                                   // kept for its memory
};

}  // namespace clothid

#endif  // CLOTHID_SIM_STEP_PAIR_NEWTON_H_
