// Options of a fit by sensitivities.
#ifndef CLOTHID_TESTS_IDENTIFY_SENSITIVITY_FIT_H_
#define CLOTHID_TESTS_IDENTIFY_SENSITIVITY_FIT_H_

#include <string>
#include <utility>
#include <vector>

#include "identify/base/options.h"

namespace clothid {

inline FitOptions OptionsFor(std::vector<std::string> parameters) {
  FitOptions options;
  options.parameters = std::move(parameters);
  options.jacobian = JacobianMethod::kSensitivity;
  return options;
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_IDENTIFY_SENSITIVITY_FIT_H_
