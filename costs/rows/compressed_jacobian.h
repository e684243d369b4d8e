// [J e] of any number of rows, kept as p + 1 rows with the same cost, gradient and Gauss-Newton matrix.
#ifndef CLOTHID_COSTS_ROWS_COMPRESSED_JACOBIAN_H_
#define CLOTHID_COSTS_ROWS_COMPRESSED_JACOBIAN_H_

#include <Eigen/Core>

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

}  // namespace clothid

#endif  // CLOTHID_COSTS_ROWS_COMPRESSED_JACOBIAN_H_
