// [J e] of any number of rows, kept as p + 1 rows with the same cost, gradient and Gauss-Newton matrix.
#ifndef CLOTHID_COSTS_ROWS_COMPRESSED_JACOBIAN_H_
#define CLOTHID_COSTS_ROWS_COMPRESSED_JACOBIAN_H_

#include <Eigen/Core>
#include <vector>

#include "costs/rows/rollout_evaluation.h"

namespace clothid {

// A running QR factorisation: after any number of calls to `Add`, with [J e] the rows added so far,
//   [J e] = Q R,  R [(p + 1) x (p + 1)] upper triangular,
// so the rows of R have R_J^T R_J = J^T J, R_J^T R_e = J^T e, |R_e| = |e|. Memory does not grow with the number of
// rows.
class CompressedJacobian {
 public:
  explicit CompressedJacobian(int num_parameters);

  // jacobian [r x p], residuals [r].
  void Add(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& residuals);
  // R: its first p columns are the Jacobian, its last column the residual.
  const Eigen::MatrixXd& Factor();

 private:
  void Reduce();

  int num_columns_;
  Eigen::MatrixXd rows_;  // the factor on top, rows not yet reduced below
  Eigen::Index num_rows_;
  Eigen::MatrixXd factor_;
};

// The rows of R as those of the coordinates `active`, the first of the p columns, with zeros below up to `num_rows` >=
// p + 1. Throws `std::runtime_error` where the Jacobian is not finite.
ResidualRows CompressedRows(const std::vector<int>& active, int num_rows, CompressedJacobian* compressed);

}  // namespace clothid

#endif  // CLOTHID_COSTS_ROWS_COMPRESSED_JACOBIAN_H_
