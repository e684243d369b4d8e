#include "tools/base/scene_rollout.h"

#include <unistd.h>

#include <cmath>
#include <iostream>

#include "sim/base/error.h"
#include "sim/base/text_file.h"
#include "sim/rollout/energy_gain.h"

namespace clothid {

void CheckRolloutMemory(const std::string& source, double num_nodes, double num_steps, Integrator integrator) {
  constexpr double kGigabyte = 1 << 30;
  const double bytes = NumStages(integrator) * num_steps * (sizeof(StepRecord) + 6.0 * sizeof(double) * num_nodes);
  const double most = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  if (bytes <= most) return;
  throw Error(ErrorKind::kUsage, source + ": " + ShortestText(num_steps) + " steps of " + ShortestText(num_nodes) +
                                     " nodes take at least " + std::to_string(std::llround(bytes / kGigabyte)) +
                                     " GB of memory; this machine has " +
                                     std::to_string(std::llround(most / kGigabyte)));
}

StepProgress::StepProgress() : progress_(&std::cerr, isatty(STDERR_FILENO) != 0, "steps", CountProgress::End::kQuiet) {}

RolloutOptions StepProgress::options(int num_steps) {
  RolloutOptions options;
  options.visitor = [this, num_steps](int step, const Eigen::VectorXd&) {
    if (step > 0) progress_.Print(step, num_steps);
  };
  return options;
}

int SimulateScene(const std::string& program, const Parameters& truth, int num_steps, Simulator* simulator,
                  const std::atomic<bool>& interrupted, Rollout* rollout) {
  {
    StepProgress progress;
    *rollout = Simulate(truth, num_steps, simulator, &interrupted, progress.options(num_steps));
  }
  if (interrupted) {
    std::cerr << program << ": interrupted, nothing is written\n";
    return kExitInterrupted;
  }
  if (rollout->ok()) return kExitSuccess;
  std::cerr << program << ": " << rollout->failure->ToString() << "\n";
  return kExitNotConverged;
}

void WarnOfEnergy(const std::string& program, const Rollout& rollout, Simulator* simulator) {
  if (!MayGainEnergy(rollout.parameters, *simulator)) return;
  const EnergyGain gain = FindEnergyGain(rollout, simulator);
  if (!(gain.share() >= kMostEnergyGain)) return;
  std::cerr << program << ": warning: the motion gains energy that no work pays for, " << gain.energy << " J by "
            << gain.time << " s, " << 100.0 * gain.share() << " % of the largest: " << gain.remedy() << "\n";
}

}  // namespace clothid
