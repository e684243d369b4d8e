#include "sim/step/step_jacobian.h"

#include <cstddef>
#include <utility>

#include "sim/matrix/block_product.h"
#include "sim/step/wide_pattern.h"

namespace clothid {
namespace {

// With the factor of the point itself, only the friction coupling is left to iterations, a small perturbation; where it
// takes more than this, LU is the better solver.
constexpr int kMaxKrylovIterations = 60;
constexpr int kMaxPairIterations = 120;  // likewise, where pairs are in contact
// With the factor of another point: where it takes more, a new factor is cheaper.
constexpr int kMaxLaggedIterations = 24;
// Likewise, where pairs are in contact and few digits are asked for.
constexpr int kMaxLaggedPairIterations = 15;
// A tolerance above this asks for few digits: a solve with the factor of another point may then give up early, too.
constexpr double kFewDigits = 1e-6;
// Preconditioners from this size on are in single precision: 24 x 24 nodes have 0.7 to 2 MB. Smaller ones are not
// waited for, and would gain less than a twentieth.
constexpr std::size_t kSinglePrecisionBytes = 512 * 1024;

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

std::size_t ReducedFactor::bytes() const {
  return (cholesky == nullptr ? 0 : cholesky->bytes()) + frames.size() * sizeof(LocalFrame) +
         (pattern == nullptr ? 0 : pattern->bytes());
}

StepJacobian::StepJacobian(const ClothModel& model) : model_(model), cholesky_(model.pattern()) {
  if (model.has_contact()) elimination_ = std::make_unique<ContactElimination>();
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
  factor_is_of_point_ = false;
  in_contact_ = !contacts.nodes.empty();
  if (!in_contact_ && pairs_ == nullptr) return;
  const ScopedTimer timer(&seconds_.contact);
  if (in_contact_) elimination_->SetContacts(contacts.nodes, model_.free_index());
  if (pairs_ == nullptr) return;
  pairs_->SetContacts(contacts.pairs, 3 * model_.num_free());
  closed_ = RecordContacts(contacts);
}

void StepJacobian::SetFactor(std::shared_ptr<const ReducedFactor> factor) {
  if (factor != factor_) preconditioner_.Set(nullptr);
  if (factor != nullptr && factor->pattern != nullptr) pattern_ = factor->pattern;
  factor_ = factor == nullptr || factor->cholesky == nullptr ? nullptr : std::move(factor);
  factor_is_of_point_ = false;
}

void StepJacobian::Reset() {
  SetFactor(nullptr);
  pattern_.reset();
}

bool StepJacobian::HasFactorNear(const ContactSet& contacts, int most) const {
  if (factor_ == nullptr) return false;
  if (contacts.pairs.empty() && factor_->contacts.pairs.empty()) return true;
  return NumDifferences(RecordContacts(contacts), factor_->contacts) <= most;
}

const Eigen::VectorXd& StepJacobian::ReducedValues(const BlockMatrix& matrix) {
  if (!in_contact_) return matrix.values;
  const ScopedTimer timer(&seconds_.contact);
  elimination_->Reduce(matrix, &values_);
  return values_;
}

// In a pattern that covers the pairs in contact.
std::shared_ptr<const CholeskyFactor> StepJacobian::FactorWithPairs() {
  if (pattern_ == nullptr || !pattern_->Covers(pairs_->ClosedBlocks())) {
    const ScopedTimer timer(&seconds_.factorization);
    pattern_ = std::make_shared<const WidePattern>(*model_.pattern(), pairs_->blocks(), pattern_.get());
  }
  BlockMatrix wide = pattern_->Widened(*hessian_);
  pairs_->AddAugmented(&wide);
  const Eigen::VectorXd& values = ReducedValues(wide);
  const ScopedTimer timer(&seconds_.factorization);
  return pattern_->Factor(values, team_.get());
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
  factor_.reset();  // first, so that its memory can be used again
  preconditioner_.Set(nullptr);
  ReducedFactor factor;
  if (has_pairs()) {
    factor.cholesky = FactorWithPairs();
    factor.pattern = pattern_;
  } else {
    const Eigen::VectorXd& values = ReducedValues(*hessian_);
    const ScopedTimer timer(&seconds_.factorization);
    factor.cholesky = cholesky_.Factor(values, team_.get());
  }
  if (factor.cholesky == nullptr) return false;
  if (in_contact_) factor.frames = elimination_->SlipFrames();
  factor.contacts = closed_;
  factor_ = std::make_shared<const ReducedFactor>(std::move(factor));
  factor_is_of_point_ = true;
  return true;
}

bool StepJacobian::Factor(Method method, const BlockMatrix& hessian, const ContactSet& contacts) {
  SetPoint(hessian, contacts);
  return Factor(method);
}

double StepJacobian::factor_flops_per_entry() const {
  if (factor_ != nullptr && factor_->pattern != nullptr) return factor_->pattern->flops_per_entry();
  return cholesky_.num_flops() / cholesky_.num_entries();
}

// A factor of another point is but a preconditioner.
void StepJacobian::SolveWithFactor(const Eigen::MatrixXd& vectors, Eigen::MatrixXd* result) {
  if (factor_->pattern != nullptr) {
    *result = factor_->pattern->Solve(*factor_->cholesky, vectors, team_.get());
  } else if (factor_is_of_point_ || factor_->cholesky->bytes() < kSinglePrecisionBytes) {
    factor_->cholesky->Solve(vectors, result, team_.get());
  } else {
    preconditioner_.Set(factor_->cholesky, team_.get());
    preconditioner_.Solve(vectors, result, team_.get());
  }
}

// Symmetric and positive definite on the vectors that the contacts of the point leave free, whatever those of the
// factor were.
Eigen::MatrixXd StepJacobian::ApplyFactor(const Eigen::MatrixXd& vectors) {
  Eigen::MatrixXd result;
  if (factor_->frames.empty()) {
    SolveWithFactor(vectors, &result);
  } else {
    Eigen::MatrixXd local = vectors;
    ToLocal(factor_->frames, &local);
    SolveWithFactor(local, &result);
    ToWorld(factor_->frames, &result);
  }
  if (in_contact_) elimination_->Project(&result);
  return result;
}

// Of (q, lambda) likewise, with one more row for every lambda.
Eigen::MatrixXd StepJacobian::Precondition(const Eigen::MatrixXd& q) {
  if (!has_pairs()) return ApplyFactor(q);
  const Eigen::MatrixXd e = q.bottomRows(pairs_->num_rows());
  Eigen::MatrixXd v = q.topRows(q.rows() - e.rows());
  pairs_->AddPenalty(e, &v);
  if (in_contact_) elimination_->Project(&v);
  v = ApplyFactor(v);
  const Eigen::MatrixXd lambda = pairs_->PenaltyImpulses(e, v);
  return Stacked(std::move(v), lambda);
}

Eigen::MatrixXd StepJacobian::TimesStiffness(const Eigen::MatrixXd& velocities) const {
  Eigen::MatrixXd product = MultiplySymmetric(*hessian_, velocities, team_.get());
  if (has_pairs()) pairs_->AddStiffness(velocities, &product);
  return product;
}

// Z^T (I + mu t n^T) K Z + kappa b b^T, or its transpose; K itself without contacts. With pairs in contact the matrix
// of pair_elimination.h, likewise.
Eigen::MatrixXd StepJacobian::ApplyReduced(Direction direction, const Eigen::MatrixXd& q) const {
  const bool transposed = direction == Direction::kTransposed;
  if (!in_contact_ && !has_pairs()) return TimesStiffness(q);
  const Eigen::Index num_rows = has_pairs() ? pairs_->num_rows() : 0;
  Eigen::MatrixXd v = num_rows == 0 ? q : q.topRows(q.rows() - num_rows);
  if (in_contact_ && transposed) elimination_->AddFrictionTransposed(&v);
  Eigen::MatrixXd result = TimesStiffness(v);
  if (has_pairs()) pairs_->SubtractForces(transposed, q.bottomRows(num_rows), &result);
  if (in_contact_) {
    if (!transposed) elimination_->AddFriction(&result);
    elimination_->Project(&result);
    elimination_->AddSlipStiffness(q, &result);
  }
  return has_pairs() ? Stacked(std::move(result), pairs_->TimesRows(transposed, v)) : result;
}

bool StepJacobian::SolveByConjugateGradients(const Eigen::MatrixXd& right, double tolerance, Eigen::MatrixXd* q) {
  Eigen::VectorXd solution;
  const ConjugateGradientResult result = ConjugateGradients(
      [&](const Eigen::VectorXd& v) -> Eigen::VectorXd { return ApplyReduced(Direction::kForward, v); },
      [&](const Eigen::VectorXd& v) -> Eigen::VectorXd { return ApplyFactor(v); }, right.col(0), tolerance,
      kMaxLaggedIterations, &solution);
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
  if (!has_pairs() && !has_coupling() && right.cols() == 1) return SolveByConjugateGradients(right, tolerance, q);
  const bool has_alternative = !factor_is_of_point_ && tolerance > kFewDigits;
  const int most = has_alternative && has_pairs() ? kMaxLaggedPairIterations : MostIterations();
  const GmresResult result =
      Gmres([&](const Eigen::MatrixXd& v) { return ApplyReduced(direction, v); },
            [&](const Eigen::MatrixXd& v) { return Precondition(v); }, right, tolerance, {most, has_alternative}, q);
  iterations_ = result.iterations;
  if (!result.converged || (has_pairs() && !q->allFinite())) return false;
  if (direction == Direction::kTransposed || factor_is_of_point_ || right.cols() != 1) return true;
  // What the inertia test of a factor of this point would have found.
  if (!has_pairs()) return right.col(0).dot(q->col(0)) > 0.0;
  const Eigen::VectorXd dv = q->col(0).head(3 * model_.num_free());
  return dv.dot(TimesStiffness(dv).col(0)) >= 0.0;
}

int StepJacobian::MostIterations() const {
  if (!factor_is_of_point_) return kMaxLaggedIterations;
  return has_pairs() ? kMaxPairIterations : kMaxKrylovIterations;
}

bool StepJacobian::Solve(const StepColumns& right, double tolerance, StepColumns* solution) {
  const ScopedTimer timer(&seconds_.solution);
  iterations_ = 0;
  if (method_ == Method::kLu) {
    lu_->Solve(right.velocities, &solution->velocities);
    solution->impulses = right.impulses;
    return solution->velocities.allFinite();
  }
  Eigen::MatrixXd momentum = right.velocities, known, rows, q;
  if (may_have_pairs()) {
    Eigen::MatrixXd impulse = pairs_->KnownMomentum(right.impulses);
    AddImpulse(&impulse);
    momentum += impulse;
    rows = pairs_->RightRows(right.impulses);
  }
  if (in_contact_) {
    known = elimination_->KnownPart(momentum);
    momentum = elimination_->ReducedRight(momentum, known, TimesStiffness(known));
    if (has_pairs()) rows -= pairs_->TimesRows(false, known);
  }
  if (!SolveReduced(Direction::kForward, Stacked(std::move(momentum), rows), tolerance, &q)) return false;
  const Eigen::MatrixXd lambda = q.bottomRows(rows.rows());
  solution->velocities = TopRows(std::move(q), rows.rows());
  if (in_contact_) solution->velocities += known;
  solution->impulses =
      may_have_pairs() ? pairs_->Impulses(lambda, right.impulses, solution->velocities) : right.impulses;
  return true;
}

// In the reduced system the multipliers of pairs are negated: both directions then have the same signs.
bool StepJacobian::SolveTransposed(const StepColumns& right, double tolerance, StepColumns* z, Eigen::MatrixXd* y) {
  const ScopedTimer timer(&seconds_.solution);
  iterations_ = 0;
  if (method_ == Method::kLu) {
    lu_->SolveTransposed(right.velocities, &z->velocities);
    z->impulses = right.impulses;
    *y = z->velocities;
    if (in_contact_) elimination_->AddImpulseTransposed(y);
    return z->velocities.allFinite();
  }
  Eigen::MatrixXd momentum = right.velocities, rows, q;
  if (may_have_pairs()) {
    momentum -= pairs_->KnownMomentumTransposed(right.impulses);
    rows = pairs_->RightRowsTransposed(right.impulses);
  }
  Eigen::MatrixXd projected = momentum;
  if (in_contact_) elimination_->Project(&projected);
  if (!SolveReduced(Direction::kTransposed, Stacked(std::move(projected), rows), tolerance, &q)) return false;
  const Eigen::MatrixXd lambda = q.bottomRows(rows.rows());
  *y = z->velocities = TopRows(std::move(q), rows.rows());
  if (in_contact_) {
    elimination_->AddFrictionTransposed(y);
    Eigen::MatrixXd balance = TimesStiffness(*y);
    if (has_pairs()) pairs_->SubtractForces(true, lambda, &balance);
    z->velocities = elimination_->RecoverAdjoint(momentum, z->velocities, balance);
  }
  z->impulses = may_have_pairs() ? pairs_->AdjointImpulses(-lambda, right.impulses, *y) : right.impulses;
  return true;
}

void StepJacobian::AddImpulse(Eigen::MatrixXd* vectors) const {
  if (in_contact_) elimination_->AddImpulse(vectors);
}

}  // namespace clothid
