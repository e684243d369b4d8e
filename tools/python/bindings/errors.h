// The exceptions of the module.
#ifndef CLOTHID_TOOLS_PYTHON_BINDINGS_ERRORS_H_
#define CLOTHID_TOOLS_PYTHON_BINDINGS_ERRORS_H_

#include <stdexcept>
#include <string>

#include "sim/base/error.h"

namespace clothid {

// A simulation or a fit that came to no result: clothid.SimulationError.
class SimulationFailure : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// "NAME: MESSAGE", clothid.UsageError.
[[noreturn]] inline void FailArgument(const std::string& name, const std::string& message) {
  throw Error(ErrorKind::kUsage, name + ": " + message);
}

}  // namespace clothid

#endif  // CLOTHID_TOOLS_PYTHON_BINDINGS_ERRORS_H_
