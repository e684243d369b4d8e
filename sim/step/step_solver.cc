#include "sim/step/step_solver.h"

#include <algorithm>
#include <cmath>

namespace clothid {
namespace {

constexpr double kLargestForcing = 0.1;       // tolerance of the linear system of a Newton iteration, ...
constexpr double kForcingInContact = 0.3;     // ... where contacts are likely to change on the way, ...
constexpr double kForcing = 0.9;              // ... its share of the square of the last reduction of the residual, ...
constexpr double kGoalShare = 0.3;            // ... and at least so much of the reduction that is left to do
constexpr double kFlopsPerEntry = 18.0;       // of a factorisation, in the time that a solve takes per entry of L
constexpr double kFewestIterations = 5.0;     // a linear solve that takes more may cost as much as a new factor, ...
constexpr double kMostIterations = 10.0;      // ... one that takes more does
constexpr int kDerivativeDigits = 8;          // that are asked of a derivative with a factor that was kept, ...
constexpr int kDerivativeIterations = 5;      // ... in at most so many iterations
constexpr double kRefineTolerance = 1e-8;     // of the linear system of an iteration beyond the tolerance
constexpr double kSufficientDecrease = 1e-4;  // Armijo
constexpr int kMaxHalvings = 14;              // of the step length in a line search
constexpr double kSlowProgress = 0.9;         // a residual above this share of the one before last: a cycle
constexpr double kReversal = 0.25;            // an iteration this far against the one before, as a cosine: likewise
constexpr double kShortestFirstLength = 0.125;
constexpr int kSweptIterations = 8;          // after these many a step is hard for other reasons than its contacts
constexpr int kPatience = 30;                // iterations without progress before Newton's method gives up
constexpr double kProgress = 0.8;            // a residual below this share of the lowest one is progress
constexpr double kSmallestIncrement = 1e-2;  // of the share of friction in its continuation

bool InContact(const StepPoint& point) {
  return std::any_of(point.responses.begin(), point.responses.end(),
                     [](const ContactResponse& response) { return response.branch != ContactBranch::kTakeOff; });
}

bool BranchesDiffer(const StepPoint& a, const StepPoint& b) {
  return !std::equal(a.responses.begin(), a.responses.end(), b.responses.begin(), b.responses.end(),
                     [](const auto& r, const auto& s) { return r.branch == s.branch; });
}

// The tolerance of Newton's linear system at `point`, whose relative residual was `last` before the last iteration (0:
// none): the forcing term of Eisenstat and Walker 1996, choice 2, but no more accurate than a residual below `goal`
// needs.
double ForcingTerm(const StepPoint& point, bool changes, double last, double goal) {
  const double residual = point.relative_residual, ratio = last > 0.0 ? residual / last : 1.0;
  const double largest = changes ? kForcingInContact : kLargestForcing;
  return std::max(std::min(largest, kForcing * ratio * ratio), kGoalShare * goal / residual);
}

// Whether Newton's method gets on. In a stiff cloth the residual stays where it is for dozens of iterations, set by
// elastic forces far larger than those of the solution, while the potential falls; in a cycle neither does.
class Progress {
 public:
  explicit Progress(const StepPoint& start) : residual_(start.relative_residual), potential_(start.potential) {}

  bool Continues(const StepPoint& point) {
    const bool gets_on = point.relative_residual < kProgress * residual_ || point.potential < potential_;
    if (point.relative_residual < kProgress * residual_) residual_ = point.relative_residual;
    potential_ = std::min(potential_, point.potential);
    idle_ = gets_on ? 0 : idle_ + 1;
    return idle_ < kPatience;
  }

