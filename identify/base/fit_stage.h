// The stages of a fit as data: what identify/fit/plan.h makes, progress lines tell and result.json keeps.
#ifndef CLOTHID_IDENTIFY_BASE_FIT_STAGE_H_
#define CLOTHID_IDENTIFY_BASE_FIT_STAGE_H_

#include <string>
#include <vector>

#include "costs/prediction/rollout_cost_options.h"

namespace clothid {

// What becomes of a stage.
enum class StageState {
  kAhead,
  kRunning,
  kDone,
  kSkipped,
};

// One stage of the plan of a fit (identify/fit/plan.h).
struct FitStage {
  double share = 1.0;   // of the time that was recorded: the first frames
  double memory = 0.0;  // s, of rollouts that the recordings correct (costs/assimilation/assimilation.h); 0: none are
  Precision precision = Precision::kFull;
  bool is_trial = false;      // of a memory, of which the longest that serves is wanted
  bool is_rough = false;      // ends where the next step is short; the next stage goes on
  bool with_starts = false;   // the unknowns of starts are free beside the parameters
  int field_modes = 0;        // and fields in modes of fewer half waves a side; 0: they are not
  bool with_weights = false;  // and the weights of what is believed to be smooth are chosen
  bool is_weighed = false;    // frames count for less where the model errs
  double step_factor = 1.0;   // of the time step of the recordings

  StageState state = StageState::kAhead;
  std::string note;   // why it was skipped or how it ended, one line
  int rollouts = 0;   // that it took
  double cost = 0.0;  // the lowest at its end; of first frames, of theirs

  // Whether anything moves but the parameters.
  bool is_joint() const { return with_starts || field_modes > 0 || with_weights; }
  // "first 12.5 % of the time, loosely: parameters", "all frames: parameters, starts".
  std::string Words() const;
};
using FitPlan = std::vector<FitStage>;

inline constexpr int kAllModes = 1 << 20;  // as a number of half waves

// "ahead", "running", "done" or "skipped".
const char* StageStateName(StageState state);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_BASE_FIT_STAGE_H_
