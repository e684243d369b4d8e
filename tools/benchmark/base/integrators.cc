#include "tools/benchmark/base/integrators.h"

#include "sim/base/error.h"
#include "sim/base/text_file.h"

namespace clothid {

Integrator IntegratorNamed(const std::string& name) {
  for (const Integrator integrator : {Integrator::kEuler, Integrator::kSdirk2}) {
    if (name == IntegratorName(integrator)) return integrator;
  }
  throw Error(ErrorKind::kUsage, "--integrator: '" + Printable(name) + "': expected euler or sdirk2");
}

void ValidateIntegrators(const std::vector<std::string>& names) {
  if (names.empty()) throw Error(ErrorKind::kUsage, "--integrator: expected at least one integrator");
  for (const std::string& name : names) IntegratorNamed(name);
}

}  // namespace clothid
