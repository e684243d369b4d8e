#include "sim/step_jacobian.h"

namespace clothid {
namespace {

// The friction coupling is a small perturbation; where it takes more, LU is the better solver.
constexpr int kMaxGmresIterations = 60;

}  // namespace

StepJacobian::StepJacobian(const ClothModel& model) : model_(model), cholesky_(model.pattern()) {
  if (model.has_contact()) elimination_ = std::make_unique<ContactElimination>();
}

bool StepJacobian::Factor(Method method, const BlockMatrix& hessian, const std::vector<Contact>& contacts,
                          const std::vector<double>& friction_coefficients) {
  method_ = method;
  hessian_ = &hessian;
  in_contact_ = !contacts.empty();
  if (in_contact_) {
    const ScopedTimer timer(&seconds_.contact);
    elimination_->SetContacts(contacts, model_.free_index(), friction_coefficients);
    if (method == Method::kLu) {
      elimination_->FullJacobian(hessian, &values_);
    } else {
      elimination_->Reduce(hessian, &values_);
    }
  }
  const Eigen::VectorXd& values = in_contact_ ? values_ : hessian.values;
  const ScopedTimer timer(&seconds_.factorization);
  if (method == Method::kReduced) return cholesky_.Factor(values);
  if (lu_ == nullptr) lu_ = std::make_unique<LuFactor>(model_.pattern());
  return lu_->Factor(values);
}

Eigen::MatrixXd StepJacobian::ApplyFactor(const Eigen::MatrixXd& vectors) {
  Eigen::MatrixXd local = vectors, result;
  elimination_->ToLocal(&local);
  cholesky_.Solve(local, &result);
  elimination_->ToWorld(&result);
  elimination_->Project(&result);
  return result;
}

// Z^T (I + mu t n^T) K Z + kappa b b^T, or its transpose.
Eigen::MatrixXd StepJacobian::ApplyReduced(Direction direction, const Eigen::MatrixXd& q) const {
  Eigen::MatrixXd v = q;
  if (direction == Direction::kTransposed) elimination_->AddFrictionTransposed(&v);
  Eigen::MatrixXd result = hessian_->view() * v;
  if (direction == Direction::kForward) elimination_->AddFriction(&result);
  elimination_->Project(&result);
  elimination_->AddSlipStiffness(q, &result);
  return result;
}

bool StepJacobian::SolveReduced(Direction direction, const Eigen::MatrixXd& right, double tolerance,
                                Eigen::MatrixXd* q) {
  if (!elimination_->has_coupling()) {
    *q = ApplyFactor(right);
    return true;
  }
  const GmresResult result =
      Gmres([&](const Eigen::MatrixXd& v) { return ApplyReduced(direction, v); },
            [&](const Eigen::MatrixXd& v) { return ApplyFactor(v); }, right, tolerance, kMaxGmresIterations, q);
  return result.converged;
}

bool StepJacobian::Solve(const Eigen::MatrixXd& right, double tolerance, Eigen::MatrixXd* dv) {
  const ScopedTimer timer(&seconds_.solution);
  if (method_ == Method::kLu) {
    lu_->Solve(right, dv);
    return dv->allFinite();
  }
  if (!in_contact_) {
    cholesky_.Solve(right, dv);
    return true;
  }
  const Eigen::MatrixXd known = elimination_->KnownPart(right);
  const Eigen::MatrixXd matrix_known = hessian_->view() * known;
  if (!SolveReduced(Direction::kForward, elimination_->ReducedRight(right, known, matrix_known), tolerance, dv)) {
    return false;
  }
  *dv += known;
  return true;
}

bool StepJacobian::SolveTransposed(const Eigen::MatrixXd& right, double tolerance, Eigen::MatrixXd* z,
                                   Eigen::MatrixXd* y) {
  const ScopedTimer timer(&seconds_.solution);
  if (method_ == Method::kLu) {
    lu_->SolveTransposed(right, z);
    *y = *z;
    if (in_contact_) elimination_->AddImpulseTransposed(y);
    return z->allFinite();
  }
  if (!in_contact_) {
    cholesky_.Solve(right, z);
    *y = *z;
    return true;
  }
  Eigen::MatrixXd projected = right, q;
  elimination_->Project(&projected);
  if (!SolveReduced(Direction::kTransposed, projected, tolerance, &q)) return false;
  *y = q;
  elimination_->AddFrictionTransposed(y);
  *z = elimination_->RecoverAdjoint(right, q, hessian_->view() * *y);
  return true;
}

void StepJacobian::AddImpulse(Eigen::MatrixXd* vectors) const {
  if (in_contact_) elimination_->AddImpulse(vectors);
}

}  // namespace clothid
