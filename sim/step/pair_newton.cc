#include "sim/step/pair_newton.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace clothid {
namespace {

constexpr int kSweptPairIterations = 6;   // with sweeps over the contacts with obstacles, ...
constexpr int kSweptSettled = 8;          // ... and so many that are settled
constexpr double kSettledShare = 0.1;     // of |Phi|, below which |R| is small
constexpr double kDecrease = 1e-4;        // Armijo
constexpr int kSearchHalvings = 14;       // of the length in a line search
constexpr int kIdleIterations = 3;        // without progress: a cycle of branches, which shorter steps leave, ...
constexpr double kShortestLength = 0.2;   // ... from a half to about this
constexpr double kProgressOfMerit = 0.9;  // of the lowest one: progress
constexpr double kExplosion = 1e4;        // a step is shortened where the merit grows by this factor
constexpr int kMeritHalvings = 10;        // of the length of a step
constexpr int kMostPairIterations = 60;   // more of them seldom end: a shorter step does
constexpr double kPairForcing = 1e-4;     // tolerance of the linear system, ...
constexpr double kPairGoalShare = 0.1;    // ... not below this share of what is left to do, ...
constexpr double kPairLoosest = 1e-2;     // ... and never above
constexpr int kMostChanges = 4;           // of branches since the factor at hand was made, with which it still serves
constexpr int kPairDerivativeDigits = 8;  // that are asked of a derivative, in no more iterations ...
constexpr double kOwnIterations = 5.0;    // ... than with a factor of its own ...
constexpr double kFewestSpared = 5.0, kMostSpared = 12.0;  // ... and those that take as long as to make it, by ...
constexpr double kPairFlopsPerEntry = 18.0;                // ... its operations in the time of a solve per entry of L
constexpr double kPairRefineTolerance = 1e-8;              // of the linear system of an iteration beyond the tolerance

// |Phi|^2/P + sum |R|^2/d, kg m^2/s^2.
double Merit(const StepProblem& problem, const StepPoint& point) {
  double merit = problem.WeighedSquare(point.residual);
  for (std::size_t c = 0; c < problem.pairs().size(); ++c) {
    merit += point.pairs->residuals.col(static_cast<Eigen::Index>(c)).squaredNorm() / problem.pairs()[c].weight;
  }
  return merit;
}

bool IsSettled(const StepPoint& point) {
  return point.pairs->residuals.norm() <= kSettledShare * point.residual.norm();
}

bool PairsDiffer(const StepPoint& a, const StepPoint& b) {
  const auto &r = a.pairs->responses, &s = b.pairs->responses;
  return !std::equal(r.begin(), r.end(), s.begin(), s.end(),
                     [](const auto& x, const auto& y) { return x.branch == y.branch; });
}

}  // namespace

PairNewton::PairNewton(const ClothModel& model, BlockMatrix* hessian, StepJacobian* shared)
    : model_(model), hessian_(*hessian), seconds_(shared->seconds()), jacobian_(model, shared) {}

void PairNewton::Reset() {
  impulses_.clear();
  jacobian_.Reset();
  iterations_per_digit_ = 0.0;
}

void PairNewton::Evaluate(const StepProblem& problem, const Eigen::VectorXd& velocities, StepPoint* point) {
  const ScopedTimer timer(&seconds_.evaluation);
  problem.Evaluate(velocities, point);
}

Eigen::Matrix3Xd PairNewton::WarmStart(const StepProblem& problem) const {
  Eigen::Matrix3Xd impulses = Eigen::Matrix3Xd::Zero(3, static_cast<Eigen::Index>(problem.pairs().size()));
  for (std::size_t c = 0; c < problem.pairs().size(); ++c) {
    const auto found = impulses_.find(problem.pairs()[c].features);
    if (found != impulses_.end()) {
      impulses.col(static_cast<Eigen::Index>(c)) = problem.time_step() * found->second;
    }
  }
  return impulses;
}

void PairNewton::Keep(const StepProblem& problem, const StepPoint& point) {
  impulses_.clear();
  for (std::size_t c = 0; c < problem.pairs().size(); ++c) {
    if (point.pairs->responses[c].branch == ContactBranch::kTakeOff) continue;
    impulses_[problem.pairs()[c].features] =
        point.pairs->impulses.col(static_cast<Eigen::Index>(c)) / problem.time_step();
  }
}

