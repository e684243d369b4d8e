#include "datasets/observation/model_error.h"

#include <algorithm>
#include <cmath>

namespace clothid {

Eigen::VectorXd ErrorCurve::SharesAt(double time) const {
  Eigen::VectorXd shares = Eigen::VectorXd::Zero(times.size());
  const Eigen::Index after = std::upper_bound(times.begin(), times.end(), time) - times.begin();
  if (after == 0 || after == times.size()) {
    shares[after == 0 ? 0 : after - 1] = 1.0;
    return shares;
  }
  const double share = (time - times[after - 1]) / (times[after] - times[after - 1]);
  shares[after - 1] = 1.0 - share;
  shares[after] = share;
  return shares;
}

double ErrorCurve::DeviationAt(double time) const {
  return times.size() == 0 ? 0.0 : std::sqrt(SharesAt(time).dot(variances));
}

}  // namespace clothid
