// One scene of `benchmark stability` run and looked at: one row of its files.
#ifndef CLOTHID_TOOLS_BENCHMARK_STEPS_STABILITY_ROW_H_
#define CLOTHID_TOOLS_BENCHMARK_STEPS_STABILITY_ROW_H_

#include <cstdint>
#include <optional>
#include <string>

#include "sim/rollout/rollout.h"
#include "sim/scene/scene.h"
#include "tools/benchmark/steps/energy_balance.h"
#include "tools/benchmark/steps/rollout_audit.h"
#include "tools/benchmark/steps/stability_gradient.h"

namespace clothid {

struct StabilityRow {
  std::string name;  // of the scene or the extreme
  std::string contact;
  std::string integrator;
  double stretch_stiffness = 0.0;     // N/m
  double time_step = 0.0;             // s
  double friction_coefficient = 0.0;  // NaN: no obstacle
  int num_steps = 0;                  // that the rollout was to have
  std::string error;                  // why the scene was refused or where its rollout failed; empty: it has ended
  RolloutCounts counts;
  RolloutAudit audit;
  EnergyBalance energy;
  StabilityGradient gradient;  // empty where it was not asked for

  bool ok() const { return error.empty(); }
  // Beyond the tolerance of the balance, and with SDIRK2 beyond 1 % of the largest energy: the error of its steps,
  // which may go either way.
  bool gains_energy() const;
  // Solves that claim to be right and are not, whatever became of the rollout.
  int silent_failures() const { return audit.violations() + energy.unexplained_steps; }
};

// A scene that cannot be used makes a row with its error. `gradient_seed`: of the functional whose gradient is checked;
// none: it is not.
StabilityRow RunStabilityRow(const std::string& name, const Scene& scene, std::optional<std::uint64_t> gradient_seed);

// The columns of a row, with a new line.
std::string StabilityCsvHeader();
std::string StabilityCsvLine(const StabilityRow& row);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_STEPS_STABILITY_ROW_H_