bool PairNewton::Solve(const StepProblem& problem, double tolerance, StepPoint* point, RolloutCounts* counts) {
  point->pairs->impulses = WarmStart(problem);
  Evaluate(problem, Eigen::VectorXd(point->velocities), point);
  jacobian_.SetCandidates(problem.pairs());
  const auto is_solved = [&] { return point->relative_residual <= std::max(tolerance, problem.RoundingFloor(*point)); };
  const int most = std::min(kMostPairIterations, model_.scene().solver.max_newton_iterations);
  double length = 1.0, best = std::numeric_limits<double>::infinity();
  is_settled_ = false;
  for (int iteration = 0, idle = 0, num_settled = 0; iteration < most && !is_solved(); ++iteration) {
    ++counts->newton_iterations;
    const double merit = Merit(problem, *point);
    idle = merit < kProgressOfMerit * best ? 0 : idle + 1;
    best = std::min(best, merit);
    if (idle == 0) length = std::min(1.0, 2.0 * length);
    if (idle > 0 && idle % kIdleIterations == 0) length = length > kShortestLength ? 0.5 * length : 1.0;
    const double forcing = std::max(kPairForcing, kPairGoalShare * tolerance / point->relative_residual);
    num_settled += is_settled_ ? 1 : 0;
    const bool is_swept = is_settled_ ? num_settled <= kSweptSettled : iteration < kSweptPairIterations;
    if (!Iterate(problem, std::min(forcing, kPairLoosest), length, is_swept, point, counts)) break;
    is_settled_ = IsSettled(*point) && !PairsDiffer(*point, trial_);  // after an iteration, the point before it
  }
  if (is_solved()) Keep(problem, *point);
  return is_solved();
}

void PairNewton::SetPoint(const StepProblem& problem, HessianKind kind, const StepPoint& point) {
  {
    const ScopedTimer timer(&seconds_.assembly);
    problem.AssembleHessian(kind, point, &hessian_);
  }
  const std::vector<Contact> contacts = problem.may_touch() ? problem.ActiveContacts(point) : std::vector<Contact>();
  jacobian_.SetPoint(hessian_, contacts, problem.friction_coefficients(), problem.AllPairs(point),
                     problem.self_friction());
}

bool PairNewton::SolveAt(const StepPoint& point, double forcing, RolloutCounts* counts, Eigen::MatrixXd* dv,
                         Eigen::MatrixXd* dr) {
  const bool solved = jacobian_.Solve(-point.residual, -point.pairs->residuals.reshaped(), forcing, dv, dr);
  counts->linear_iterations += jacobian_.iterations();
  iterations_per_digit_ = -jacobian_.iterations() / std::log10(forcing);
  return solved;
}

bool PairNewton::SolveLinearized(const StepProblem& problem, double forcing, const StepPoint& point,
                                 RolloutCounts* counts, Eigen::MatrixXd* dv, Eigen::MatrixXd* dr) {
  SetPoint(problem, HessianKind::kExact, point);
  if (jacobian_.num_changes() <= kMostChanges && SolveAt(point, forcing, counts, dv, dr)) return true;
  return SolveWithNewFactor(problem, forcing, point, counts, dv, dr);
}

// With K of the point, which has been set.
bool PairNewton::SolveWithNewFactor(const StepProblem& problem, double forcing, const StepPoint& point,
                                    RolloutCounts* counts, Eigen::MatrixXd* dv, Eigen::MatrixXd* dr) {
  for (const HessianKind kind : {HessianKind::kExact, HessianKind::kClamped}) {
    if (kind == HessianKind::kClamped) SetPoint(problem, kind, point);
    ++counts->factorizations;
    if (!jacobian_.Factor() || !SolveAt(point, forcing, counts, dv, dr)) continue;
    // Where few digits are missing, the step ends near to where the factor was made.
    iterations_per_digit_ += 1.0 / std::max(1.0, -std::log10(point.relative_residual));
    return true;
  }
  return false;
}

Eigen::VectorXd PairNewton::Swept(const StepProblem& problem, double forcing, const StepPoint& point,
                                  const Eigen::VectorXd& dv, const Eigen::MatrixXd& dr) {
  const ScopedTimer timer(&seconds_.contact);
  const Eigen::VectorXd impulse = jacobian_.Spread(dr);
  Eigen::VectorXd corrected = dv;
  sweeps_.Correct(problem, hessian_, point, forcing, &corrected, &impulse);
  return corrected;
}

void PairNewton::Try(const StepProblem& problem, const StepPoint& point, const Eigen::VectorXd& dv,
                     const Eigen::Matrix3Xd& dr, double length) {
  if (!trial_.pairs) trial_.pairs.emplace();
  trial_.pairs->impulses = point.pairs->impulses + length * dr;
  Evaluate(problem, point.velocities + length * dv, &trial_);
}

