// Rows in the basis in which their residual has one entry, the last.
//
// For any orthogonal H the rows H r, H J have the cost, the gradient J^T r and the Gauss-Newton matrix J^T J of r, J. A
// reflection (Householder 1958) takes r to (0, .., 0, |r|) = |r| u:
//   H = s (I - 2 v v^T/(v^T v)),   v = r + s' |r| u,   s' = 1 where the last entry of r is >= 0, else -1,   s = -s',
// with the sign that does not cancel. Rows that read so already stay as they are, bit by bit.
#ifndef CLOTHID_COSTS_ROWS_REFLECTED_ROWS_H_
#define CLOTHID_COSTS_ROWS_REFLECTED_ROWS_H_

#include <Eigen/Core>

namespace clothid {

// H J [r x q] for the residuals [r] and their Jacobian J [r x q].
Eigen::MatrixXd ReflectedJacobian(const Eigen::VectorXd& residuals, Eigen::MatrixXd jacobian);

}  // namespace clothid

#endif  // CLOTHID_COSTS_ROWS_REFLECTED_ROWS_H_
