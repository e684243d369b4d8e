#include "identify/checks/step_check.h"

#include <cmath>

namespace clothid {

StepCheck CheckStep(const std::vector<RecordedMotion>& motions, const FitOptions& options, const FitProblem& problem,
                    const FitSummary& summary) {
  std::vector<RecordedMotion> halved = motions;
  for (RecordedMotion& motion : halved) motion.scene.time_step *= 0.5;
  FitOptions repeat = options;
  repeat.estimate_uncertainty = false;
  repeat.on_iteration = nullptr;
  repeat.journal_tag = "half_step";
  // Made from the same starting values, because bounds that are not given depend on them.
  FitProblem half_problem(halved, repeat);
  half_problem.SetStart(summary.coordinates);
  const FitSummary half = Fit(repeat, &half_problem);

  StepCheck check;
  check.status = half.status;
  check.statistics = half.statistics;
  if (!half.has_estimate()) return check;
  check.values = half.values();
  check.rmse = half.error.rmse();
  check.changes = half.coordinates - summary.coordinates;
  for (int i = 0; i < problem.num_blocks(); ++i) {
    const ParameterBlock& block = problem.blocks()[i];
    check.changes[i] =
        block.scale == ParameterScale::kLog ? std::expm1(check.changes[i]) : block.unit * check.changes[i];
  }
  return check;
}

}  // namespace clothid
