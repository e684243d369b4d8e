#include "sim/rollout/step_record.h"

#include <cstdio>

namespace clothid {

std::string StepFailure::ToString() const {
  const std::string what = "step " + std::to_string(step) + " " + reason;
  if (tolerance == 0.0) return what;
  char numbers[160];
  std::snprintf(numbers, sizeof(numbers), ": relative residual %.2e, tolerance %.2e, %d stick, %d slip, %d free",
                residual, tolerance, num_stick, num_slip, num_take_off);
  return what + numbers;
}

}  // namespace clothid
