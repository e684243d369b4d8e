// Where the evaluation under way stands, over all recordings of a fit, and how long it will take yet.
#ifndef CLOTHID_IDENTIFY_BASE_EVALUATION_PROGRESS_H_
#define CLOTHID_IDENTIFY_BASE_EVALUATION_PROGRESS_H_

#include <functional>
#include <mutex>
#include <vector>

#include "costs/prediction/pass_step.h"

namespace clothid {

enum class EvaluationPurpose {
  kFit,       // a point of the optimiser
  kInterval,  // what the uncertainty of an estimate takes
};

struct EvaluationProgress {
  int evaluation = 0;  // its number, from 1 on; those that simulate nothing do not count
  EvaluationPurpose purpose = EvaluationPurpose::kFit;
  int recording = 0;  // from 0 on, the one that the step is of
  int num_recordings = 0;
  PassStep step;
  int num_done = 0;      // steps of the evaluation, of all recordings and passes
  double seconds = 0.0;  // since the evaluation began
  // An estimate: as if every step that is left, of all recordings and passes, took as long as those so far. Reverse
  // sweeps are quicker than rollouts, steps in contact slower than free ones, and the first steps wait for what is set
  // up once.
  double seconds_left = 0.0;
};

// Told after every step, on the thread of the step, but never twice at a time.
using ProgressObserver = std::function<void(const EvaluationProgress&)>;

// Follows the evaluations of one problem. Steps and ends may come from several threads.
class EvaluationTracker {
 public:
  using Clock = std::function<double()>;  // s, from any origin on; never falls

  EvaluationTracker(ProgressObserver observer, Clock clock);

  void AddRecording(int num_steps);       // of one of its passes
  void Begin(EvaluationPurpose purpose);  // of the next evaluation; no other is under way
  void AddStep(int recording, const PassStep& step);
  void End(int recording);  // no more steps come from it

 private:
  struct Recording {
    int num_steps = 0;
    bool has_begun = false, has_ended = false;
    double steps_left = 0.0;  // where it has begun
  };
  double StepsLeft() const;

  ProgressObserver observer_;
  Clock clock_;
  std::mutex mutex_;
  std::vector<Recording> recordings_;
  EvaluationProgress progress_;
  double start_ = 0.0;  // s
  int num_done_ = 0;    // steps
  int num_passes_ = 1;  // of a recording that has yet to begin, as far as others tell
};

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_BASE_EVALUATION_PROGRESS_H_
