// What makes conjugate gradients on fields short: an inverse of nearly H = J^T J + lambda P (field_model.h).
//
// Over the basis V of a curvature (field_posterior.h), parameters included, it is that of H itself; over all other
// modes of the fields, of which the recordings tell little, it is that of the prior alone:
//   M^-1 = V (V^T H V)^-1 V^T + (lambda P')^-1 - V (lambda V^T P' V)^-1 V^T
// P' is P with a little more for the mean. So the number of products hardly grows with that of the control nodes, and
// directions that trade a parameter for a field, in which H is ill-conditioned, cost nothing.
#ifndef CLOTHID_IDENTIFY_FIELD_FIELD_PRECONDITIONER_H_
#define CLOTHID_IDENTIFY_FIELD_FIELD_PRECONDITIONER_H_

#include <Eigen/Core>
#include <Eigen/SparseCholesky>
#include <vector>

#include "identify/field/field_model.h"
#include "identify/field/field_posterior.h"

namespace clothid {

class FieldPreconditioner {
 public:
  // The scalars `held` stay where they are.
  FieldPreconditioner(const FieldCurvature& curvature, double weight, const FieldModel& model,
                      const std::vector<int>& held = {});

  Eigen::VectorXd Solve(const Eigen::VectorXd& v) const;  // M^-1 v [p + n]

 private:
  Eigen::MatrixXd basis_;                                     // V [(p + n) x c]
  Eigen::MatrixXd coarse_;                                    // (V^T H V)^-1 - (lambda V^T P' V)^-1 [c x c]
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> prior_;  // lambda P' [n x n]
};

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_FIELD_FIELD_PRECONDITIONER_H_
