#include "identify/base/evaluation_progress.h"

#include <utility>

namespace clothid {

EvaluationTracker::EvaluationTracker(ProgressObserver observer, Clock clock)
    : observer_(std::move(observer)), clock_(std::move(clock)) {}

void EvaluationTracker::AddRecording(int num_steps) {
  Recording recording;
  recording.num_steps = num_steps;
  recordings_.push_back(recording);
  progress_.num_recordings = static_cast<int>(recordings_.size());
}

void EvaluationTracker::Begin(EvaluationPurpose purpose) {
  progress_.purpose = purpose;
  start_ = clock_();
  num_done_ = 0;
  num_passes_ = 1;
  for (Recording& recording : recordings_) recording.has_begun = recording.has_ended = false;
}

void EvaluationTracker::AddStep(int recording, const PassStep& step) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (num_done_ == 0) ++progress_.evaluation;
  Recording& own = recordings_[recording];
  if (!own.has_begun) num_passes_ = 1 + step.passes_left;
  own.has_begun = true;
  own.steps_left = static_cast<double>(step.num_steps) * (1 + step.passes_left) - step.num_done;
  progress_.num_done = ++num_done_;
  progress_.recording = recording;
  progress_.step = step;
  progress_.seconds = clock_() - start_;
  progress_.seconds_left = progress_.seconds / num_done_ * StepsLeft();
  observer_(progress_);
}

void EvaluationTracker::End(int recording) {
  const std::lock_guard<std::mutex> lock(mutex_);
  recordings_[recording].has_ended = true;
}

double EvaluationTracker::StepsLeft() const {
  double steps = 0.0;
  for (const Recording& recording : recordings_) {
    if (recording.has_ended) continue;
    steps += recording.has_begun ? recording.steps_left : static_cast<double>(recording.num_steps) * num_passes_;
  }
  return steps;
}

}  // namespace clothid
