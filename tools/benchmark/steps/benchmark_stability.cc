#include "tools/benchmark/steps/benchmark_stability.h"

#include <algorithm>
#include <cmath>

#include "identify/base/parallel_for.h"
#include "identify/landscape/landscape.h"
#include "sim/base/error.h"
#include "sim/rollout/simulator.h"

namespace clothid {
namespace {

// A row to come.
struct StabilityPlan {
  std::string name;
  std::function<Scene(int nodes)> scene;
  Integrator integrator;
};

void PlanGrid(Integrator integrator, const StabilityOptions& options, std::vector<StabilityPlan>* plans) {
  for (const std::string& scene : options.scenes) {
    const bool has_obstacle = StabilitySceneHasObstacle(scene);
    const std::size_t num_contacts = has_obstacle ? options.contacts.size() : 1;
    const std::size_t num_frictions = has_obstacle ? options.friction_coefficients.size() : 1;
    for (std::size_t c = 0; c < num_contacts; ++c) {
      const bool by_velocity = has_obstacle && options.contacts[c] == "velocity";
      if (by_velocity && StabilitySceneMeetsItself(scene)) continue;
      const ContactMode mode = by_velocity ? ContactMode::kVelocity : ContactMode::kGap;
      for (const double stiffness : options.stretch_stiffness) {
        for (const int rate : options.step_rates) {
          for (std::size_t m = 0; m < num_frictions; ++m) {
            const StabilityCell cell = {scene,
                                        mode,
                                        stiffness,
                                        1.0 / rate,
                                        options.friction_coefficients[m],
                                        Integrator::kEuler,
                                        options.stiffening};
            plans->push_back({scene, [cell](int nodes) { return MakeStabilityScene(cell, nodes); }, integrator});
          }
        }
      }
    }
  }
}

bool IncludesSetting(const StabilityOptions& options, const std::string& setting) {
  return std::find(options.settings.begin(), options.settings.end(), setting) != options.settings.end();
}

// Of what the row is about; NaN: there is no contact.
double FrictionOf(const Scene& scene) {
  if (scene.self_contact) return scene.self_contact->friction_coefficient;
  return scene.obstacles.empty() ? kNoNumber : scene.obstacles.front().friction_coefficient;
}

// A scene that cannot be used makes a row with its error.
StabilityRow RunStabilityRow(const std::string& name, const Scene& scene) {
  StabilityRow row;
  row.name = name;
  row.contact = ContactModeName(scene.contact_mode);
  row.integrator = IntegratorName(scene.integrator);
  row.stretch_stiffness = std::max(scene.material.stretch_stiffness, scene.material.warp_stiffness);
  row.time_step = scene.time_step;
  row.friction_coefficient = FrictionOf(scene);
  row.meets_itself = scene.self_contact.has_value();
  row.num_steps = scene.num_steps();
  try {
    Simulator simulator(scene);
    const Rollout rollout = Simulate(scene.nominal_parameters(), row.num_steps, &simulator);
    if (!rollout.ok()) row.error = rollout.failure->ToString();
    row.counts = rollout.counts;
    row.audit = AuditRollout(rollout, row.num_steps, &simulator);
    if (row.audit.not_finite == 0) row.gain = FindEnergyGain(rollout, &simulator);
  } catch (const Error& error) {
    row.error = error.what();
  }
  return row;
}

}  // namespace

void StabilityOptions::Validate() const {
  std::vector<std::string> known = {"grid", "extremes"};
  for (const StabilityExtreme& extreme : StabilityExtremes()) known.push_back(extreme.name);
  RequireKnown(settings, known, "--settings");
  RequireKnown(integrators, kIntegratorNames, "--integrator");
  RequireKnown(scenes, kStabilityScenes, "--scene");
  RequireKnown(contacts, {"gap", "velocity"}, "--contact");
  for (const double k : stretch_stiffness) ExpectUsage(k > 0.0, "--k_stretch: expected numbers > 0");
  for (const int rate : step_rates) {
    ExpectUsage(rate >= 1 && rate <= 100000, "--steps: expected numbers from 1 to 100000");
  }
  ExpectUsage(stiffening >= 0.0, "--stiffening: expected a number >= 0");
  for (const double mu : friction_coefficients) ExpectUsage(mu >= 0.0, "--mu: expected numbers >= 0");
  ExpectUsage(nodes >= 4 && nodes <= 200, "--nodes: expected one number from 4 to 200");
  ExpectUsage(num_threads >= 1, "--threads: expected a number >= 1");
}

StabilityBenchmark RunStabilityBenchmark(const StabilityOptions& options) {
  options.Validate();
  std::vector<StabilityPlan> plans, extremes;
  for (const std::string& name : options.integrators) {
    const Integrator integrator = IntegratorNamed(name);
    if (IncludesSetting(options, "grid")) PlanGrid(integrator, options, &plans);
    for (const StabilityExtreme& extreme : StabilityExtremes()) {
      if (IncludesSetting(options, "extremes") || IncludesSetting(options, extreme.name)) {
        extremes.push_back({extreme.name, extreme.scene, integrator});
      }
    }
  }
  const auto num_cells = static_cast<std::ptrdiff_t>(plans.size());
  plans.insert(plans.end(), extremes.begin(), extremes.end());
  const int num_rows = static_cast<int>(plans.size());
  std::vector<StabilityRow> rows(plans.size());
  ParallelFor(
      num_rows, options.num_threads,
      [&](int i) {
        Scene scene = plans[i].scene(options.nodes);
        scene.integrator = plans[i].integrator;
        rows[i] = RunStabilityRow(plans[i].name, scene);
      },
      [&](int i, int num_done) {
        if (!options.on_progress) return;
        options.on_progress(DescribeRow(rows[i]) + ": " + (rows[i].ok() ? "ok" : rows[i].error), num_done, num_rows);
      });
  return {{rows.begin(), rows.begin() + num_cells}, {rows.begin() + num_cells, rows.end()}};
}

std::string StabilityCsv(const StabilityBenchmark& benchmark) {
  std::string csv =
      "name,contact,integrator,k_stretch,time_step,mu,steps,done,failed_steps,error,fallbacks,substeps,"
      "newton_iterations,factorizations,contacts,joined,left,switches,silent,not_finite,inconsistent,unsolved,too_deep,"
      "missing,worst_residual,loosest_tolerance,penetration_m,largest_energy_j,energy_gain_j,energy_gain,gain_time,"
      "self_contacts,pair_changes,second_solves,dependent_steps,intersections,cut_steps,violation_m,push_j\n";
  std::vector<StabilityRow> rows = benchmark.grid;
  rows.insert(rows.end(), benchmark.extremes.begin(), benchmark.extremes.end());
  for (const StabilityRow& row : rows) {
    const RolloutCounts& counts = row.counts;
    const RolloutAudit& audit = row.audit;
    const SelfContactAudit& itself = audit.self_contact;
    csv +=
        CsvLine(row.name, row.contact, row.integrator, row.stretch_stiffness, row.time_step, row.friction_coefficient,
                row.num_steps, counts.steps, counts.failed_steps, row.ok() ? "" : "\"" + row.error + "\"",
                counts.fallbacks, counts.substeps, counts.newton_iterations, counts.factorizations, counts.contacts,
                counts.nodes_joined, counts.nodes_left, counts.branch_switches, audit.violations(), audit.not_finite,
                audit.inconsistent, audit.unsolved, audit.too_deep, audit.missing_steps, audit.worst_residual,
                audit.loosest_tolerance, audit.penetration, row.gain.largest_energy, row.gain.energy, row.gain.share(),
                row.gain.time, counts.self_contacts, counts.pair_changes, counts.second_solves, itself.dependent_steps,
                itself.intersections, itself.num_cut, itself.violation, itself.push);
  }
  return csv;
}

}  // namespace clothid
