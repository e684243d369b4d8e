// The rollout of a whole scene by a program, which may take long.
#ifndef CLOTHID_TOOLS_BASE_SCENE_ROLLOUT_H_
#define CLOTHID_TOOLS_BASE_SCENE_ROLLOUT_H_

#include <atomic>
#include <string>

#include "sim/rollout/rollout.h"
#include "sim/rollout/simulator.h"
#include "sim/scene/scene.h"
#include "tools/base/count_progress.h"

namespace clothid {

// Every step of a rollout is kept. Throws `Error` (kUsage), led by `source`, where the machine cannot hold even the
// positions and velocities of them: it would end the process without a word.
void CheckRolloutMemory(const std::string& source, double num_nodes, double num_steps, Integrator integrator);

// Tells on stderr, while it lives, where a rollout stands that takes long.
class StepProgress {
 public:
  StepProgress();
  RolloutOptions options(int num_steps);

 private:
  CountProgress progress_;
};

// All of the scene of `simulator`, `num_steps` steps, with the parameters `truth`, into `rollout`. `interrupted` is
// that of `CatchInterrupts` (sim/base/program.h). Returns an exit code: where that is not kExitSuccess, `rollout` is
// not to be used, and a line on stderr, led by `program`, says why.
int SimulateScene(const std::string& program, const Parameters& truth, int num_steps, Simulator* simulator,
                  const std::atomic<bool>& interrupted, Rollout* rollout);

// Tells on stderr, in a line led by `program`, where the integrator has made energy.
void WarnOfEnergy(const std::string& program, const Rollout& rollout, Simulator* simulator);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BASE_SCENE_ROLLOUT_H_
