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
// With the factor of another point: where it takes more, a new factor is cheaper.
constexpr int kMaxLaggedIterations = 24;
// Preconditioners from this size on are in single precision: 24 x 24 nodes have 0.7 to 2 MB. Smaller ones are not
// waited for, and would gain less than a twentieth.
constexpr std::size_t kSinglePrecisionBytes = 512 * 1024;

}  // namespace

std::size_t ReducedFactor::bytes() const {
  return (cholesky == nullptr ? 0 : cholesky->bytes()) + frames.size() * sizeof(LocalFrame) +
         (pattern == nullptr ? 0 : pattern->bytes());
}

StepJacobian::StepJacobian(const ClothModel& model) : model_(model), cholesky_(model.pattern()) {
  if (model.has_contact()) elimination_ = std::make_unique<ContactElimination>();
}

void StepJacobian::SetNumThreads(int num_threads) {
  num_threads_ = num_threads;
  const bool shares = num_threads > 1 && cholesky_.has_branches();
  team_ = shares ? std::make_unique<ThreadTeam>(num_threads) : nullptr;
}

void StepJacobian::SetPoint(const BlockMatrix& hessian, const std::vector<Contact>& contacts,
                            const std::vector<double>& friction_coefficients) {
  method_ = Method::kReduced;
  hessian_ = &hessian;
  factor_is_of_point_ = false;
  in_contact_ = !contacts.empty();
  if (!in_contact_) return;
  const ScopedTimer timer(&seconds_.contact);
  elimination_->SetContacts(contacts, model_.free_index(), friction_coefficients);
}

void StepJacobian::SetFactor(std::shared_ptr<const ReducedFactor> factor) {
  if (factor != factor_) preconditioner_.Set(nullptr);
  factor_ = std::move(factor);
  factor_is_of_point_ = false;
}

bool StepJacobian::Factor(Method method) {
  method_ = method;
  if (in_contact_) {
    const ScopedTimer timer(&seconds_.contact);
    if (method == Method::kLu) {
      elimination_->FullJacobian(*hessian_, &values_);
    } else {
      elimination_->Reduce(*hessian_, &values_);
    }
  }
  const Eigen::VectorXd& values = in_contact_ ? values_ : hessian_->values;
  const ScopedTimer timer(&seconds_.factorization);
  if (method == Method::kLu) {
    if (lu_ == nullptr) lu_ = std::make_unique<LuFactor>(model_.pattern());
    return lu_->Factor(values);
  }
  factor_.reset();  // first, so that its memory can be used again
  preconditioner_.Set(nullptr);
  ReducedFactor factor{cholesky_.Factor(values, team_.get()), {}};
  if (factor.cholesky == nullptr) return false;
  if (in_contact_) factor.frames = elimination_->SlipFrames();
  factor_ = std::make_shared<const ReducedFactor>(std::move(factor));
  factor_is_of_point_ = true;
  return true;
}

bool StepJacobian::Factor(Method method, const BlockMatrix& hessian, const std::vector<Contact>& contacts,
                          const std::vector<double>& friction_coefficients) {
  SetPoint(hessian, contacts, friction_coefficients);
  return Factor(method);
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

// Z^T (I + mu t n^T) K Z + kappa b b^T, or its transpose; K itself without contacts.
Eigen::MatrixXd StepJacobian::ApplyReduced(Direction direction, const Eigen::MatrixXd& q) const {
  if (!in_contact_) return MultiplySymmetric(*hessian_, q, team_.get());
  Eigen::MatrixXd v = q;
  if (direction == Direction::kTransposed) elimination_->AddFrictionTransposed(&v);
  Eigen::MatrixXd result = MultiplySymmetric(*hessian_, v, team_.get());
  if (direction == Direction::kForward) elimination_->AddFriction(&result);
  elimination_->Project(&result);
  elimination_->AddSlipStiffness(q, &result);
  return result;
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
  if (factor_is_of_point_ && !has_coupling()) {
    *q = ApplyFactor(right);
    return true;
  }
  if (!has_coupling() && right.cols() == 1) return SolveByConjugateGradients(right, tolerance, q);
  const GmresResult result = Gmres([&](const Eigen::MatrixXd& v) { return ApplyReduced(direction, v); },
                                   [&](const Eigen::MatrixXd& v) { return ApplyFactor(v); }, right, tolerance,
                                   factor_is_of_point_ ? kMaxKrylovIterations : kMaxLaggedIterations, q);
  iterations_ = result.iterations;
  // What the inertia test of a factor of this point would have found.
  const bool negative_curvature = direction == Direction::kForward && !factor_is_of_point_ && right.cols() == 1 &&
                                  right.col(0).dot(q->col(0)) <= 0.0;
  return result.converged && !negative_curvature;
}

bool StepJacobian::Solve(const Eigen::MatrixXd& right, double tolerance, Eigen::MatrixXd* dv) {
  const ScopedTimer timer(&seconds_.solution);
  iterations_ = 0;
  if (method_ == Method::kLu) {
    lu_->Solve(right, dv);
    return dv->allFinite();
  }
  if (!in_contact_) return SolveReduced(Direction::kForward, right, tolerance, dv);
  const Eigen::MatrixXd known = elimination_->KnownPart(right);
  const Eigen::MatrixXd matrix_known = MultiplySymmetric(*hessian_, known, team_.get());
  if (!SolveReduced(Direction::kForward, elimination_->ReducedRight(right, known, matrix_known), tolerance, dv)) {
    return false;
  }
  *dv += known;
  return true;
}

bool StepJacobian::SolveTransposed(const Eigen::MatrixXd& right, double tolerance, Eigen::MatrixXd* z,
                                   Eigen::MatrixXd* y) {
  const ScopedTimer timer(&seconds_.solution);
  iterations_ = 0;
  if (method_ == Method::kLu) {
    lu_->SolveTransposed(right, z);
    *y = *z;
    if (in_contact_) elimination_->AddImpulseTransposed(y);
    return z->allFinite();
  }
  if (!in_contact_) {
    if (!SolveReduced(Direction::kTransposed, right, tolerance, z)) return false;
    *y = *z;
    return true;
  }
  Eigen::MatrixXd projected = right, q;
  elimination_->Project(&projected);
  if (!SolveReduced(Direction::kTransposed, projected, tolerance, &q)) return false;
  *y = q;
  elimination_->AddFrictionTransposed(y);
  *z = elimination_->RecoverAdjoint(right, q, MultiplySymmetric(*hessian_, *y, team_.get()));
  return true;
}

void StepJacobian::AddImpulse(Eigen::MatrixXd* vectors) const {
  if (in_contact_) elimination_->AddImpulse(vectors);
}

}  // namespace clothid
