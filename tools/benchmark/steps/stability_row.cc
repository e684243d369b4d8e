#include "tools/benchmark/steps/stability_row.h"

#include <iomanip>
#include <limits>
#include <sstream>

#include "sim/base/error.h"
#include "sim/rollout/simulator.h"
#include "identify/landscape/landscape.h"

namespace clothid {
namespace {

// Messages have commas, and none has a quote.
std::string Quoted(const std::string& text) { return text.empty() ? "" : "\"" + text + "\""; }

constexpr double kStageError = 0.01;  // of the largest energy

constexpr const char* kCheckedParameters[] = {"k_stretch", "mu", "k_bend", "drag"};

const ComponentCheck* FindComponent(const StabilityGradient& gradient, const std::string& parameter) {
  for (const ComponentCheck& check : gradient.components) {
    if (check.parameter == parameter) return &check;
  }
  return nullptr;
}

}  // namespace

bool StabilityRow::gains_energy() const {
  const double tolerance =
      integrator == IntegratorName(Integrator::kSdirk2) ? kStageError * energy.largest_energy : 0.0;
  return energy.excess > energy.total.tolerance + tolerance;
}

StabilityRow RunStabilityRow(const std::string& name, const Scene& scene, std::optional<std::uint64_t> gradient_seed) {
  StabilityRow row;
  row.name = name;
  row.contact = ContactModeName(scene.contact_mode);
  row.integrator = IntegratorName(scene.integrator);
  row.stretch_stiffness = scene.material.stretch_stiffness;
  row.time_step = scene.time_step;
  row.friction_coefficient =
      scene.obstacles.empty() ? std::numeric_limits<double>::quiet_NaN() : scene.obstacles.front().friction_coefficient;
  row.num_steps = scene.num_steps();
  try {
    Simulator simulator(scene);
    const Rollout rollout = Simulate(scene.nominal_parameters(), row.num_steps, &simulator);
    if (!rollout.ok()) row.error = rollout.failure->ToString();
    row.counts = rollout.counts;
    row.audit = AuditRollout(rollout, row.num_steps, &simulator);
    row.energy = BalanceEnergy(rollout, &simulator);
    if (gradient_seed) row.gradient = CheckGradient(scene, *gradient_seed);
  } catch (const Error& error) {
    row.error = error.what();
  }
  return row;
}

std::string StabilityCsvHeader() {
  std::string header =
      "name,contact,integrator,k_stretch,time_step,mu,steps,done,failed_steps,error,fallbacks,substeps,newton_"
      "iterations,"
      "factorizations,contacts,joined,left,switches,silent,not_finite,inconsistent,unsolved,too_deep,missing,"
      "unexplained,worst_residual,loosest_tolerance,penetration_m,start_energy_j,largest_energy_j,energy_change_j,"
      "force_work_j,"
      "air_work_j,handle_work_j,contact_work_j,push_work_j,contact_gain_j,inertia_loss_j,damping_loss_j,elastic_loss_j,"
      "unexplained_j,tolerance_j,energy_gain_j,energy_excess_j,energy_excess,excess_time,checkable,gradient_error,"
      "reasons";
  for (const char* parameter : kCheckedParameters) {
    for (const char* value : {"adjoint_m", "difference_m", "step", "settled", "error"}) {
      header += std::string(",") + parameter + "_" + value;
    }
  }
  return header + "\n";
}

std::string StabilityCsvLine(const StabilityRow& row) {
  std::ostringstream out;
  out << std::setprecision(10);
  const RolloutCounts& counts = row.counts;
  out << row.name << "," << row.contact << "," << row.integrator << "," << row.stretch_stiffness << "," << row.time_step
      << "," << row.friction_coefficient << "," << row.num_steps << "," << counts.steps << "," << counts.failed_steps
      << "," << Quoted(row.error) << "," << counts.fallbacks << "," << counts.substeps << ","
      << counts.newton_iterations << "," << counts.factorizations << "," << counts.contacts << ","
      << counts.nodes_joined << "," << counts.nodes_left << "," << counts.branch_switches;
  const RolloutAudit& audit = row.audit;
  out << "," << row.silent_failures() << "," << audit.not_finite << "," << audit.inconsistent << "," << audit.unsolved
      << "," << audit.too_deep << "," << audit.missing_steps << "," << row.energy.unexplained_steps << ","
      << audit.worst_residual << "," << audit.loosest_tolerance << "," << audit.penetration;
  const EnergyBalance& energy = row.energy;
  const EnergyFlow& flow = energy.total;
  for (const double value :
       {energy.start_energy, energy.largest_energy, flow.change, flow.force_work, flow.air_work, flow.handle_work,
        flow.contact_work, flow.push_work, energy.contact_gain, flow.loss.inertia, flow.loss.damping, flow.loss.elastic,
        flow.unexplained(), flow.tolerance, energy.gain, energy.excess, energy.relative_excess(), energy.excess_time}) {
    out << "," << value;
  }
  out << "," << row.gradient.is_checkable() << "," << row.gradient.error() << "," << Quoted(row.gradient.Reasons());
  for (const char* parameter : kCheckedParameters) {
    const ComponentCheck* check = FindComponent(row.gradient, parameter);
    for (double ComponentCheck::*const value :
         {&ComponentCheck::adjoint, &ComponentCheck::difference, &ComponentCheck::step, &ComponentCheck::settled,
          &ComponentCheck::error}) {
      out << "," << (check == nullptr ? std::numeric_limits<double>::quiet_NaN() : check->*value);
    }
  }
  out << "\n";
  return out.str();
}

}  // namespace clothid
