#include "identify/checks/prediction_check.h"

#include <cstddef>

#include "costs/prediction/recording_model.h"

namespace clothid {

PredictionCheck CheckPredictions(const std::vector<RecordedMotion>& motions, const FitProblem& problem,
                                 const FitSummary& summary, const std::atomic<bool>* cancel) {
  PredictionCheck check;
  for (int r = 0; r < problem.num_recordings(); ++r) {
    const RecordingModel& fitted = problem.cost(r).model();
    RecordingModel model(motions[static_cast<std::size_t>(r)], fitted.blocks(), {}, fitted.shared_start(),
                         problem.fields());
    RolloutCheck found = model.CheckAt(problem.CoordinatesOf(r, summary.coordinates), cancel);
    check.energy.push_back(found.energy);
    check.self_contact.push_back(found.self_contact);
  }
  return check;
}

}  // namespace clothid
