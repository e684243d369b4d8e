#include "sim/rollout/record_reader.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

#include "sim/rollout/simulator.h"

namespace clothid {

const StepRecord& RecordReader::record(int i) {
  if (rollout_.records[i].is_kept()) return rollout_.records[i];
  if (i < first_record_ || i >= first_record_ + static_cast<int>(segment_.size())) SimulateSegmentOf(i);
  return segment_[i - first_record_];
}

const Eigen::VectorXd& RecordReader::start_positions(int i) {
  return i == 0 ? rollout_.initial_positions : record(i - 1).positions;
}

const Eigen::VectorXd& RecordReader::start_velocities(int i) {
  return i == 0 ? rollout_.initial_velocities : record(i - 1).velocities;
}

void RecordReader::SimulateSegmentOf(int i) {
  const std::vector<int>& last_record = rollout_.last_record;
  const int interval = rollout_.checkpoint_interval;
  // Steps are counted from 1 by AdvanceSegment, from 0 by last_record.
  const int step = static_cast<int>(std::lower_bound(last_record.begin(), last_record.end(), i) - last_record.begin());
  const int num_steps_before = step / interval * interval, last_step = num_steps_before + interval;
  first_record_ = num_steps_before == 0 ? 0 : last_record[num_steps_before - 1] + 1;
  segment_.clear();
  const StepVisitor append = [this](int, std::vector<StepRecord> records) {
    for (StepRecord& record : records) {
      record.factor.reset();  // too large to hold for a whole segment
      segment_.push_back(std::move(record));
    }
  };
  RolloutCounts counts;
  std::optional<StepFailure> failure;
  const bool ok = AdvanceSegment(rollout_.parameters, num_steps_before + 1, last_step, start_positions(first_record_),
                                 start_velocities(first_record_), rollout_.ends_with_factors, /*followed=*/nullptr,
                                 append, simulator_, nullptr, &counts, &failure);
  const StepRecord& checkpoint = rollout_.records[last_record[last_step - 1]];
  if (!ok || segment_.back().positions != checkpoint.positions || segment_.back().velocities != checkpoint.velocities) {
    throw std::runtime_error("the steps before the checkpoint at step " + std::to_string(last_step) +
                             " are not those of this simulator");
  }
}

}  // namespace clothid
