#include "costs/rows/latest_rollout.h"

#include <cstddef>
#include <stdexcept>

#include "sim/base/phase_seconds.h"

namespace clothid {
namespace {

// With fields, products run along a rollout again and again: bytes for its steps, and as many for their factors.
constexpr RolloutStorage kFieldStorage = {std::size_t{512} << 20, /*keep_factors=*/true};

}  // namespace

Rollout LatestRollout::Run(const Eigen::VectorXd& coordinates, Precision precision, int passes_left,
                           Eigen::MatrixXd* predicted, Eigen::MatrixXd* velocities, ForceTrack* forces,
                           CostStatistics* statistics) const {
  const ScopedTimer timer(&statistics->rollout_seconds);
  ++statistics->rollouts;
  const RolloutStorage storage =
      options_->fields.empty() ? RolloutStorage{options_->memory_limit, /*keep_factors=*/false} : kFieldStorage;
  Rollout result =
      model_->Simulate(coordinates, {precision, options_->cancel, passes_left}, storage, predicted, velocities, forces);
  statistics->counts += result.counts;
  if (!result.ok()) throw std::runtime_error(result.failure->ToString());
  return result;
}

const Rollout& LatestRollout::At(const Eigen::VectorXd& coordinates, Precision precision, int passes_left,
                                 CostStatistics* statistics) {
  DropUnless(precision);
  const bool is_known = coordinates_.size() > 0 && coordinates_ == coordinates;
  if (is_known && !is_pending_) return rollout_;
  CostStatistics counted_before;
  coordinates_.resize(0);
  rollout_ = Rollout();
  rollout_ = Run(coordinates, precision, passes_left, &predicted_, &velocities_, &forces_,
                 is_known ? &counted_before : statistics);
  coordinates_ = coordinates;
  precision_ = precision;
  is_pending_ = false;
  return rollout_;
}

void LatestRollout::DropUnless(Precision precision) {
  if (precision == precision_) return;
  precision_ = precision;
  Drop();
}

void LatestRollout::Drop() {
  coordinates_.resize(0);
  rollout_ = Rollout();
  is_pending_ = false;
}

void LatestRollout::Resume(const Eigen::VectorXd& coordinates, Precision precision) {
  const bool is_known =
      coordinates_.size() > 0 && coordinates_.size() == coordinates.size() && coordinates_ == coordinates;
  if (is_known && precision_ == precision && !is_pending_) return;
  rollout_ = Rollout();
  coordinates_ = coordinates;
  precision_ = precision;
  is_pending_ = true;
}

}  // namespace clothid
