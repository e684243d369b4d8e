#include "sim/rollout/step_record.h"

#include <cstdio>

#include "sim/contact/contact_set.h"
#include "sim/step/step_problem.h"

namespace clothid {

ContactSet RestoreContacts(const StepRecord& record, const Eigen::VectorXd& start_positions,
                           const std::vector<ObstacleMotion>& motions, const Parameters& parameters,
                           const ClothModel& model) {
  return {RestoreContacts(model, parameters, start_positions, record.times(), motions, record.contacts),
          RestorePairs(model, parameters, start_positions, record.velocities, record.times(), record.pairs)};
}

std::string StepFailure::ToString() const {
  const std::string what = "step " + std::to_string(step) + " " + reason;
  if (tolerance == 0.0) return what;
  char numbers[160];
  std::snprintf(numbers, sizeof(numbers), ": relative residual %.2e, tolerance %.2e, %d stick, %d slip, %d free",
                residual, tolerance, num_stick, num_slip, num_take_off);
  return what + numbers;
}

}  // namespace clothid
