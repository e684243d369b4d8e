// What SDIRK2 promises: second order while nothing hits an obstacle, energy kept, and contacts that neither gain energy
// nor let nodes in or creep. Truths are SDIRK2 at a far smaller step.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "sim/cloth/cloth_model.h"
#include "sim/rollout/rollout.h"
#include "sim/rollout/simulator.h"
#include "tests/sim/order_of_convergence.h"
#include "tests/sim/plain_scenes.h"
#include "tests/sim/shipped_scenes.h"

namespace clothid::sdirk2_test {
namespace {

Scene Wind(double damping) {
  Scene scene = ShippedScene("wind", 6);
  scene.duration = 0.3;
  scene.material.damping = damping;
  return scene;
}

// Slides on the plane, and at `mu` = 0.8 stops at 0.13 s and sticks.
Scene Slope(double mu, double duration) {
  Scene scene = ShippedScene("slope", 5);
  scene.obstacles[0].friction_coefficient = mu;
  scene.duration = duration;
  return scene;
}

TEST(OrderTest, IsTwoInWind) {
  EXPECT_GE(Order(Wind(0.0), Integrator::kSdirk2, 8), 1.9);
  EXPECT_LE(Order(Wind(0.0), Integrator::kEuler, 4), 1.1);
}

// With a relaxation time of 2 ms.
TEST(OrderTest, IsTwoWithInternalDamping) { EXPECT_GE(Order(Wind(0.6), Integrator::kSdirk2, 8), 1.9); }

TEST(OrderTest, IsTwoWhileSliding) {
  EXPECT_GE(Order(Slope(0.3, 0.4), Integrator::kSdirk2, 1), 1.9);
  EXPECT_LE(Order(Slope(0.3, 0.4), Integrator::kEuler, 1), 1.1);
}

// A patch of cloth that slides over the top of a ball, so fast that the ball turning away takes half of its weight.
Scene Ball() {
  Scene scene = ClothScene(SquareGrid(2, 0.02), kFrame);
  scene.initial_positions.reshaped(3, 4).colwise() += Eigen::Vector3d(-0.05, -0.01, 0.0);
  const Sphere ball(Eigen::Vector3d(0.0, 0.0, -0.3), 0.3);
  for (int node = 0; node < 4; ++node) {
    auto x = scene.initial_positions.segment<3>(3 * node);
    x -= ball.Closest(x).gap * ball.Closest(x).normal;
    const Eigen::Vector3d normal = ball.Closest(x).normal, velocity(1.2, 0.3, 0.0);
    scene.initial_velocities.segment<3>(3 * node) = velocity - normal.dot(velocity) * normal;
  }
  scene.mesh.rest_positions = scene.initial_positions.reshaped(3, 4);
  scene.material.stretch_stiffness = 1.0;
  scene.duration = 0.08;
  scene.obstacles.push_back({"ball", std::make_shared<Sphere>(ball), 0.2, 0.0});
  return scene;
}

// Not of second order: a step holds the plane that touches the ball where a stage starts.
TEST(ErrorTest, OnABallIsAQuarterOfEulers) {
  const std::vector<Eigen::VectorXd> truth = Frames(Ball(), Integrator::kSdirk2, 128);
  for (const int steps : {1, 2, 4}) {
    EXPECT_LE(4.0 * Distance(Frames(Ball(), Integrator::kSdirk2, steps), truth),
              Distance(Frames(Ball(), Integrator::kEuler, steps), truth));
  }
}

// A flat sheet that falls flat and slides on: its impact is spread over two steps such that positions are right.
TEST(ErrorTest, OfAnImpactThatSlidesIsSmall) {
  Scene scene = ClothScene(SquareGrid(3, 0.1), kFrame);
  scene.initial_positions.reshaped(3, 9).row(2).array() += 0.0171;
  scene.initial_velocities.reshaped(3, 9).colwise() = Eigen::Vector3d(0.2, 0.3, -1.0);
  scene.duration = 0.2;
  scene.obstacles.push_back(
      {"plane", std::make_shared<Plane>(Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ()), 0.1, 0.0});
  const std::vector<Eigen::VectorXd> truth = Frames(scene, Integrator::kSdirk2, 128);
  const double euler = Distance(Frames(scene, Integrator::kEuler, 1), truth);
  EXPECT_LE(Distance(Frames(scene, Integrator::kSdirk2, 1), truth), 0.02 * euler);
}

// In the mean over the phases at which steps meet the stop: one end of it is not in line with the next.
TEST(OrderTest, IsTwoThroughStoppingAndSticking) {
  double coarse = 0.0, fine = 0.0;
  for (const double mu : {0.70, 0.74, 0.78, 0.82, 0.86, 0.90}) {
    const Scene scene = Slope(mu, 0.4);
    const std::vector<Eigen::VectorXd> truth = Frames(scene, Integrator::kSdirk2, 64);
    coarse += std::pow(Distance(Frames(scene, Integrator::kSdirk2, 1), truth), 2);
    fine += std::pow(Distance(Frames(scene, Integrator::kSdirk2, 4), truth), 2);
  }
  EXPECT_GE(0.25 * std::log2(coarse / fine), 1.9);
}

// Kinetic, elastic and of gravity, at the end of every step, J.
std::vector<double> Energies(const Scene& scene) {
  Simulator simulator(scene);
  const ClothModel& model = simulator.model();
  const Rollout rollout = Simulate(scene.nominal_parameters(), scene.num_steps(), &simulator);
  EXPECT_TRUE(rollout.ok()) << rollout.failure->ToString();
  const auto energy = [&](const Eigen::VectorXd& x, const Eigen::VectorXd& v) {
    Eigen::VectorXd force = Eigen::VectorXd::Zero(x.size());
    const Material& material = rollout.parameters.material;
    double sum = material.stretch_stiffness * model.stretch().AddForce(1.0, x, &force);
    if (model.bending() != nullptr) sum += material.bending_stiffness * model.bending()->AddForce(1.0, x, &force);
    for (const int node : model.free_nodes()) {
      const double mass = material.density * model.node_areas()[node];
      sum += mass * (0.5 * v.segment<3>(3 * node).squaredNorm() - scene.gravity.dot(x.segment<3>(3 * node)));
    }
    return sum;
  };
  std::vector<double> energies = {energy(rollout.initial_positions, rollout.initial_velocities)};
  for (const int i : rollout.last_record) {
    energies.push_back(energy(rollout.records[i].positions, rollout.records[i].velocities));
  }
  return energies;
}

// A cloth that is held at its upper edge and let go at an angle.
TEST(EnergyTest, AnUndampedSwingKeepsIts) {
  Scene scene = ShippedScene("drape", 8);
  scene.obstacles.clear();
  scene.material.drag = 0.0;
  scene.duration = 1.6;
  const std::vector<double> euler = Energies(scene);
  scene.integrator = Integrator::kSdirk2;
  const std::vector<double> energies = Energies(scene);
  EXPECT_GT(euler.front() - euler.back(), 0.0);
  EXPECT_LE(std::abs(energies.front() - energies.back()), (euler.front() - euler.back()) / 20.0);
}

// A plane, tilted by `angle` (rad), and a flat sheet above it that falls on it with `speed` (m/s), as a whole.
Scene Drop(double angle, double speed, double mu) {
  Scene scene = ClothScene(SquareGrid(4, 0.2), kFrame);
  const Eigen::Vector3d normal(std::sin(angle), 0.0, std::cos(angle));
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY()).toRotationMatrix();
  scene.mesh.rest_positions = (turn * scene.mesh.rest_positions).eval();
  scene.initial_positions = (scene.mesh.rest_positions.colwise() + 0.013 * normal).reshaped();
  scene.initial_velocities.reshaped(3, 16).colwise() = Eigen::Vector3d(0.2, 0.3, -speed);
  scene.material.stretch_stiffness = 100.0;
  scene.duration = 0.3;
  scene.obstacles.push_back({"plane", std::make_shared<Plane>(Eigen::Vector3d::Zero(), normal), mu, 0.0});
  scene.integrator = Integrator::kSdirk2;
  return scene;
}

// Without strain a step neither gains nor loses energy by itself: what is gained is gained at contacts.
TEST(EnergyTest, NoContactGainsAny) {
  for (const double angle : {0.0, 0.3}) {
    for (const double speed : {0.1, 0.5, 2.0}) {
      for (const double mu : {0.0, 0.2, 2.0}) {
        const std::vector<double> energies = Energies(Drop(angle, speed, mu));
        for (std::size_t i = 1; i < energies.size(); ++i) {
          EXPECT_LE(energies[i] - energies[i - 1], 1e-10 * std::abs(energies[0]))
              << "step " << i << ", angle " << angle << ", speed " << speed << ", mu " << mu;
        }
        EXPECT_LT(energies.back(), energies.front());
      }
    }
  }
}

// How deep a node is inside an obstacle at the end of a step, at the most, m.
double Penetration(const Scene& scene) {
  double deepest = 0.0;
  Simulator simulator(scene);
  RolloutOptions options;
  options.visitor = [&](int, const Eigen::VectorXd& positions) {
    for (const SceneObstacle& obstacle : scene.obstacles) {
      for (int node = 0; node < scene.mesh.num_nodes(); ++node) {
        deepest = std::max(deepest, -obstacle.shape->Closest(positions.segment<3>(3 * node)).gap);
      }
    }
  };
  EXPECT_TRUE(Simulate(scene.nominal_parameters(), scene.num_steps(), &simulator, nullptr, options).ok());
  return deepest;
}

TEST(PenetrationTest, IsNoDeeperThanEulers) {
  std::vector<Scene> scenes = {ShippedScene("drape", 10), ShippedScene("pair", 8), Drop(0.3, 2.0, 0.2)};
  for (Scene& scene : scenes) {
    scene.integrator = Integrator::kEuler;
    const double euler = Penetration(scene);
    scene.integrator = Integrator::kSdirk2;
    EXPECT_LE(Penetration(scene), euler + 1e-15);
  }
}

// A stiff cloth that stands still on a slope.
TEST(StickTest, NodesThatStickStayWhereTheyAre) {
  Scene scene = Slope(0.8, 1.0);
  scene.initial_velocities.setZero();
  scene.integrator = Integrator::kSdirk2;
  Eigen::VectorXd last = scene.initial_positions;
  double farthest = 0.0;
  RolloutOptions options;
  options.visitor = [&](int, const Eigen::VectorXd& positions) {
    farthest = std::max(farthest, (positions - last).lpNorm<Eigen::Infinity>());
    last = positions;
  };
  Simulator simulator(scene);
  const Rollout rollout = Simulate(scene.nominal_parameters(), scene.num_steps(), &simulator, nullptr, options);
  ASSERT_TRUE(rollout.ok());
  EXPECT_LE(farthest, 1e-12);
  for (const ContactRecord& contact : rollout.records.back().contacts.nodes)
    EXPECT_EQ(contact.branch, ContactBranch::kStick);
  EXPECT_EQ(rollout.records.back().contacts.nodes.size(), 25u);
}

// A rigid motion is not damped, whatever the positions between which the second stage takes its strain rate.
TEST(SecondStageTest, ARigidRotationIsNotDamped) {
  Scene scene = ClothScene(SquareGrid(4, 0.2), 0.01);
  scene.gravity.setZero();
  scene.material.stretch_stiffness = 1e5;
  scene.duration = 0.2;
  scene.integrator = Integrator::kSdirk2;
  const Eigen::Vector3d axis(0.0, 0.0, 3.0);  // rad/s
  for (int i = 0; i < 16; ++i) {
    const Eigen::Vector3d arm = scene.initial_positions.segment<3>(3 * i) - Eigen::Vector3d(0.1, 0.1, 0.0);
    scene.initial_velocities.segment<3>(3 * i) = axis.cross(arm);
  }
  scene.material.damping = 1e-12;  // present, without effect
  const std::vector<double> undamped = Energies(scene);
  scene.material.damping = 10.0;
  const std::vector<double> damped = Energies(scene);
  EXPECT_NEAR(damped.back(), undamped.back(), 1e-4 * undamped.front());
}

}  // namespace
}  // namespace clothid::sdirk2_test
