#include "identify/checks/energy_check.h"

#include <cstddef>

#include "costs/prediction/recording_model.h"

namespace clothid {

std::vector<EnergyGain> CheckEnergy(const std::vector<RecordedMotion>& motions, const FitProblem& problem,
                                    const FitSummary& summary, const std::atomic<bool>* cancel) {
  std::vector<EnergyGain> gains;
  for (int r = 0; r < problem.num_recordings(); ++r) {
    const RecordingModel& fitted = problem.cost(r).model();
    RecordingModel model(motions[static_cast<std::size_t>(r)], fitted.blocks(), {}, fitted.shared_start(),
                         problem.fields());
    gains.push_back(model.EnergyGainAt(problem.CoordinatesOf(r, summary.coordinates), cancel));
  }
  return gains;
}

}  // namespace clothid
