#include "identify/experiment/informed_start.h"

#include <algorithm>

#include "sim/matrix/dense.h"

namespace clothid {

// With [J_s; U] = Q R the singular values of J_s R^-1 are sqrt(l/(1 + l)).
Eigen::MatrixXd InformedDirections(const Eigen::MatrixXd& measured, const Eigen::MatrixXd& believed) {
  const Eigen::Index n = measured.cols(), num_rows = measured.rows() + believed.rows();
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(std::max(num_rows, n), n);
  all.topRows(num_rows) << measured, believed;
  const Eigen::MatrixXd whitening =
      UpperFactor(all).triangularView<Eigen::Upper>().solve(Eigen::MatrixXd::Identity(n, n));
  if (!whitening.allFinite()) return Eigen::MatrixXd::Identity(n, n);
  Eigen::MatrixXd told = Eigen::MatrixXd::Zero(std::max(measured.rows(), n), n);
  told.topRows(measured.rows()) = measured * whitening;
  const RightSingular singular = RightSingularVectors(told);
  const Eigen::Index count = (singular.values.array().square() > 0.5).count();
  return whitening * singular.vectors.leftCols(count);
}

}  // namespace clothid
