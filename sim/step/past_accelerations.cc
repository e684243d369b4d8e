#include "sim/step/past_accelerations.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace clothid {

void PastAccelerations::Clear() {
  for (Past& past : pasts_) past = {};
}

void PastAccelerations::Add(Stage stage, Eigen::VectorXd acceleration) {
  Past& past = pasts_[static_cast<std::size_t>(stage)];
  if (past.last.size() > 0) {
    const Eigen::VectorXd change = acceleration - past.last;
    const double of_none = acceleration.squaredNorm(), of_last = change.squaredNorm();
    past.guess = of_last < of_none ? Kind::kLast : Kind::kNone;
    if (past.before.size() > 0 && (change - (past.last - past.before)).squaredNorm() < std::min(of_none, of_last)) {
      past.guess = Kind::kLine;
    }
  }
  past.before.swap(past.last);
  past.last = std::move(acceleration);
  last_stage_ = stage;
}

Eigen::VectorXd PastAccelerations::Guess(Stage stage) const {
  const Past& same = pasts_[static_cast<std::size_t>(stage)];
  if (same.last.size() == 0) return pasts_[static_cast<std::size_t>(last_stage_)].last;
  switch (same.guess) {
    case Kind::kNone:
      return {};
    case Kind::kLast:
      return same.last;
    case Kind::kLine:
      return 2.0 * same.last - same.before;
  }
  return {};
}

}  // namespace clothid
