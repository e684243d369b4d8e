#include "sim/step/step_solver.h"

#include <algorithm>
#include <cmath>

namespace clothid {
namespace {

constexpr double kFlopsPerEntry = 18.0;       // of a factorisation, in the time that a solve takes per entry of L
constexpr double kFewestIterations = 5.0;     // a linear solve that takes more may cost as much as a new factor, ...
constexpr double kMostIterations = 10.0;      // ... one that takes more does
constexpr int kDerivativeDigits = 8;          // that are asked of a derivative with a factor that was kept, ...
constexpr int kDerivativeIterations = 5;      // ... in at most so many iterations
constexpr double kRefineTolerance = 1e-8;     // of the linear system of an iteration beyond the tolerance
constexpr double kSufficientDecrease = 1e-4;  // Armijo
constexpr int kMaxHalvings = 14;              // of the step length in a line search
constexpr double kExplosion = 100.0;          // times the residual, which no length may reach
constexpr double kSmallestIncrement = 1e-2;   // of the share of friction in its continuation

// -(Phi, R).
StepColumns RightSide(const StepPoint& point) { return {-point.residual, -point.pairs.residuals.reshaped()}; }

}  // namespace

StepSolver::StepSolver(const ClothModel& model)
    : model_(model),
      hessian_(model.pattern()),
      jacobian_(model),
      refactor_iterations_(
          std::clamp(jacobian_.factor_flops_per_entry() / kFlopsPerEntry, kFewestIterations, kMostIterations)) {}

double StepSolver::Tolerance(const StepProblem& problem, double tolerance, const StepPoint& point) {
  return std::max(tolerance, problem.RoundingFloor(point));
}

// From v_n, or from where the accelerations of past steps lead, whichever has the smaller residual.
void StepSolver::Start(const Task& task, StepPoint* point) {
  const StepProblem& problem = task.problem;
  StartAt(problem, problem.start_velocities(), point);
  const Eigen::VectorXd acceleration = past_.Guess(problem.stage());
  if (acceleration.size() == 0) return;
  StartAtBetter(task, problem.start_velocities() + problem.time_step() * acceleration, point);
}

void StepSolver::StartAtBetter(const Task& task, const Eigen::VectorXd& velocities, StepPoint* point) {
  if (task.IsSolvedAt(*point)) return;
  StartAt(task.problem, velocities, &trial_);
  if (trial_.residual.norm() < point->residual.norm()) std::swap(*point, trial_);
}

void StepSolver::StartAt(const StepProblem& problem, const Eigen::VectorXd& velocities, StepPoint* point) {
  Eigen::VectorXd start = velocities;
  problem.contacts().ClipToFeasible(&start);
  Evaluate(problem, start, point);
}

bool StepSolver::Solve(const StepProblem& problem, double tolerance, const Eigen::VectorXd* guess, StepPoint* point,
                       RolloutCounts* counts, const std::vector<Eigen::VectorXd>& candidates) {
  const Task task{problem, tolerance, counts};
  ClearImpulses(problem, point);
  if (guess != nullptr) {
    StartAt(problem, *guess, point);
  } else {
    Start(task, point);
    for (const Eigen::VectorXd& velocities : candidates) StartAtBetter(task, velocities, point);
  }
  const bool solved = SolveFrom(task, point);
  if (solved && guess != nullptr) Refine(task, point);
  if (solved && ends_with_factors_) EndWithFactor(task, *point);
  return solved;
}

bool StepSolver::SolveAgain(const StepProblem& problem, double tolerance, StepPoint* point, RolloutCounts* counts) {
  const Task task{problem, tolerance, counts};
  ClearImpulses(problem, point);
  StartAt(problem, Eigen::VectorXd(point->velocities), point);
  const bool solved = SolveFrom(task, point);
  if (solved && ends_with_factors_) EndWithFactor(task, *point);
  return solved;
}

void StepSolver::ClearImpulses(const StepProblem& problem, StepPoint* point) {
  problem.contacts().Recall({}, problem.time_step(), point);
  problem.contacts().Recall({}, problem.time_step(), &trial_);
}

void StepSolver::RecallImpulses(const StepProblem& problem, StepPoint* point) {
  if (!problem.contacts().may_touch_itself()) return;
  problem.contacts().Recall(memory_, problem.time_step(), point);
  Evaluate(problem, Eigen::VectorXd(point->velocities), point);
}

void StepSolver::KeepImpulses(const StepProblem& problem, const StepPoint& point) {
  problem.contacts().Remember(point, problem.time_step(), &memory_);
}

bool StepSolver::SolveFrom(const Task& task, StepPoint* point) {
  const StepProblem& problem = task.problem;
  if (Newton(task, point)) {
    past_.Add(problem.stage(), (point->velocities - problem.start_velocities()) / problem.time_step());
    return true;
  }
  past_.Clear();
  return std::isfinite(point->relative_residual) && ContinueInFriction(task, point);
}

std::shared_ptr<const ReducedFactor> StepSolver::end_factor() const {
  return ends_with_factors_ ? jacobian_.factor() : nullptr;
}

void StepSolver::Refine(const Task& task, StepPoint* point) {
  ++task.counts->newton_iterations;
  StepColumns direction;
  const ContactSet contacts = task.problem.ContactsAt(*point);
  if (!DirectionByNewFactor(task, contacts, *point, kRefineTolerance, &direction)) return;
  Try(task.problem, *point, direction, 1.0);
  if (!task.IsSolvedAt(trial_)) return;
  std::swap(*point, trial_);
  KeepImpulses(task.problem, *point);
}

// A new one, unless the one at hand brings a derivative to full accuracy in fewer iterations than that costs.
void StepSolver::EndWithFactor(const Task& task, const StepPoint& point) {
  if (FactorServesDerivative()) return;
  Assemble(task.problem, HessianKind::kExact, point);
  ++task.counts->factorizations;
  jacobian_.Factor(StepJacobian::Method::kReduced, hessian_, task.problem.ContactsAt(point));
  iterations_per_digit_ = 0.0;
  new_factor_is_due_ = false;
}

bool StepSolver::FactorServesDerivative() const {
  return jacobian_.factor() != nullptr && kDerivativeDigits * iterations_per_digit_ <= kDerivativeIterations;
}

void StepSolver::Evaluate(const StepProblem& problem, const Eigen::VectorXd& velocities, StepPoint* point) {
  const ScopedTimer timer(&jacobian_.seconds().evaluation);
  problem.Evaluate(velocities, point);
}

void StepSolver::Reset(bool end_with_factors) {
  jacobian_.SetFactor(nullptr);
  past_.Clear();
  memory_.clear();
  ends_with_factors_ = end_with_factors;
  iterations_per_digit_ = 0.0;
  new_factor_is_due_ = false;
}

void StepSolver::Assemble(const StepProblem& problem, HessianKind kind, const StepPoint& point) {
  const ScopedTimer timer(&jacobian_.seconds().assembly);
  problem.AssembleHessian(kind, point, &hessian_, jacobian_.team());
}

bool StepSolver::FactorAt(const Task& task, const ContactSet& contacts, const StepPoint& point) {
  for (const HessianKind kind : {HessianKind::kExact, HessianKind::kClamped}) {
    Assemble(task.problem, kind, point);
    ++task.counts->factorizations;
    if (jacobian_.Factor(StepJacobian::Method::kReduced, hessian_, contacts)) return true;
  }
  return false;
}

// A (dv, dr) = -(Phi, R). Where GMRES stalls on a strong friction coupling, by LU of the same matrix, or, as that has
// no pairs, with the clamped one.
bool StepSolver::SolveAt(const Task& task, const ContactSet& contacts, const StepPoint& point, double forcing,
                         StepColumns* direction) {
  const StepColumns right = RightSide(point);
  const auto solve = [&] {
    const bool solved = jacobian_.Solve(right, forcing, direction);
    task.counts->linear_iterations += jacobian_.iterations();
    return solved;
  };
  if (solve()) return direction->velocities.allFinite();
  ++task.counts->factorizations;
  StepJacobian::Method method = StepJacobian::Method::kLu;
  if (!contacts.pairs.empty()) {
    Assemble(task.problem, HessianKind::kClamped, point);
    method = StepJacobian::Method::kReduced;
  }
  return jacobian_.Factor(method, hessian_, contacts) && solve() && direction->velocities.allFinite();
}

bool StepSolver::DirectionByFactorAtHand(const Task& task, const ContactSet& contacts, const StepPoint& point,
                                         double forcing, StepColumns* direction) {
  Assemble(task.problem, HessianKind::kExact, point);
  jacobian_.SetPoint(hessian_, contacts);
  const StepColumns right = RightSide(point);
  const bool solved = jacobian_.Solve(right, forcing, direction) && direction->velocities.allFinite();
  task.counts->linear_iterations += jacobian_.iterations();
  new_factor_is_due_ = jacobian_.iterations() > refactor_iterations_;
  iterations_per_digit_ = -jacobian_.iterations() / std::log10(forcing);
  return solved;
}

bool StepSolver::DirectionByNewFactor(const Task& task, const ContactSet& contacts, const StepPoint& point,
                                      double forcing, StepColumns* direction) {
  new_factor_is_due_ = false;
  const bool solved = FactorAt(task, contacts, point) && SolveAt(task, contacts, point, forcing, direction);
  // Where few digits are missing, the step ends near to where the factor was made.
  iterations_per_digit_ = 1.0 / std::max(1.0, -std::log10(point.relative_residual));
  if (!contacts.pairs.empty()) iterations_per_digit_ -= jacobian_.iterations() / std::log10(forcing);
  return solved;
}

void StepSolver::Try(const StepProblem& problem, const StepPoint& point, const StepColumns& direction, double length) {
  Eigen::VectorXd velocities = point.velocities + length * direction.velocities.col(0);
  trial_.pairs.impulses =
      point.pairs.impulses + length * direction.impulses.reshaped(3, problem.contacts().num_impulses());
  if (!problem.contacts().may_touch_itself()) problem.contacts().ClipToFeasible(&velocities);
  Evaluate(problem, velocities, &trial_);
}

// Accepts the first length at which the residual or the potential decreases enough, the latter where that leaves pairs
// settled or the residual of pairs about where it was.
bool StepSolver::LineSearch(const StepProblem& problem, const StepColumns& direction, const IterationPlan& plan,
                            StepPoint* point) {
  const bool has_pairs = problem.contacts().may_touch_itself();
  const double size = problem.ResidualSize(*point);
  const double held = problem.HeldPotential(*point, point->velocities);
  Eigen::VectorXd impulses;
  if (has_pairs) impulses = problem.contacts().Spread(point->pairs.impulses.reshaped());
  double length = plan.first_length;
  for (int halving = 0; halving < kMaxHalvings; ++halving, length *= 0.5) {
    Try(problem, *point, direction, length);
    if (!std::isfinite(trial_.relative_residual)) continue;
    const double trial_size = problem.ResidualSize(trial_);
    bool is_accepted = trial_size <= (plan.explores ? kExplosion : 1.0 - kSufficientDecrease * length) * size;
    if (!is_accepted && !plan.explores) {
      const double held_change = problem.HeldPotential(*point, trial_.velocities) - held;
      const Eigen::VectorXd change = trial_.velocities - point->velocities;
      double slope = point->momentum_gradient.dot(change) + held_change;
      if (has_pairs) slope += impulses.dot(change);
      const double potential_change = trial_.potential - point->potential + held_change;
      is_accepted = slope < 0.0 && potential_change <= kSufficientDecrease * slope &&
                    (!has_pairs || PairsAreSettled(trial_) ||
                     trial_.pairs.residuals.norm() <= 2.0 * point->pairs.residuals.norm());
    }
    if (!is_accepted) continue;
    std::swap(*point, trial_);
    return true;
  }
  return false;
}

bool StepSolver::Sweep(const StepProblem& problem, const StepPoint& point, double forcing, StepColumns* direction) {
  const ScopedTimer timer(&jacobian_.seconds().contact);
  Eigen::VectorXd corrected = direction->velocities, impulse;
  const bool has_pairs = problem.contacts().may_touch_itself();
  if (has_pairs) impulse = problem.contacts().Spread(direction->impulses.col(0));
  const Eigen::VectorXd* const other = has_pairs ? &impulse : nullptr;
  if (!sweeps_.Correct(problem, hessian_, point, forcing, &corrected, other)) return false;
  direction->velocities = corrected;
  return true;
}

bool StepSolver::Search(const StepProblem& problem, const StepColumns& direction, const IterationPlan& plan,
                        StepPoint* point) {
  if (plan.is_swept) {
    StepColumns corrected = direction;
    if (Sweep(problem, *point, plan.forcing, &corrected) && LineSearch(problem, corrected, plan, point)) return true;
  }
  if (LineSearch(problem, direction, plan, point)) return true;
  if (!problem.contacts().may_touch_itself() || plan.explores) return false;
  IterationPlan exploring = plan;
  exploring.explores = true;
  return LineSearch(problem, direction, exploring, point);
}

bool StepSolver::FactorAtHandServes(double forcing) const {
  return jacobian_.factor() != nullptr && !new_factor_is_due_ &&
         -std::log10(forcing) * iterations_per_digit_ <= refactor_iterations_;
}

bool StepSolver::Iterate(const Task& task, const IterationPlan& plan, StepPoint* point) {
  task.problem.FindContacts(*point, &contacts_);
  StepColumns direction;
  if (FactorAtHandServes(plan.forcing) && DirectionByFactorAtHand(task, contacts_, *point, plan.forcing, &direction) &&
      Search(task.problem, direction, plan, point)) {
    return true;
  }
  return DirectionByNewFactor(task, contacts_, *point, plan.forcing, &direction) &&
         Search(task.problem, direction, plan, point);
}

bool StepSolver::Newton(const Task& task, StepPoint* point) {
  RecallImpulses(task.problem, point);
  StepPoint best = *point;
  const std::unique_ptr<NewtonCourse> course = MakeCourse(task.problem, *point);
  const int max_iterations = model_.scene().solver.max_newton_iterations;
  for (int iteration = 0; iteration < max_iterations && !task.IsSolvedAt(*point); ++iteration) {
    ++task.counts->newton_iterations;
    // After a line search the trial is the point before it.
    // The linear systems of pairs, whose rows have other units, are not eased where rounding eases the step.
    const double goal = task.problem.contacts().may_touch_itself() ? task.tolerance : task.ToleranceAt(*point);
    const IterationPlan plan = course->Next(*point, trial_, goal);
    if (!Iterate(task, plan, point)) break;
    if (point->relative_residual < best.relative_residual) best = *point;
    if (!course->Continues(*point)) break;
  }
  if (!task.IsSolvedAt(*point)) *point = best;
  if (!task.IsSolvedAt(*point)) return false;
  KeepImpulses(task.problem, *point);
  return true;
}

// From `start`, a solution with less friction, or, for the frictionless step, from where any step starts.
bool StepSolver::SolveWithFriction(const Task& task, double share, const StepPoint& start, StepPoint* point) {
  const StepProblem eased = task.problem.WithFriction(share);
  const Task eased_task{eased, task.tolerance, task.counts};
  if (share == 0.0) {
    ClearImpulses(eased, point);
    Start(eased_task, point);
  } else {
    point->pairs.impulses = start.pairs.impulses;
    Evaluate(eased, start.velocities, point);
  }
  return Newton(eased_task, point);
}

bool StepSolver::ContinueInFriction(const Task& task, StepPoint* point) {
  if (!task.problem.has_friction()) return false;
  ++task.counts->fallbacks;
  StepPoint reached, next;
  if (!SolveWithFriction(task, 0.0, reached, &next)) return false;
  std::swap(reached, next);
  for (double share = 0.0, increment = 1.0; share < 1.0;) {
    const double next_share = std::min(1.0, share + increment);
    if (SolveWithFriction(task, next_share, reached, &next)) {
      std::swap(reached, next);
      share = next_share;
      increment *= 2.0;
    } else {
      increment *= 0.5;
      if (increment < kSmallestIncrement) return false;
    }
  }
  *point = reached;
  return true;
}

}  // namespace clothid
