// Sparse LU factorisation of a matrix that need not be symmetric.
#ifndef CLOTHID_SIM_MATRIX_LU_H_
#define CLOTHID_SIM_MATRIX_LU_H_

#include <Eigen/Core>
#include <memory>

#include "sim/matrix/block_matrix.h"

namespace clothid {

// Sparse LU (UMFPACK) of a matrix with the pattern of `pattern` and any values. Throws
// `std::runtime_error`, which names UMFPACK's routine, where that fails for another reason than a singular matrix, such
// as a lack of memory.
class LuFactor {
 public:
  explicit LuFactor(std::shared_ptr<const BlockPattern> pattern);
  ~LuFactor();
  LuFactor(const LuFactor&) = delete;
  LuFactor& operator=(const LuFactor&) = delete;

  // `values` by columns; false where the matrix is singular.
  bool Factor(const Eigen::VectorXd& values);
  void Solve(const Eigen::MatrixXd& right, Eigen::MatrixXd* solution) const;            // A x = b
  void SolveTransposed(const Eigen::MatrixXd& right, Eigen::MatrixXd* solution) const;  // A^T x = b

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_MATRIX_LU_H_
