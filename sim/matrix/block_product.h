// The product of a symmetric block matrix with columns, the innermost loop of every iterative solve.
#ifndef CLOTHID_SIM_MATRIX_BLOCK_PRODUCT_H_
#define CLOTHID_SIM_MATRIX_BLOCK_PRODUCT_H_

#include <Eigen/Core>

#include "sim/base/thread_team.h"
#include "sim/matrix/block_matrix.h"

namespace clothid {

// product <- matrix * columns, [n x s]; `matrix` must be symmetric. `product` must not be `columns`. `team` (may be
// null) shares the work of a large matrix; the numbers do not depend on it.
void MultiplySymmetric(const BlockMatrix& matrix, const Eigen::Ref<const Eigen::MatrixXd>& columns,
                       Eigen::MatrixXd* product, ThreadTeam* team = nullptr);
Eigen::MatrixXd MultiplySymmetric(const BlockMatrix& matrix, const Eigen::Ref<const Eigen::MatrixXd>& columns,
                                  ThreadTeam* team = nullptr);

}  // namespace clothid

#endif  // CLOTHID_SIM_MATRIX_BLOCK_PRODUCT_H_
