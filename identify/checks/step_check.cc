#include "identify/checks/step_check.h"

namespace clothid {

StepCheck CheckStep(const std::vector<RecordedMotion>& motions, const FitOptions& options, const FitProblem& problem,
                    const FitSummary& summary) {
  std::vector<RecordedMotion> halved = motions;
  for (RecordedMotion& motion : halved) motion.scene.time_step *= 0.5;
  return RepeatFit(halved, options, "half_step", problem, summary.coordinates);
}

}  // namespace clothid
