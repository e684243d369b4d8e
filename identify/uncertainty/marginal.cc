#include "identify/uncertainty/marginal.h"

#include <algorithm>
#include <utility>

#include "sim/matrix/dense.h"

namespace clothid {

Marginal Marginalize(Linearization linearization, Eigen::Index num_parameters) {
  Marginal marginal;
  const Eigen::Index p = num_parameters, n = linearization.jacobian.cols() - p;
  marginal.follow = Eigen::MatrixXd::Zero(n, p);
  if (n == 0) {
    marginal.parameters = std::move(linearization);
    return marginal;
  }
  const Eigen::MatrixXd& jacobian = linearization.jacobian;
  Eigen::MatrixXd reordered = Eigen::MatrixXd::Zero(std::max(jacobian.rows(), n + p), n + p);
  reordered.topRows(jacobian.rows()) << jacobian.rightCols(n), jacobian.leftCols(p);
  const Eigen::MatrixXd factor = UpperFactor(reordered);
  marginal.follow = -factor.topLeftCorner(n, n).triangularView<Eigen::Upper>().solve(factor.topRightCorner(n, p));
  linearization.jacobian = factor.bottomRightCorner(p, p);
  linearization.gradient =
      (linearization.gradient.head(p) + marginal.follow.transpose() * linearization.gradient.tail(n)).eval();
  for (Eigen::MatrixXd& scores : linearization.frame_scores) {
    scores = (scores.topRows(p) + marginal.follow.transpose() * scores.bottomRows(n)).eval();
  }
  marginal.parameters = std::move(linearization);
  return marginal;
}

}  // namespace clothid
