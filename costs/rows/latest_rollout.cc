#include "costs/rows/latest_rollout.h"

namespace clothid {

void LatestRollout::Drop() {
  const Precision kept = precision;
  *this = LatestRollout();
  precision = kept;
}

void LatestRollout::DropUnless(Precision wanted) {
  if (precision != wanted) Drop();
  precision = wanted;
}

void LatestRollout::Resume(const Eigen::VectorXd& point, Precision wanted) {
  if (IsAt(point) && precision == wanted && !is_pending) return;
  rollout = Rollout();
  coordinates = point;
  precision = wanted;
  is_pending = true;
}

}  // namespace clothid
