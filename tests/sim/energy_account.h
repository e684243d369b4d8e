// What contacts and integrator did to the energy of a rollout, beside what it changed by.
#ifndef CLOTHID_TESTS_SIM_ENERGY_ACCOUNT_H_
#define CLOTHID_TESTS_SIM_ENERGY_ACCOUNT_H_

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cstddef>

#include "sim/rollout/contact_work.h"
#include "sim/rollout/energy_loss.h"
#include "sim/rollout/record_reader.h"
#include "sim/rollout/rollout.h"
#include "sim/rollout/simulator.h"
#include "sim/scene/scene.h"

namespace clothid {

// Of the first steps of a scene with its nominal parameters. J.
struct EnergyAccount {
  Simulator simulator;
  Rollout rollout;
  ContactWork contact;
  double loss = 0.0;  // of the integrator
  double start_energy = 0.0, change = 0.0;

  EnergyAccount(const Scene& scene, int num_steps) : simulator(scene) {
    rollout = Simulate(scene.nominal_parameters(), num_steps, &simulator);
    EXPECT_TRUE(rollout.ok()) << rollout.failure->ToString();
    RecordReader reader(rollout, &simulator);
    for (int i = 0; i < static_cast<int>(rollout.records.size()); ++i) {
      if (!rollout.records[static_cast<std::size_t>(i)].ends_step()) continue;  // or a substep
      contact += StepContactWork(rollout, i, &reader, simulator);
      loss += StepEnergyLoss(rollout, i, &reader, simulator).total();
    }
    start_energy = Energy(rollout.initial_positions, rollout.initial_velocities);
    const StepRecord& end = rollout.records.back();
    change = Energy(end.positions, end.velocities) - start_energy;
  }

  // What the change should be of a cloth without air, whose handles nothing but its contacts with itself move.
  double explained() const { return contact.work - contact.friction - loss; }

 private:
  double Energy(const Eigen::VectorXd& positions, const Eigen::VectorXd& velocities) const {
    return StateEnergy(rollout.parameters, positions, velocities, simulator, 0.0).total();
  }
};

}  // namespace clothid

#endif  // CLOTHID_TESTS_SIM_ENERGY_ACCOUNT_H_