 private:
  double residual_, potential_;  // the lowest, for progress
  int idle_ = 0;                 // iterations
};

}  // namespace

StepSolver::StepSolver(const ClothModel& model)
    : model_(model),
      hessian_(model.pattern()),
      jacobian_(model),
      refactor_iterations_(
          std::clamp(jacobian_.factor_flops_per_entry() / kFlopsPerEntry, kFewestIterations, kMostIterations)) {
  if (model.scene().self_contact) pair_newton_ = std::make_unique<PairNewton>(model, &hessian_, &jacobian_);
}

double StepSolver::Tolerance(const StepProblem& problem, double tolerance, const StepPoint& point) {
  return std::max(tolerance, problem.RoundingFloor(point));
}

// From v_n, or from where the acceleration of the last step leads, whichever has the smaller residual.
void StepSolver::Start(const Task& task, StepPoint* point) {
  const StepProblem& problem = task.problem;
  StartAt(problem, problem.start_velocities(), point);
  if (acceleration_.size() == 0) return;
  StartAtBetter(task, problem.start_velocities() + problem.time_step() * acceleration_, point);
}

void StepSolver::StartAtBetter(const Task& task, const Eigen::VectorXd& velocities, StepPoint* point) {
  if (task.IsSolvedAt(*point)) return;
  StartAt(task.problem, velocities, &trial_);
  if (trial_.residual.norm() < point->residual.norm()) std::swap(*point, trial_);
}

void StepSolver::StartAt(const StepProblem& problem, const Eigen::VectorXd& velocities, StepPoint* point) {
  Eigen::VectorXd start = velocities;
  if (problem.may_touch()) problem.ClipToFeasible(&start);
  Evaluate(problem, start, point);
}

bool StepSolver::Solve(const StepProblem& problem, double tolerance, const Eigen::VectorXd* guess, StepPoint* point,
                       RolloutCounts* counts, const std::vector<Eigen::VectorXd>& candidates) {
  const Task task{problem, tolerance, counts};
  SetPairs(problem, point);
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
  SetPairs(problem, point);
  StartAt(problem, Eigen::VectorXd(point->velocities), point);
  const bool solved = SolveFrom(task, point);
  if (solved && ends_with_factors_) EndWithFactor(task, *point);
  return solved;
}

void StepSolver::SetPairs(const StepProblem& problem, StepPoint* point) {
  had_pairs_ = problem.may_touch_itself();
  if (!had_pairs_) return;
  point->pairs.emplace();
  point->pairs->impulses = Eigen::Matrix3Xd::Zero(3, static_cast<Eigen::Index>(problem.pairs().size()));
  trial_.pairs = point->pairs;
}

bool StepSolver::SolveFrom(const Task& task, StepPoint* point) {
  acceleration_.resize(0);
  if (Newton(task, point)) {
    acceleration_ = (point->velocities - task.problem.start_velocities()) / task.problem.time_step();
    return true;
  }
  return std::isfinite(point->relative_residual) && ContinueInFriction(task, point);
}

std::shared_ptr<const ReducedFactor> StepSolver::end_factor() const {
  if (had_pairs_) return ends_with_factors_ ? pair_newton_->factor() : pair_newton_->factor_or_pattern();
  return ends_with_factors_ ? jacobian_.factor() : nullptr;
}

void StepSolver::Refine(const Task& task, StepPoint* point) {
  if (task.problem.may_touch_itself()) {
    pair_newton_->Refine(task.problem, task.tolerance, point, task.counts);
    return;
  }
  ++task.counts->newton_iterations;
  std::vector<Contact> contacts;
  if (task.problem.may_touch()) task.problem.FindActiveContacts(*point, &contacts);
  Eigen::VectorXd direction;
  if (!DirectionByNewFactor(task, contacts, *point, kRefineTolerance, &direction)) return;
  StartAt(task.problem, point->velocities + direction, &trial_);
  if (task.IsSolvedAt(trial_)) std::swap(*point, trial_);
}

// A new one, unless the one at hand brings a derivative to full accuracy in fewer iterations than that costs.
void StepSolver::EndWithFactor(const Task& task, const StepPoint& point) {
  if (task.problem.may_touch_itself()) {
    pair_newton_->EndWithFactor(task.problem, point, task.counts);
    return;
  }
  if (jacobian_.factor() != nullptr && kDerivativeDigits * iterations_per_digit_ <= kDerivativeIterations) return;
  std::vector<Contact> contacts;
  if (task.problem.may_touch()) task.problem.FindActiveContacts(point, &contacts);
  Assemble(task.problem, HessianKind::kExact, point);
  ++task.counts->factorizations;
  jacobian_.Factor(StepJacobian::Method::kReduced, hessian_, contacts, task.mu());
  iterations_per_digit_ = 0.0;
  new_factor_is_due_ = false;
}

void StepSolver::Evaluate(const StepProblem& problem, const Eigen::VectorXd& velocities, StepPoint* point) {
  const ScopedTimer timer(&jacobian_.seconds().evaluation);
  problem.Evaluate(velocities, point);
}

void StepSolver::Reset(bool end_with_factors) {
  jacobian_.SetFactor(nullptr);
  acceleration_.resize(0);
  if (pair_newton_ != nullptr) pair_newton_->Reset();
  ends_with_factors_ = end_with_factors;
  iterations_per_digit_ = 0.0;
  new_factor_is_due_ = false;
}

void StepSolver::Assemble(const StepProblem& problem, HessianKind kind, const StepPoint& point) {
  const ScopedTimer timer(&jacobian_.seconds().assembly);
  problem.AssembleHessian(kind, point, &hessian_);
}

bool StepSolver::FactorAt(const Task& task, const std::vector<Contact>& contacts, const StepPoint& point) {
  for (const HessianKind kind : {HessianKind::kExact, HessianKind::kClamped}) {
    Assemble(task.problem, kind, point);
    ++task.counts->factorizations;
    if (jacobian_.Factor(StepJacobian::Method::kReduced, hessian_, contacts, task.mu())) return true;
  }
  return false;
}

// A dv = -Phi; by LU of the same matrix where GMRES stalls on a strong friction coupling.
bool StepSolver::SolveAt(const Task& task, const std::vector<Contact>& contacts, const Eigen::VectorXd& residual,
                         double forcing, Eigen::VectorXd* direction) {
  Eigen::MatrixXd solution;
  bool solved = jacobian_.Solve(-residual, forcing, &solution);
  task.counts->linear_iterations += jacobian_.iterations();
  if (!solved) {
    ++task.counts->factorizations;
    solved = jacobian_.Factor(StepJacobian::Method::kLu, hessian_, contacts, task.mu()) &&
             jacobian_.Solve(-residual, forcing, &solution);
  }
  if (!solved || !solution.allFinite()) return false;
  *direction = solution;
  return true;
}

bool StepSolver::DirectionByFactorAtHand(const Task& task, const std::vector<Contact>& contacts, const StepPoint& point,
                                         double forcing, Eigen::VectorXd* direction) {
  Assemble(task.problem, HessianKind::kExact, point);
  jacobian_.SetPoint(hessian_, contacts, task.mu());
  Eigen::MatrixXd solution;
  const bool solved = jacobian_.Solve(-point.residual, forcing, &solution) && solution.allFinite();
  task.counts->linear_iterations += jacobian_.iterations();
  new_factor_is_due_ = jacobian_.iterations() > refactor_iterations_;
  iterations_per_digit_ = -jacobian_.iterations() / std::log10(forcing);
  if (solved) *direction = solution;
  return solved;
}

bool StepSolver::DirectionByNewFactor(const Task& task, const std::vector<Contact>& contacts, const StepPoint& point,
                                      double forcing, Eigen::VectorXd* direction) {
  new_factor_is_due_ = false;
  // Where few digits are missing, the step ends near to where the factor was made.
  iterations_per_digit_ = 1.0 / std::max(1.0, -std::log10(point.relative_residual));
  return FactorAt(task, contacts, point) && SolveAt(task, contacts, point.residual, forcing, direction);
}

// Accepts the first length at which the residual or the potential decreases enough.
bool StepSolver::LineSearch(const StepProblem& problem, const Eigen::VectorXd& direction, double first_length,
                            StepPoint* point) {
  const bool may_touch = problem.may_touch();
  const double friction = may_touch ? problem.HeldPotential(*point, point->velocities) : 0.0;
  double length = first_length;
  for (int halving = 0; halving < kMaxHalvings; ++halving, length *= 0.5) {
    Eigen::VectorXd velocities = point->velocities + length * direction;
    if (may_touch) problem.ClipToFeasible(&velocities);
    Evaluate(problem, velocities, &trial_);
    if (!std::isfinite(trial_.relative_residual)) continue;
    const double friction_change = may_touch ? problem.HeldPotential(*point, velocities) - friction : 0.0;
    const double slope = point->momentum_gradient.dot(velocities - point->velocities) + friction_change;
    const double potential_change = trial_.potential - point->potential + friction_change;
    const bool residual_decreases =
        trial_.residual.norm() <= (1.0 - kSufficientDecrease * length) * point->residual.norm();
    if (residual_decreases || (slope < 0.0 && potential_change <= kSufficientDecrease * slope)) {
      std::swap(*point, trial_);
      return true;
    }
  }
  return false;
}

bool StepSolver::SearchInContact(const StepProblem& problem, const Eigen::VectorXd& direction, double forcing,
                                 double first_length, StepPoint* point) {
  Eigen::VectorXd corrected = direction;
  {
    const ScopedTimer timer(&jacobian_.seconds().contact);
    if (!sweeps_.Correct(problem, hessian_, *point, forcing, &corrected)) return false;
  }
  return LineSearch(problem, corrected, first_length, point);
}

bool StepSolver::FactorAtHandServes(double forcing) const {
  return jacobian_.factor() != nullptr && !new_factor_is_due_ &&
         -std::log10(forcing) * iterations_per_digit_ <= refactor_iterations_;
}

bool StepSolver::Iterate(const Task& task, double forcing, double first_length, bool is_swept, StepPoint* point) {
  const StepProblem& problem = task.problem;
  std::vector<Contact> contacts;
  if (problem.may_touch()) problem.FindActiveContacts(*point, &contacts);
  Eigen::VectorXd direction;
  const auto search = [&] {
    return (is_swept && SearchInContact(problem, direction, forcing, first_length, point)) ||
           LineSearch(problem, direction, first_length, point);
  };
  if (FactorAtHandServes(forcing) && DirectionByFactorAtHand(task, contacts, *point, forcing, &direction) && search()) {
    return true;
  }
  return DirectionByNewFactor(task, contacts, *point, forcing, &direction) && search();
}

// The length of the first trial is halved where an iteration undoes the one before it: a cycle between branches.
bool StepSolver::Newton(const Task& task, StepPoint* point) {
  if (task.problem.may_touch_itself()) {
    return pair_newton_->Solve(task.problem, task.tolerance, point, task.counts);
  }
  StepPoint best = *point;
  Progress progress(*point);
  Eigen::VectorXd change, last_change;  // of the velocities
  double first_length = 1.0, before_last = 0.0, last = 0.0;
  const int max_iterations = model_.scene().solver.max_newton_iterations;
  for (int iteration = 0; iteration < max_iterations && !task.IsSolvedAt(*point); ++iteration) {
    ++task.counts->newton_iterations;
    // After a line search the trial is the point before it. Without candidates the responses are those of an earlier
    // step.
    const bool is_swept = task.problem.may_touch() && iteration < kSweptIterations;
    const bool changes = is_swept && (iteration == 0 ? InContact(*point) : BranchesDiffer(*point, trial_));
    const double forcing = ForcingTerm(*point, changes, last, task.ToleranceAt(*point));
    const bool cycles = iteration >= 2 && point->relative_residual > kSlowProgress * before_last &&
                        change.dot(last_change) < -kReversal * change.norm() * last_change.norm();
    first_length = cycles ? std::max(0.5 * first_length, kShortestFirstLength) : std::min(2.0 * first_length, 1.0);
    before_last = last;
    last = point->relative_residual;
    last_change.swap(change);
    change = -point->velocities;
    if (!Iterate(task, forcing, first_length, is_swept, point)) break;
    change += point->velocities;
    if (point->relative_residual < best.relative_residual) best = *point;
    if (!progress.Continues(*point)) break;
  }
  if (!task.IsSolvedAt(*point)) *point = best;
  return task.IsSolvedAt(*point);
}

// From `start`, a solution with less friction, or, for the frictionless step, from where any step starts.
bool StepSolver::SolveWithFriction(const Task& task, double share, const StepPoint& start, StepPoint* point) {
  const StepProblem eased = task.problem.WithFriction(share);
  const Task eased_task{eased, task.tolerance, task.counts};
  if (eased.may_touch_itself()) point->pairs = trial_.pairs;  // as many
  if (share == 0.0) {
    Start(eased_task, point);
  } else {
    Evaluate(eased, start.velocities, point);
  }
  return Newton(eased_task, point);
}

bool StepSolver::ContinueInFriction(const Task& task, StepPoint* point) {
  const bool has_friction = std::any_of(task.mu().begin(), task.mu().end(), [](double mu) { return mu > 0.0; }) ||
                            (task.problem.may_touch_itself() && task.problem.self_friction() > 0.0);
  if (!has_friction) return false;
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
