// benchmark stability: where the simulation fails, gains energy or has a wrong gradient: a grid over integrator,
// stiffness, time step, friction, contact mode and scene, and extreme scenes one at a time
// (tools/benchmark/steps/stability_extremes.h).
//
// A cell of the grid is one rollout of 0.3 s of a scene of tools/benchmark/steps/stability_scene.h. It is audited
// (tools/benchmark/steps/rollout_audit.h) and balanced (tools/benchmark/steps/energy_balance.h), and its gradient is
// checked (tools/benchmark/steps/stability_gradient.h). A scene without obstacle has one cell per integrator,
// stiffness and time step.
#ifndef CLOTHID_TOOLS_BENCHMARK_STEPS_BENCHMARK_STABILITY_H_
#define CLOTHID_TOOLS_BENCHMARK_STEPS_BENCHMARK_STABILITY_H_

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tools/benchmark/base/integrators.h"
#include "tools/benchmark/steps/stability_row.h"
#include "tools/benchmark/steps/stability_scene.h"

namespace clothid {

struct StabilityOptions {
  std::vector<std::string> settings = {"grid", "extremes"};  // of these two and names of extremes
  std::vector<std::string> integrators = kIntegratorNames;   // of both
  std::vector<std::string> scenes = kStabilityScenes;        // of the grid, as all that follows up to its axes' end
  std::vector<std::string> contacts = {"gap", "velocity"};
  std::vector<double> stretch_stiffness = {1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7};  // N/m
  std::vector<int> step_rates = {1000, 200, 60, 30};                                 // steps per second
  std::vector<double> friction_coefficients = {0.0, 0.1, 0.35, 0.8, 2.0};
  int nodes = 12;  // along each axis
  bool check_gradients = true;
  std::uint64_t seed = 1;  // of the functionals whose gradients are checked
  int num_threads = 1;     // rows side by side; results do not depend on it
  // After every row. May be empty.
  std::function<void(const StabilityRow& last, int num_done, int num_rows)> on_row;

  // Throws `Error` (kUsage) naming the first flag out of range.
  void Validate() const;
};

struct StabilityBenchmark {
  std::vector<StabilityRow> grid;      // by integrator, scene, contact mode, stiffness, time step, friction
  std::vector<StabilityRow> extremes;  // by integrator, in their order
};

// Throws `Error` for options that cannot be used.
StabilityBenchmark RunStabilityBenchmark(const StabilityOptions& options);

// The grid by scene, contact mode and stiffness, soft (k <= 1e4) and stiff; the extremes; every row that failed, with
// its message, gained energy, or whose gradient could not be checked, with the reason.
std::string StabilityTable(const StabilityBenchmark& benchmark);

// One row per cell, which tools/plots/plot_stability draws; one per extreme.
std::string StabilityCsv(const StabilityBenchmark& benchmark);
std::string StabilityExtremesCsv(const StabilityBenchmark& benchmark);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_STEPS_BENCHMARK_STABILITY_H_
