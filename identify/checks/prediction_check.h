// Is the simulation at the estimate one that could be?
#ifndef CLOTHID_IDENTIFY_CHECKS_PREDICTION_CHECK_H_
#define CLOTHID_IDENTIFY_CHECKS_PREDICTION_CHECK_H_

#include <atomic>
#include <vector>

#include "datasets/motion/recorded_motion.h"
#include "identify/estimate/fit_summary.h"
#include "identify/problem/problem.h"
#include "sim/rollout/energy_gain.h"
#include "sim/rollout/self_contact_audit.h"

namespace clothid {

// Of every recording.
struct PredictionCheck {
  std::vector<EnergyGain> energy;
  std::vector<SelfContactAudit> self_contact;
};

// What the rollout of every recording gains of energy at the estimate, and how its cloth stays out of itself. `motions`
// are those of `problem`. One rollout each, of those where it may make a difference (`MayGainEnergy`). `cancel` (may be
// null) ends it with what it has.
PredictionCheck CheckPredictions(const std::vector<RecordedMotion>& motions, const FitProblem& problem,
                                 const FitSummary& summary, const std::atomic<bool>* cancel);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_CHECKS_PREDICTION_CHECK_H_
