// What integrators take and give: the losses of the steps are the change of the energy, and what is gained is found.
#include "sim/rollout/energy_loss.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sim/rollout/energy_gain.h"
#include "sim/rollout/rollout.h"
#include "sim/rollout/simulator.h"
#include "tests/sim/clamped_strip.h"
#include "tests/sim/plain_scenes.h"
#include "tests/sim/shipped_scenes.h"

namespace clothid::energy_loss_test {
namespace {

struct TestRun {
  Simulator simulator;
  Rollout rollout;
  explicit TestRun(const Scene& scene, int checkpoint_interval = 0) : simulator(scene) {
    RolloutOptions options;
    options.checkpoint_interval = checkpoint_interval;
    rollout = Simulate(scene.nominal_parameters(), scene.num_steps(), &simulator, nullptr, options);
    EXPECT_TRUE(rollout.ok()) << rollout.failure->ToString();
  }

  double EnergyAfter(const StepRecord& record) const {
    return StateEnergy(rollout.parameters, record.positions, record.velocities, simulator, record.time).total();
  }
};

// Swings by one edge in still air: no force from outside but gravity does work.
Scene Swing(Integrator integrator) {
  Scene scene = ClothScene(SquareGrid(6, 0.3), 0.01);
  scene.integrator = integrator;
  scene.duration = 0.2;
  scene.handles.nodes = {0, 1, 2, 3, 4, 5};
  scene.material.bending_stiffness = 1e-4;
  scene.material.damping = 0.05;
  return scene;
}

void ExpectLossesToBeTheChange(const Scene& scene) {
  TestRun run(scene);
  RecordReader reader(run.rollout, &run.simulator);
  double lost = 0.0, largest = 0.0;
  for (int i = 0; i < static_cast<int>(run.rollout.records.size()); ++i) {
    if (!run.rollout.records[i].ends_step()) continue;
    const double loss = StepEnergyLoss(run.rollout, i, &reader, run.simulator).total();
    lost += loss;
    largest = std::max(largest, std::abs(loss));
  }
  const Rollout& rollout = run.rollout;
  const double before =
      StateEnergy(rollout.parameters, rollout.initial_positions, rollout.initial_velocities, run.simulator, 0.0)
          .total();
  EXPECT_GT(largest, 1e-6);
  EXPECT_NEAR(run.EnergyAfter(rollout.records.back()), before - lost, 1e-9 * std::abs(before - lost));
}

TEST(EnergyLossTest, IsTheChangeWhereNoForceDoesWork) {
  for (const Integrator integrator : {Integrator::kEuler, Integrator::kSdirk2}) {
    SCOPED_TRACE(IntegratorName(integrator));
    ExpectLossesToBeTheChange(Swing(integrator));
  }
}

// About the row of its handles, which stay where they are.
TEST(EnergyLossTest, CountsAJawThatTurns) {
  for (const Integrator integrator : {Integrator::kEuler, Integrator::kSdirk2}) {
    ClampedStrip strip(SheetKind::kAlternating, 10, 0.0);
    Scene& scene = strip.scene;
    scene.integrator = integrator;
    scene.time_step = 0.002;
    scene.duration = 0.3;
    const auto body =
        PathThrough(0.0, 0.3, 31, NoShift, [](double t) { return Eigen::Vector3d(0.0, 20.0 * t * t, 0.0); });
    ClampHandles({{scene.handles.nodes, std::nullopt, body}}, &scene);
    TestRun run(scene);
    RecordReader reader(run.rollout, &run.simulator);
    double lost = 0.0, work = 0.0;
    for (int i = 0; i < static_cast<int>(run.rollout.records.size()); ++i) {
      if (!run.rollout.records[i].ends_step()) continue;
      lost += StepEnergyLoss(run.rollout, i, &reader, run.simulator).total();
      work += ClampWork(run.rollout, i, &reader, run.simulator);
    }
    EXPECT_GT(work, 1e-6);
    EXPECT_LE(std::abs(lost), (integrator == Integrator::kEuler ? 0.3 : 0.01) * work);
    EXPECT_NEAR(run.EnergyAfter(run.rollout.records.back()), work - lost, 1e-6 * work);
  }
}

TEST(EnergyLossTest, CountsWarpAndWeft) {
  Scene scene = Swing(Integrator::kSdirk2);
  scene.membrane = MembraneLaw::kOrthotropic;
  scene.material.warp_stiffness = 80.0;
  scene.material.weft_stiffness = 50.0;
  scene.material.shear_stiffness = 20.0;
  scene.bending.orthotropic = true;
  scene.material.bending_stiffness = 0.0;
  scene.material.warp_bending = 2e-4;
  scene.material.weft_bending = 1e-4;
  scene.material.twist_bending = 5e-5;
  ExpectLossesToBeTheChange(scene);
}

// So stiff that a step of 33 ms buckles it again and again.
Scene Buckling() {
  Scene scene = ShippedScene("wind", 8);
  scene.integrator = Integrator::kSdirk2;
  scene.bending.law = BendingLaw::kPatches;
  scene.time_step = 1.0 / 30.0;
  scene.duration = 0.3;
  scene.material.stretch_stiffness = 1e8;
  return scene;
}

TEST(EnergyGainTest, IsFoundWhereStepsAreTooLong) {
  TestRun run(Buckling());
  EXPECT_TRUE(MayGainEnergy(run.rollout.parameters, run.simulator));
  const EnergyGain gain = FindEnergyGain(run.rollout, &run.simulator);
  EXPECT_GT(gain.share(), 0.1);
  EXPECT_GT(gain.energy, 0.0);
  EXPECT_GT(gain.time, 0.0);
  TestRun with_checkpoints(Buckling(), 3);
  EXPECT_EQ(FindEnergyGain(with_checkpoints.rollout, &with_checkpoints.simulator).energy, gain.energy);
}

TEST(EnergyGainTest, BackwardEulerGainsNone) {
  Scene scene = Buckling();
  scene.integrator = Integrator::kEuler;
  TestRun run(scene);
  EXPECT_FALSE(MayGainEnergy(run.rollout.parameters, run.simulator));
  EXPECT_LT(FindEnergyGain(run.rollout, &run.simulator).share(), kMostEnergyGain);
}

TEST(EnergyGainTest, ShippedScenesAreNotEvenLookedAt) {
  for (const char* name : {"drape", "wind", "slope"}) {
    Scene scene = ShippedScene(name, 16);
    scene.integrator = Integrator::kSdirk2;
    EXPECT_FALSE(MayGainEnergy(scene.nominal_parameters(), Simulator(scene))) << name;
  }
}

}  // namespace
}  // namespace clothid::energy_loss_test
