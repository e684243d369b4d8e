// Where an evaluation of one recording stands, for those who wait for it.
#ifndef CLOTHID_COSTS_PREDICTION_PASS_STEP_H_
#define CLOTHID_COSTS_PREDICTION_PASS_STEP_H_

#include <functional>

namespace clothid {

// An evaluation is made of passes over all steps of a rollout.
enum class RolloutPass {
  kRollout,       // the simulation alone
  kForwardSweep,  // the simulation with its sensitivities
  kReverseSweep,  // the adjoint, from the last step to the first; with checkpoints the steps between them, too
};

// One more step of a pass is done.
struct PassStep {
  RolloutPass pass = RolloutPass::kRollout;
  int num_done = 0;  // steps of this pass, from 1 to num_steps, whichever way it goes
  int num_steps = 0;
  int passes_left = 0;  // that the evaluation needs after this one
};

// Called on the thread of the evaluation. It cannot change what comes out.
using PassObserver = std::function<void(const PassStep&)>;

}  // namespace clothid

#endif  // CLOTHID_COSTS_PREDICTION_PASS_STEP_H_
