#include "costs/rows/reflected_rows.h"

namespace clothid {

Eigen::MatrixXd ReflectedJacobian(const Eigen::VectorXd& residuals, Eigen::MatrixXd jacobian) {
  const Eigen::Index last = residuals.size() - 1;
  if (residuals[last] >= 0.0 && residuals.head(last).isZero(0.0)) return jacobian;
  const double sign = residuals[last] >= 0.0 ? 1.0 : -1.0;
  Eigen::VectorXd v = residuals;
  v[last] += sign * residuals.norm();
  const Eigen::RowVectorXd shares = (2.0 / v.squaredNorm()) * (v.transpose() * jacobian);
  jacobian.noalias() -= v * shares;
  return -sign * jacobian;
}

}  // namespace clothid
