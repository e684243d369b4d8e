// benchmark stability: where the simulation fails or gains energy: a grid over integrator, stiffness, time step,
// friction, contact mode and scene, and extreme scenes one at a time (tools/benchmark/steps/stability_scene.h).
//
// Every rollout is found out again from its records (tools/benchmark/steps/rollout_audit.h), and what it gained of
// energy (sim/rollout/energy_gain.h), and whether a cloth that meets itself stays out of itself after every step
// (sim/rollout/self_contact_audit.h). A scene without obstacle has one cell per integrator, stiffness and time step.
#ifndef CLOTHID_TOOLS_BENCHMARK_STEPS_BENCHMARK_STABILITY_H_
#define CLOTHID_TOOLS_BENCHMARK_STEPS_BENCHMARK_STABILITY_H_

#include <string>
#include <vector>

#include "sim/rollout/energy_gain.h"
#include "sim/rollout/rollout.h"
#include "tools/benchmark/base/common.h"
#include "tools/benchmark/steps/rollout_audit.h"
#include "tools/benchmark/steps/stability_scene.h"

namespace clothid {

// One scene, run and looked at.
struct StabilityRow {
  std::string name;  // of the scene or the extreme
  std::string contact;
  std::string integrator;
  double stretch_stiffness = 0.0;     // N/m
  double time_step = 0.0;             // s
  double friction_coefficient = 0.0;  // NaN: no obstacle; where the cloth meets itself, that of the cloth
  bool meets_itself = false;
  int num_steps = 0;  // that the rollout was to have
  std::string error;  // why the scene was refused or where its rollout failed; empty: it has ended
  RolloutCounts counts;
  RolloutAudit audit;  // whose violations are silent failures
  EnergyGain gain;

  bool ok() const { return error.empty(); }
  bool gains_energy() const { return gain.share() > kMostEnergyGain; }
};

struct StabilityOptions {
  std::vector<std::string> settings = {"grid", "extremes"};  // of these two and names of extremes
  std::vector<std::string> integrators = kIntegratorNames;   // of both
  std::vector<std::string> scenes = kStabilityScenes;        // of the grid, as all that follows up to its axes' end
  std::vector<std::string> contacts = {"gap", "velocity"};
  std::vector<double> stretch_stiffness = {1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7};  // N/m
  double stiffening = 0.0;                                                           // of the grid, as of StabilityCell
  std::vector<int> step_rates = {1000, 200, 60, 30};                                 // steps per second
  std::vector<double> friction_coefficients = {0.0, 0.1, 0.35, 0.8, 2.0};
  int nodes = 12;                 // along each axis
  int num_threads = 1;            // rows side by side; results do not depend on it
  BenchmarkProgress on_progress;  // after every row

  // Throws `Error` (kUsage) naming the first flag out of range.
  void Validate() const;
};

struct StabilityBenchmark {
  std::vector<StabilityRow> grid;      // by integrator, scene, contact mode, stiffness, time step, friction
  std::vector<StabilityRow> extremes;  // by integrator, in their order
};

// Throws `Error` for options that cannot be used.
StabilityBenchmark RunStabilityBenchmark(const StabilityOptions& options);

// "drape, gap, sdirk2, k 1000, h 5 ms, mu 0.35".
std::string DescribeRow(const StabilityRow& row);

// The grid by scene, contact mode and stiffness, soft (k <= 1e4) and stiff; where the cloth meets itself, how well it
// stays out of itself; the extremes; every row that failed, with its message, or gained more than 1 % of its largest
// energy.
std::string StabilityTable(const StabilityBenchmark& benchmark);

// One row per cell, which tools/plots/plot_stability draws, and one per extreme.
std::string StabilityCsv(const StabilityBenchmark& benchmark);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_BENCHMARK_STEPS_BENCHMARK_STABILITY_H_
