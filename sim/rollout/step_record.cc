#include "sim/rollout/step_record.h"

#include <cstdio>

#include "sim/cloth/cloth_model.h"
#include "sim/contact/step_contacts.h"

namespace clothid {

ContactSet RestoreContacts(const StepRecord& record, const Eigen::VectorXd& start_positions,
                           const std::vector<ObstacleMotion>& motions, const Parameters& parameters,
                           const ClothModel& model) {
  return RestoreContacts(record.contacts,
                         {start_positions, record.velocities, record.time_step, record.times().gap_time()}, motions,
                         parameters, model);
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