bool PairNewton::LineSearch(const StepProblem& problem, const Eigen::VectorXd& dv, const Eigen::Matrix3Xd& dr,
                            double length, StepPoint* point) {
  const double merit = Merit(problem, *point), held = problem.HeldPotential(*point, point->velocities);
  const double gap = point->pairs->residuals.norm();
  const Eigen::VectorXd gradient = point->momentum_gradient + jacobian_.Spread(point->pairs->impulses.reshaped());
  for (int halving = 0; halving < kSearchHalvings; ++halving, length *= 0.5) {
    Try(problem, *point, dv, dr, length);
    if (!std::isfinite(trial_.relative_residual)) continue;
    const double held_change = problem.HeldPotential(*point, trial_.velocities) - held;
    const double slope = length * gradient.dot(dv) + held_change;
    const bool potential_falls = slope < 0.0 && trial_.potential - point->potential + held_change <= kDecrease * slope;
    const bool stays = IsSettled(trial_) || trial_.pairs->residuals.norm() <= 2.0 * gap;
    if (Merit(problem, trial_) > (1.0 - kDecrease * length) * merit && !(potential_falls && stays)) continue;
    std::swap(*point, trial_);
    return true;
  }
  return false;
}

bool PairNewton::Explore(const StepProblem& problem, const Eigen::VectorXd& dv, const Eigen::Matrix3Xd& dr,
                         double length, StepPoint* point) {
  const double merit = Merit(problem, *point);
  for (int halving = 0; halving < kMeritHalvings; ++halving, length *= 0.5) {
    Try(problem, *point, dv, dr, length);
    if (!std::isfinite(trial_.relative_residual) || Merit(problem, trial_) > kExplosion * merit) continue;
    std::swap(*point, trial_);
    return true;
  }
  return false;
}

bool PairNewton::Iterate(const StepProblem& problem, double forcing, double length, bool is_swept, StepPoint* point,
                         RolloutCounts* counts) {
  Eigen::MatrixXd dv, dr;
  if (!SolveLinearized(problem, forcing, *point, counts, &dv, &dr)) return false;
  const Eigen::Matrix3Xd impulses = dr.reshaped(3, point->pairs->impulses.cols());
  Eigen::VectorXd velocities = dv;
  if (is_swept && problem.may_touch()) velocities = Swept(problem, forcing, *point, velocities, dr);
  if (!is_settled_) return Explore(problem, velocities, impulses, length, point);
  return LineSearch(problem, velocities, impulses, length, point) || LineSearch(problem, dv, impulses, length, point) ||
         Explore(problem, dv, impulses, length, point);
}

void PairNewton::Refine(const StepProblem& problem, double tolerance, StepPoint* point, RolloutCounts* counts) {
  ++counts->newton_iterations;
  Eigen::MatrixXd dv, dr;
  SetPoint(problem, HessianKind::kExact, *point);
  if (!SolveWithNewFactor(problem, kPairRefineTolerance, *point, counts, &dv, &dr)) return;
  if (!trial_.pairs) trial_.pairs.emplace();
  trial_.pairs->impulses = point->pairs->impulses + dr.reshaped(3, point->pairs->impulses.cols());
  Evaluate(problem, point->velocities + dv, &trial_);
  if (trial_.relative_residual > std::max(tolerance, problem.RoundingFloor(trial_))) return;
  std::swap(*point, trial_);
  Keep(problem, *point);
}

void PairNewton::EndWithFactor(const StepProblem& problem, const StepPoint& point, RolloutCounts* counts) {
  SetPoint(problem, HessianKind::kExact, point);
  if (jacobian_.num_changes() == 0 && FactorServesDerivative()) return;
  ++counts->factorizations;
  jacobian_.Factor();
  iterations_per_digit_ = 0.0;
}

bool PairNewton::FactorServesDerivative() const {
  if (jacobian_.factor() == nullptr) return false;
  const double refactor =
      std::clamp(jacobian_.pattern()->flops_per_entry() / kPairFlopsPerEntry, kFewestSpared, kMostSpared);
  return kPairDerivativeDigits * iterations_per_digit_ <= kOwnIterations + refactor;
}

std::shared_ptr<const ReducedFactor> PairNewton::factor_or_pattern() const {
  if (FactorServesDerivative()) return jacobian_.factor();
  ReducedFactor none;
  none.pattern = jacobian_.pattern();
  return std::make_shared<const ReducedFactor>(std::move(none));
}

}  // namespace clothid
