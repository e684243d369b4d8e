#include "identify/base/fit_stage.h"

#include <iomanip>
#include <sstream>

namespace clothid {

std::string FitStage::Words() const {
  std::ostringstream text;
  text << std::setprecision(3);
  if (share < 1.0) {
    text << "first " << 100.0 * share << " % of the time";
  } else {
    text << "all frames";
  }
  if (memory > 0.0) text << ", corrected with a memory of " << memory << " s";
  if (step_factor != 1.0) text << ", time step times " << step_factor;
  if (is_weighed) text << ", weighed by the errors of the model";
  if (precision == Precision::kLoose) text << ", loosely";
  text << ": parameters";
  if (with_starts) text << ", starts";
  if (field_modes > 0) text << ", fields";
  if (field_modes > 0 && field_modes < kAllModes) text << " in " << field_modes << " x " << field_modes << " modes";
  if (with_weights) text << ", smoothness";
  return text.str();
}

const char* StageStateName(StageState state) {
  switch (state) {
    case StageState::kAhead:
      return "ahead";
    case StageState::kRunning:
      return "running";
    case StageState::kDone:
      return "done";
    case StageState::kSkipped:
      break;
  }
  return "skipped";
}

}  // namespace clothid
