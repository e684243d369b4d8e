// The integrators that benchmarks compare, by name.
#ifndef CLOTHID_TOOLS_BENCHMARK_BASE_INTEGRATORS_H_
#define CLOTHID_TOOLS_BENCHMARK_BASE_INTEGRATORS_H_

#include <string>
#include <vector>

#include "sim/scene/scene.h"

namespace clothid {

inline const std::vector<std::string> kIntegratorNames = {"euler", "sdirk2"};

// Throws `Error` (kUsage), naming --integrator, for an unknown name.
Integrator IntegratorNamed(const std::string& name);

// Throws likewise where one of `names` is unknown, or there is none.
void ValidateIntegrators(const std::vector<std::string>& names);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_BASE_INTEGRATORS_H_
