// Does the simulation at the estimate make energy?
#ifndef CLOTHID_IDENTIFY_CHECKS_ENERGY_CHECK_H_
#define CLOTHID_IDENTIFY_CHECKS_ENERGY_CHECK_H_

#include <atomic>
#include <vector>

#include "datasets/motion/recorded_motion.h"
#include "identify/fit/fit_summary.h"
#include "identify/problem/problem.h"
#include "sim/rollout/energy_gain.h"

namespace clothid {

// What the rollout of every recording gains by its integrator at the estimate. `motions` are those of `problem`. One
// rollout each, of those whose stiffness and time step may make a difference (`MayGainEnergy`). `cancel` (may be null)
// ends it with what it has.
std::vector<EnergyGain> CheckEnergy(const std::vector<RecordedMotion>& motions, const FitProblem& problem,
                                    const FitSummary& summary, const std::atomic<bool>* cancel);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_CHECKS_ENERGY_CHECK_H_
