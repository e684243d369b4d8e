// J D of identify/uncertainty/uncertainty.h over some of the parameters, decomposed: the inverse of its normal matrix
// and its singular directions, also where it is singular.
#ifndef CLOTHID_IDENTIFY_UNCERTAINTY_SCALED_JACOBIAN_H_
#define CLOTHID_IDENTIFY_UNCERTAINTY_SCALED_JACOBIAN_H_

#include <Eigen/Core>
#include <vector>

#include "costs/prediction/parameter_block.h"

namespace clothid {

class ScaledJacobian {
 public:
  // `jacobian` [r x p] of all `blocks` [p]; `indices` [k]: those to take, in whose order the numbers below count.
  ScaledJacobian(const std::vector<ParameterBlock>& blocks, const Eigen::MatrixXd& jacobian, std::vector<int> indices);

  Eigen::Index size() const { return ranges_.size(); }  // k
  const std::vector<int>& indices() const { return indices_; }
  const Eigen::VectorXd& singular_values() const { return singular_values_; }  // decreasing

  // ((J D)^T J D)^-1 at (i, j), infinite where a direction of singular value zero takes part.
  double Inverse(Eigen::Index i, Eigen::Index j) const;
  // (J^T J)^-1 at (i, j): the covariance of q, for s = 1.
  double Covariance(Eigen::Index i, Eigen::Index j) const { return ranges_[i] * Inverse(i, j) * ranges_[j]; }
  // Entry i of (J^T J)^-1 `vector` [p].
  double Solve(Eigen::Index i, const Eigen::VectorXd& vector) const;
  // The same of every column of `vectors` [p x T]: [1 x T].
  Eigen::RowVectorXd SolveRow(Eigen::Index i, const Eigen::MatrixXd& vectors) const;
  double VisibleChange(Eigen::Index i) const;
  // Of q, for s = 1.
  double CoordinateStd(Eigen::Index i) const;

  // The k-th right singular vector as a change of q [p], its largest entry 1.
  Eigen::VectorXd Direction(Eigen::Index k, Eigen::Index num_blocks) const;

 private:
  std::vector<int> indices_;
  Eigen::VectorXd ranges_;
  Eigen::VectorXd singular_values_;
  Eigen::MatrixXd vectors_;
};

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_UNCERTAINTY_SCALED_JACOBIAN_H_
