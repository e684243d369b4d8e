#include "identify/field/field_preconditioner.h"

#include "sim/matrix/dense.h"

namespace clothid {
namespace {

// What the smoothest field that is not flat, cos(pi x), has: pi^4, times the squares of the control nodes.
constexpr double kMeanShift = 97.0;

}  // namespace

FieldPreconditioner::FieldPreconditioner(const FieldCurvature& curvature, double weight, const FieldModel& model,
                                         const std::vector<int>& held)
    : basis_(curvature.basis()), coarse_(curvature.Covariance(weight, held)) {
  const Eigen::Index n = model.num_field_unknowns(), c = basis_.cols() - model.num_scalars();
  Eigen::SparseMatrix<double> shifted = weight * model.prior_matrix();
  const double shift = kMeanShift * weight / static_cast<double>(n);
  for (Eigen::Index i = 0; i < n; ++i) shifted.coeffRef(i, i) += shift;
  prior_.compute(shifted);
  const Eigen::MatrixXd of_fields = basis_.bottomRightCorner(n, c);
  const Eigen::MatrixXd believed = of_fields.transpose() * (shifted * of_fields);
  coarse_.bottomRightCorner(c, c) -= SymmetricFactor(believed).Inverse();
}

Eigen::VectorXd FieldPreconditioner::Solve(const Eigen::VectorXd& v) const {
  Eigen::VectorXd solved = basis_ * (coarse_ * (basis_.transpose() * v));
  const Eigen::Index n = prior_.rows();
  solved.tail(n) += prior_.solve(v.tail(n));
  return solved;
}

}  // namespace clothid
