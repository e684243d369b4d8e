#include "sim/rollout/record_reader.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

#include "sim/cloth/cloth_model.h"
#include "sim/rollout/correction.h"
#include "sim/rollout/segment.h"
#include "sim/rollout/simulator.h"
#include "sim/step/second_start.h"
#include "sim/step/step_problem.h"

namespace clothid {

RecordReader::RecordReader(const Rollout& rollout, Simulator* simulator) : rollout_(rollout), simulator_(simulator) {
  simulator->UseParameters(rollout.parameters);
}

const StepRecord& RecordReader::record(int i) {
  if (rollout_.records[i].is_kept()) return rollout_.records[i];
  if (i < first_record_ || i >= first_record_ + static_cast<int>(records_.size())) SimulateSegmentOf(i);
  return records_[i - first_record_];
}

const Eigen::VectorXd& RecordReader::end_positions(int i) {
  if (i < 0) return rollout_.initial_positions;
  const StepRecord& end = record(i);
  return end.correction == nullptr ? end.positions : end.correction->positions;
}

const Eigen::VectorXd& RecordReader::end_velocities(int i) {
  if (i < 0) return rollout_.initial_velocities;
  const StepRecord& end = record(i);
  return end.correction == nullptr ? end.velocities : end.correction->velocities;
}

SolveStart RecordReader::start(int i) {
  if (rollout_.records[i].stage != Stage::kSecond) return {end_positions(i - 1), end_velocities(i - 1)};
  const StepRecord& first = record(i - 1);
  const SolveStart step_start{end_positions(i - 2), end_velocities(i - 2)};
  if (second_record_ != i) {
    const ClothModel& model = simulator_->model();
    second_start_ = StartSecondStage(
        model, rollout_.parameters.material, step_start, first.positions, first.velocities, first.time_step,
        RestoreContacts(first, step_start.positions, ObstacleMotions(model.scene(), rollout_.parameters, first.times()),
                        rollout_.parameters, model));
    second_record_ = i;
  }
  return {second_start_.positions, second_start_.velocities, &step_start.positions, &first.positions};
}

void RecordReader::SimulateSegmentOf(int i) {
  const std::vector<int>& last_record = rollout_.last_record;
  const int interval = rollout_.checkpoint_interval;
  // Steps are counted from 1 by AdvanceSegment, from 0 by last_record.
  const int step = static_cast<int>(std::lower_bound(last_record.begin(), last_record.end(), i) - last_record.begin());
  const int num_steps_before = step / interval * interval, last_step = num_steps_before + interval;
  first_record_ = num_steps_before == 0 ? 0 : last_record[num_steps_before - 1] + 1;
  records_.clear();
  const StepVisitor append = [this](int, std::vector<StepRecord> records) {
    for (StepRecord& record : records) {
      record.factor.reset();  // too large to hold for a whole segment
      records_.push_back(std::move(record));
    }
  };
  Segment segment;
  segment.first_step = num_steps_before + 1;
  segment.last_step = last_step;
  segment.step_tolerance = rollout_.step_tolerance;
  segment.end_with_factors = rollout_.ends_with_factors;
  if (rollout_.handle_offsets.num_handles() > 0) segment.handle_offsets = &rollout_.handle_offsets;
  segment.correction = rollout_.correction.get();
  StepState state{end_positions(first_record_ - 1), end_velocities(first_record_ - 1)};
  const bool ok = AdvanceSegment(rollout_.parameters, segment, append, simulator_, &state).ok();
  const StepRecord& checkpoint = rollout_.records[last_record[last_step - 1]];
  if (!ok || records_.back().positions != checkpoint.positions || records_.back().velocities != checkpoint.velocities) {
    throw std::runtime_error("the steps before the checkpoint at step " + std::to_string(last_step) +
                             " are not those of this simulator");
  }
}

}  // namespace clothid
