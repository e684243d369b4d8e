#include "sim/step/step_jacobian.h"

#include <cstddef>
#include <utility>
#include <vector>

#include "sim/matrix/block_product.h"

namespace clothid {
namespace {

// With the factor of the point itself, only the friction coupling is left to iterations, a small perturbation; where it
// takes more than this, LU is the better solver.
constexpr int kMaxKrylovIterations = 60;
constexpr int kMaxPairIterations = 120;  // likewise, where pairs are in contact
// With the factor of another point: where it takes more, a new factor is cheaper.
constexpr int kMaxLaggedIterations = 24;
// A tolerance above this asks for few digits: a solve with the factor of another point may then give up early, too.
constexpr double kFewDigits = 1e-6;
// A pair that finds no slave may depend on others: an impulse larger than its right side by this is not determined.
constexpr double kLargestLooseImpulse = 1e7;
// Preconditioners from this size on are in single precision: 24 x 24 nodes have 0.7 to 2 MB. Smaller ones are not
// waited for, and would gain less than a twentieth.
constexpr std::size_t kSinglePrecisionBytes = 512 * 1024;
// Of L, from which on a new one costs more than what spares it (sim/step/freed_nodes.h): about 44 x 44 nodes.
constexpr double kLargeFactorEntries = 8e5;

Eigen::MatrixXd Stacked(Eigen::MatrixXd top, const Eigen::MatrixXd& bottom) {
  if (bottom.rows() == 0) return top;
  Eigen::MatrixXd stacked(top.rows() + bottom.rows(), top.cols());
  stacked << top, bottom;
  return stacked;
}

Eigen::MatrixXd TopRows(Eigen::MatrixXd stacked, Eigen::Index num_below) {
  if (num_below > 0) stacked.conservativeResize(stacked.rows() - num_below, Eigen::NoChange);
  return stacked;
}

}  // namespace

StepJacobian::StepJacobian(const ClothModel& model) : model_(model), cholesky_(model.pattern()) {
  if (model.has_contact()) elimination_ = std::make_unique<ContactElimination>();
  if (model.has_contact() && cholesky_.num_entries() >= kLargeFactorEntries) freed_ = std::make_unique<FreedNodes>();
  if (model.scene().self_contact) pairs_ = std::make_unique<PairElimination>();
}

void StepJacobian::SetNumThreads(int num_threads) {
  num_threads_ = num_threads;
  const bool shares = num_threads > 1 && cholesky_.has_branches();
  team_ = shares ? std::make_unique<ThreadTeam>(num_threads) : nullptr;
}

void StepJacobian::SetPoint(const BlockMatrix& hessian, const ContactSet& contacts) {
  method_ = Method::kReduced;
  hessian_ = &hessian;
  factor_is_of_point_ = is_factored_instead_ = freed_are_known_ = false;
  in_contact_ = !contacts.nodes.empty();
  if (!in_contact_ && pairs_ == nullptr) return;
  const ScopedTimer timer(&seconds_.contact);
  if (in_contact_) elimination_->SetContacts(contacts.nodes, model_.free_index());
  if (pairs_ == nullptr) return;
  std::vector<int> held;
  for (const Contact& contact : contacts.nodes) held.push_back(model_.free_index()[contact.candidate.node]);
  pairs_->SetContacts(contacts.pairs, held, hessian);
}

void StepJacobian::SetFactor(std::shared_ptr<const ReducedFactor> factor) {
  if (factor != factor_) preconditioner_.Set(nullptr);
  factor_ = std::move(factor);
  factor_is_of_point_ = is_factored_instead_ = freed_are_known_ = false;
}

// None where the factor is of this point, and none where pairs are in contact: with the closer directions that new
// factors give, five folds of 44 to 52 nodes a side (euler) take 11.8 iterations a solve, with freed nodes 14.7.
void StepJacobian::FindFreedNodes() {
  if (freed_ == nullptr || freed_are_known_) return;
  const ScopedTimer timer(&seconds_.contact);
  freed_are_known_ = true;
  freed_->Clear();
  if (factor_is_of_point_ || is_factored_instead_ || has_pairs()) return;
  if (factor_ == nullptr || factor_->held.empty()) return;
  if (!in_contact_) elimination_->SetContacts({}, model_.free_index());
  freed_->Find(*hessian_, *elimination_, factor_->held);
}

const Eigen::VectorXd& StepJacobian::ReducedValues(const BlockMatrix& matrix) {
  if (!in_contact_) return matrix.values;
  const ScopedTimer timer(&seconds_.contact);
  elimination_->Reduce(matrix, &values_);
  return values_;
}

bool StepJacobian::Factor(Method method) {
  method_ = method;
  if (method == Method::kLu) {
    if (has_pairs()) return false;
    if (in_contact_) elimination_->FullJacobian(*hessian_, &values_);
    const ScopedTimer timer(&seconds_.factorization);
    if (lu_ == nullptr) lu_ = std::make_unique<LuFactor>(model_.pattern());
    return lu_->Factor(in_contact_ ? values_ : hessian_->values);
  }
  factor_is_of_point_ = FactorReduced(*hessian_);
  return factor_is_of_point_;
}

bool StepJacobian::FactorInstead(const BlockMatrix& positive) {
  method_ = Method::kReduced;
  is_factored_instead_ = FactorReduced(positive);
  return is_factored_instead_;
}

bool StepJacobian::FactorReduced(const BlockMatrix& matrix) {
  factor_.reset();  // first, so that its memory can be used again
  preconditioner_.Set(nullptr);
  factor_is_of_point_ = is_factored_instead_ = freed_are_known_ = false;
  const Eigen::VectorXd& values = ReducedValues(matrix);
  const ScopedTimer timer(&seconds_.factorization);
  ReducedFactor factor;
  factor.cholesky = cholesky_.Factor(values, team_.get());
  if (factor.cholesky == nullptr) return false;
  if (in_contact_) factor.held = elimination_->Held();
  factor_ = std::make_shared<const ReducedFactor>(std::move(factor));
  return true;
}

bool StepJacobian::Factor(Method method, const BlockMatrix& hessian, const ContactSet& contacts) {
  SetPoint(hessian, contacts);
  return Factor(method);
}

// A factor of another point is but a preconditioner.
void StepJacobian::SolveWithFactor(const Eigen::MatrixXd& vectors, Eigen::MatrixXd* result) {
  if (factor_is_of_point_ || factor_->cholesky->bytes() < kSinglePrecisionBytes) {
    factor_->cholesky->Solve(vectors, result, team_.get());
  } else {
    preconditioner_.Set(factor_->cholesky, team_.get());
    preconditioner_.Solve(vectors, result, team_.get());
  }
}

// Symmetric and positive definite on the vectors that the contacts of the point leave free, whatever those of the
// factor were.
Eigen::MatrixXd StepJacobian::ApplyHeldFactor(const Eigen::MatrixXd& vectors) {
  const std::vector<LocalFrame>& frames = factor_->held.slipping;
  Eigen::MatrixXd result;
  if (frames.empty()) {
    SolveWithFactor(vectors, &result);
  } else {
    Eigen::MatrixXd local = vectors;
    ToLocal(frames, &local);
    SolveWithFactor(local, &result);
    ToWorld(frames, &result);
  }
  if (in_contact_) elimination_->Project(&result);
  return result;
}

Eigen::MatrixXd StepJacobian::ApplyFactor(const Eigen::MatrixXd& vectors) {
  if (freed_ == nullptr) return ApplyHeldFactor(vectors);
  return freed_->Apply([this](const Eigen::MatrixXd& v) { return ApplyHeldFactor(v); }, vectors);
}

// Z B Z^T of pair_elimination.h where pairs are in contact.
Eigen::MatrixXd StepJacobian::Precondition(Direction direction, const Eigen::MatrixXd& q) {
  if (!has_pairs()) return ApplyFactor(q);
  const bool transposed = direction == Direction::kTransposed;
  Eigen::MatrixXd v = q.topRows(3 * model_.num_free());
  const Eigen::MatrixXd sides = pairs_->Split(transposed, &v);
  if (in_contact_) elimination_->Project(&v);
  v = ApplyFactor(v);
  pairs_->Join(transposed, sides, &v);
  if (num_loose_rows() == 0) return v;
  const Eigen::MatrixXd lambda = pairs_->JoinLoose(transposed, q.bottomRows(num_loose_rows()), &v);
  if (in_contact_) elimination_->Project(&v);
  return Stacked(std::move(v), lambda);
}

Eigen::MatrixXd StepJacobian::TimesStiffness(const Eigen::MatrixXd& velocities) const {
  Eigen::MatrixXd product = MultiplySymmetric(*hessian_, velocities, team_.get());
  if (has_pairs()) pairs_->AddStiffness(velocities, &product);
  return product;
}

Eigen::MatrixXd StepJacobian::VelocitiesOf(Direction direction, Eigen::MatrixXd q) const {
  const bool transposed = direction == Direction::kTransposed;
  Eigen::MatrixXd v = TopRows(std::move(q), num_loose_rows());
  if (in_contact_ && transposed) elimination_->AddFrictionTransposed(&v);
  if (has_pairs()) pairs_->Follow(transposed, &v);
  return v;
}

// Z^T (I + mu t n^T) K Z + kappa b b^T, or its transpose, with Z of the obstacles; K itself without contacts. Pairs, as
// in pair_elimination.h, stand between that and K.
Eigen::MatrixXd StepJacobian::ApplyReduced(Direction direction, const Eigen::MatrixXd& q) const {
  const bool transposed = direction == Direction::kTransposed;
  if (!in_contact_ && !has_pairs()) return TimesStiffness(q);
  const Eigen::MatrixXd v = VelocitiesOf(direction, q);
  Eigen::MatrixXd result = TimesStiffness(v);
  if (has_pairs()) {
    pairs_->SubtractLooseForces(transposed, q.bottomRows(num_loose_rows()), &result);
    pairs_->Unload(transposed, &result);
  }
  if (in_contact_) {
    if (!transposed) elimination_->AddFriction(&result);
    elimination_->Project(&result);
    elimination_->AddSlipStiffness(q, &result);
  }
  return num_loose_rows() == 0 ? result : Stacked(std::move(result), pairs_->TimesLooseRows(transposed, v));
}

bool StepJacobian::SolveByConjugateGradients(const Eigen::MatrixXd& right, double tolerance, Eigen::MatrixXd* q) {
  Eigen::VectorXd solution;
  const ConjugateGradientResult result = ConjugateGradients(
      [&](const Eigen::VectorXd& v) -> Eigen::VectorXd { return ApplyReduced(Direction::kForward, v); },
      [&](const Eigen::VectorXd& v) -> Eigen::VectorXd { return Precondition(Direction::kForward, v); }, right.col(0),
      tolerance, MostIterations(), &solution);
  iterations_ = result.iterations;
  *q = std::move(solution);
  return result.converged;
}

bool StepJacobian::SolveReduced(Direction direction, const Eigen::MatrixXd& right, double tolerance,
                                Eigen::MatrixXd* q) {
  if (!has_pairs() && factor_is_of_point_ && !has_coupling()) {
    *q = ApplyFactor(right);
    return true;
  }
  const bool has_alternative = !factor_is_of_point_ && !is_factored_instead_ && tolerance > kFewDigits;
  if (has_alternative && freed_ != nullptr && freed_->are_too_many()) return false;
  if (!has_coupling() && right.cols() == 1) return SolveByConjugateGradients(right, tolerance, q);
  const GmresResult result = Gmres([&](const Eigen::MatrixXd& v) { return ApplyReduced(direction, v); },
                                   [&](const Eigen::MatrixXd& v) { return Precondition(direction, v); }, right,
                                   tolerance, {MostIterations(), has_alternative}, q);
  iterations_ = result.iterations;
  if (!result.converged || (has_pairs() && !q->allFinite())) return false;
  if (direction == Direction::kTransposed || factor_is_of_point_ || right.cols() != 1) return true;
  // What the inertia test of a factor of this point would have found.
  if (!has_pairs()) return right.col(0).dot(q->col(0)) > 0.0;
  const Eigen::MatrixXd dv = VelocitiesOf(direction, *q);
  return dv.col(0).dot(TimesStiffness(dv).col(0)) >= 0.0;
}

// Whether the reduced matrix is not symmetric.
bool StepJacobian::has_coupling() const {
  return (in_contact_ && elimination_->has_coupling()) ||
         (has_pairs() && (pairs_->has_friction() || num_loose_rows() > 0));
}

int StepJacobian::MostIterations() const {
  if (!factor_is_of_point_ && !is_factored_instead_) return kMaxLaggedIterations;
  return has_pairs() ? kMaxPairIterations : kMaxKrylovIterations;
}

bool StepJacobian::Solve(const StepColumns& right, double tolerance, StepColumns* solution) {
  FindFreedNodes();
  const ScopedTimer timer(&seconds_.solution);
  iterations_ = 0;
  if (method_ == Method::kLu) {
    lu_->Solve(right.velocities, &solution->velocities);
    solution->impulses = right.impulses;
    return solution->velocities.allFinite();
  }
  Eigen::MatrixXd momentum = right.velocities, rows, known;
  if (may_have_pairs()) {
    Eigen::MatrixXd impulse = pairs_->KnownMomentum(right.impulses);
    AddImpulse(&impulse);
    momentum += impulse;
    rows = pairs_->RightRows(right.impulses);
  }
  const Eigen::MatrixXd reduced = ReducedRight(momentum, rows, &known);
  Eigen::MatrixXd q;
  if (!SolveReduced(Direction::kForward, reduced, tolerance, &q)) return false;
  const Eigen::MatrixXd loose = q.bottomRows(num_loose_rows());
  if (loose.norm() > kLargestLooseImpulse * reduced.norm()) return false;
  solution->velocities = VelocitiesOf(Direction::kForward, std::move(q));
  if (known.size() > 0) solution->velocities += known;
  solution->impulses = right.impulses;
  if (!may_have_pairs()) return true;
  Eigen::MatrixXd lambda(0, right.impulses.cols());
  if (has_pairs()) {
    Eigen::MatrixXd balance = TimesStiffness(solution->velocities) - momentum;
    lambda = pairs_->Multipliers(false, loose, &balance);
  }
  solution->impulses = pairs_->Impulses(lambda, right.impulses, solution->velocities);
  return true;
}

Eigen::MatrixXd StepJacobian::ReducedRight(const Eigen::MatrixXd& momentum, const Eigen::MatrixXd& rows,
                                           Eigen::MatrixXd* known) const {
  if (!in_contact_ && !has_pairs()) return momentum;
  *known = in_contact_ ? elimination_->KnownPart(momentum) : Eigen::MatrixXd::Zero(momentum.rows(), momentum.cols());
  if (has_pairs()) pairs_->FollowTo(false, rows, known);
  Eigen::MatrixXd product = TimesStiffness(*known);
  if (has_pairs()) {
    const Eigen::MatrixXd balance = momentum - product;
    Eigen::MatrixXd unloaded = balance;
    pairs_->Unload(false, &unloaded);
    product -= unloaded - balance;
  }
  Eigen::MatrixXd reduced =
      in_contact_ ? elimination_->ReducedRight(momentum, *known, product) : Eigen::MatrixXd(momentum - product);
  return num_loose_rows() == 0 ? reduced : Stacked(std::move(reduced), pairs_->LooseRest(false, rows, *known));
}

// In the reduced system the multipliers of pairs are negated: both directions then have the same signs.
bool StepJacobian::SolveTransposed(const StepColumns& right, double tolerance, StepColumns* z, Eigen::MatrixXd* y) {
  FindFreedNodes();
  const ScopedTimer timer(&seconds_.solution);
  iterations_ = 0;
  if (method_ == Method::kLu) {
    lu_->SolveTransposed(right.velocities, &z->velocities);
    z->impulses = right.impulses;
    *y = z->velocities;
    if (in_contact_) elimination_->AddImpulseTransposed(y);
    return z->velocities.allFinite();
  }
  Eigen::MatrixXd momentum = right.velocities, rows, known;
  if (may_have_pairs()) {
    momentum -= pairs_->KnownMomentumTransposed(right.impulses);
    rows = pairs_->RightRowsTransposed(right.impulses);
  }
  Eigen::MatrixXd q = momentum;
  if (has_pairs()) {
    known.setZero(q.rows(), q.cols());
    pairs_->FollowTo(true, rows, &known);
    q -= TimesStiffness(known);
    pairs_->Unload(true, &q);
  }
  if (in_contact_) elimination_->Project(&q);
  if (num_loose_rows() > 0) q = Stacked(std::move(q), pairs_->LooseRest(true, rows, known));
  if (!SolveReduced(Direction::kTransposed, Eigen::MatrixXd(q), tolerance, &q)) return false;
  const Eigen::MatrixXd loose = q.bottomRows(num_loose_rows());
  *y = VelocitiesOf(Direction::kTransposed, std::move(q));
  if (has_pairs()) *y += known;
  Eigen::MatrixXd balance, lambda(0, y->cols());
  if (in_contact_ || has_pairs()) balance = TimesStiffness(*y);
  if (has_pairs()) {
    balance -= momentum;
    lambda = pairs_->Multipliers(true, loose, &balance);
    balance += momentum;
  }
  z->velocities = in_contact_ ? elimination_->RecoverAdjoint(momentum, *y, balance) : *y;
  z->impulses = may_have_pairs() ? pairs_->AdjointImpulses(-lambda, right.impulses, *y) : right.impulses;
  return true;
}

void StepJacobian::AddImpulse(Eigen::MatrixXd* vectors) const {
  if (in_contact_) elimination_->AddImpulse(vectors);
}

}  // namespace clothid
