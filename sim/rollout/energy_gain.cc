#include "sim/rollout/energy_gain.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "sim/cloth/cloth_model.h"
#include "sim/force/membrane.h"
#include "sim/rollout/contact_work.h"
#include "sim/rollout/energy_loss.h"
#include "sim/rollout/record_reader.h"
#include "sim/rollout/simulator.h"

namespace clothid {

const char* EnergyGain::remedy() const {
  return push > 0.5 * energy
             ? "parts of the cloth that came too near each other are pushed apart; shorten the steps"
             : "the steps are too long for so stiff a cloth; shorten them, or take the integrator euler";
}

EnergyGain FindEnergyGain(const Rollout& rollout, Simulator* simulator) {
  const EnergyParts start = StateEnergy(rollout.parameters, rollout.initial_positions, rollout.initial_velocities,
                                        *simulator, rollout.start_time);
  EnergyGain gain;
  gain.time = rollout.start_time;
  gain.largest_energy = start.kinetic + start.elastic();
  RecordReader reader(rollout, simulator);
  double sum = 0.0, push = 0.0;
  for (int i = 0; i < static_cast<int>(rollout.records.size()); ++i) {
    if (!rollout.records[static_cast<std::size_t>(i)].ends_step()) continue;
    sum -= StepEnergyLoss(rollout, i, &reader, *simulator).total();
    if (simulator->scene().self_contact) push += StepContactWork(rollout, i, &reader, *simulator).push;
    const StepRecord& record = reader.record(i);
    const EnergyParts end =
        StateEnergy(rollout.parameters, record.positions, record.velocities, *simulator, record.time);
    gain.largest_energy =
        std::max(gain.largest_energy, end.kinetic + end.elastic() + std::abs(end.gravitational - start.gravitational));
    if (sum + push <= gain.energy) continue;
    gain.energy = sum + push;
    gain.push = push;
    gain.time = record.time;
  }
  return gain;
}

bool MayGainEnergy(const Parameters& parameters, const Simulator& simulator) {
  const Scene& scene = simulator.scene();
  if (scene.self_contact) return true;
  if (scene.integrator != Integrator::kSdirk2) return false;
  const ClothModel& model = simulator.model();
  const double stiffness = model.forces().Find<MembraneTerm>()->membrane().SystemStiffness(parameters.material);
  const double inertia = parameters.material.areal_inertia() * model.nodes().mass_areas().minCoeff();
  return stiffness * scene.time_step * scene.time_step >= kStiffStep * inertia;
}

}  // namespace clothid
