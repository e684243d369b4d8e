// What a rollout has gained of energy that no work pays for.
#ifndef CLOTHID_SIM_ROLLOUT_ENERGY_GAIN_H_
#define CLOTHID_SIM_ROLLOUT_ENERGY_GAIN_H_

#include "sim/rollout/rollout.h"
#include "sim/scene/parameters.h"

namespace clothid {

class Simulator;

// What a rollout has gained without a source, as far as it came: the negative `StepEnergyLoss`, and what parts of the
// cloth gain where they push each other apart (`ContactWork::push`).
struct EnergyGain {
  double energy = 0.0;          // J, at most: the largest of the sums over the first steps; 0: it never gains
  double time = 0.0;            // s, of the step up to which it has gained that
  double largest_energy = 0.0;  // J, of kinetic and elastic energy, and of what gravitational energy has changed by
  double push = 0.0;            // J, that part of `energy` which parts of the cloth gain by pushing each other apart

  double share() const { return energy > 0.0 ? energy / largest_energy : 0.0; }
  const char* remedy() const;  // a clause: where most of it comes from, and what to do
};
// The share that is still an error like others of a time step.
inline constexpr double kMostEnergyGain = 0.01;
EnergyGain FindEnergyGain(const Rollout& rollout, Simulator* simulator);

// False where a rollout of the scene cannot gain energy that is worth a look: of a cloth that does not meet itself, by
// backward Euler, and by SDIRK2 as long as k h^2/(rho a), with the stiffness of the membrane and the smallest area of a
// node, is below kStiffStep. Measured, gains of 1 % begin at 10 to 20 times that (tools/benchmark/README.md, "Stiff and
// extreme cases").
inline constexpr double kStiffStep = 1e5;
bool MayGainEnergy(const Parameters& parameters, const Simulator& simulator);

}  // namespace clothid

#endif  // CLOTHID_SIM_ROLLOUT_ENERGY_GAIN_H_
