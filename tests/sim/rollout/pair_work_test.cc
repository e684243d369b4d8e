// What the contacts of a cloth with itself do to its energy, against closed forms, and the balance with them.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>

#include "sim/rollout/energy_gain.h"
#include "tests/sim/energy_account.h"
#include "tests/sim/plain_scenes.h"
#include "tests/sim/self_contact_scenes.h"

namespace clothid::pair_work_test {
namespace {

constexpr double kDensity = 0.15;  // kg/m^2

// By mass over the nodes from `first` on, m.
Eigen::Vector3d MeanWay(const EnergyAccount& account, int first) {
  const Rollout& rollout = account.rollout;
  const Eigen::VectorXd way = rollout.positions(rollout.num_steps()) - rollout.initial_positions;
  const Eigen::Index count = way.size() / 3 - first;
  const Eigen::VectorXd areas = NodeAreas(account.simulator.scene().mesh).tail(count);
  return way.tail(3 * count).reshaped(3, count) * areas / areas.sum();
}

// The mass of the nodes from `first` on, kg.
double MassOf(const Scene& scene, int first) {
  const Eigen::VectorXd areas = NodeAreas(scene.mesh);
  return kDensity * areas.tail(areas.size() - first).sum();
}

class PairWorkTest : public testing::TestWithParam<Integrator> {};

TEST_P(PairWorkTest, FrictionTakesMuTimesTheNormalForceTimesTheWay) {
  const double angle = 25.0 * kPi / 180.0, friction = 0.3;
  const Scene scene = LayersOnASlope(2, angle, friction, GetParam(), 0.005);
  const int first = static_cast<int>(scene.handles.nodes.size());
  const EnergyAccount account(scene, 60);
  const double way = MeanWay(account, first).x();
  EXPECT_GT(way, 0.05);
  const double expected = friction * MassOf(scene, first) * 9.81 * std::cos(angle) * way;
  EXPECT_NEAR(account.contact.friction, expected, 1e-7 * expected);
  EXPECT_EQ(account.contact.work, 0.0);
  EXPECT_LT(account.contact.push, 1e-9 * expected);
  EXPECT_NEAR(account.change, account.explained(), 1e-9 * expected);
}

// The lower layer is drawn away under the upper one, which slips on it and is taken along.
TEST_P(PairWorkTest, AHeldLayerThatMovesDoesTheWork) {
  const double friction = 0.3, speed = 0.2, h = 0.005;
  const int num_steps = 10;
  Scene scene = LayersOnASlope(2, 0.0, friction, GetParam(), h);
  const int first = static_cast<int>(scene.handles.nodes.size());
  Eigen::MatrixXd path(3 * first, 2);
  path.col(0) = scene.initial_positions.head(3 * first);
  path.col(1) = path.col(0) + Eigen::Vector3d(speed, 0.0, 0.0).replicate(first, 1);
  scene.handles.path = HandlePath(Eigen::Vector2d(0.0, 1.0), path);
  scene.initial_velocities.head(3 * first) = Eigen::Vector3d(speed, 0.0, 0.0).replicate(first, 1);
  const EnergyAccount account(scene, num_steps);
  const double force = friction * MassOf(scene, first) * 9.81, way = num_steps * h * speed;
  EXPECT_NEAR(account.contact.work, force * way, 1e-7 * force * way);
  const double behind = way - MeanWay(account, first).x();
  EXPECT_GT(behind, 0.2 * way);
  EXPECT_NEAR(account.contact.friction, force * behind, 1e-7 * force * way);
  EXPECT_NEAR(account.change, account.explained(), 1e-9 * force * way);
}

// Two free sheets collide at an angle, bend and slide on each other.
TEST_P(PairWorkTest, ACollisionCloses) {
  Scene scene = CollidingSheets(GetParam());
  scene.material.bending_stiffness = 1e-5;
  const EnergyAccount account(scene, 20);
  EXPECT_GT(account.contact.friction + account.contact.push, 1e-3 * account.start_energy);
  EXPECT_EQ(account.contact.work, 0.0);
  EXPECT_NEAR(account.change, account.explained(), 1e-9 * account.start_energy);
  EXPECT_LT(account.change, -0.1 * account.start_energy);
}

INSTANTIATE_TEST_SUITE_P(Integrators, PairWorkTest, testing::Values(Integrator::kEuler, Integrator::kSdirk2),
                         [](const auto& test) { return std::string(IntegratorName(test.param)); });

// A layer that starts delta too near to a held one is pushed off with delta/h: r = m delta/h does m (delta/h)^2 of work
// on it, of which backward Euler takes one half. It moves on as fast.
TEST(PairPushTest, IsAGainThatIsFound) {
  constexpr double kStep = 0.005, kTooNear = 2e-4;
  Scene scene = LayersOnASlope(2, 0.0, 0.3, Integrator::kEuler, kStep);
  scene.gravity.setZero();
  const int first = static_cast<int>(scene.handles.nodes.size());
  for (int node = first; node < scene.mesh.num_nodes(); ++node) scene.initial_positions[3 * node + 2] -= kTooNear;
  EnergyAccount account(scene, 3);
  const double speed = kTooNear / kStep, push = MassOf(scene, first) * speed * speed;
  EXPECT_NEAR(account.contact.push, push, 1e-7 * push);
  EXPECT_NEAR(account.contact.friction, -push, 1e-7 * push);
  EXPECT_NEAR(account.loss, 0.5 * push, 1e-7 * push);
  EXPECT_TRUE(MayGainEnergy(account.rollout.parameters, account.simulator));
  const EnergyGain gain = FindEnergyGain(account.rollout, &account.simulator);
  EXPECT_NEAR(gain.energy, 0.5 * push, 1e-7 * push);
  EXPECT_NEAR(gain.push, push, 1e-7 * push);
  EXPECT_NEAR(gain.largest_energy, 0.5 * push, 1e-7 * push);
  EXPECT_NE(std::string(gain.remedy()).find("pushed apart"), std::string::npos);
}

}  // namespace
}  // namespace clothid::pair_work_test
