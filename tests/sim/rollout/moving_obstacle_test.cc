// Cloth on obstacles that move, against what is known in closed form.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "sim/obstacle/obstacle.h"
#include "sim/rollout/rollout.h"
#include "sim/scene/scene.h"
#include "tests/sim/energy_account.h"
#include "tests/sim/moving_paths.h"
#include "tests/sim/order_of_convergence.h"
#include "tests/sim/plain_scenes.h"

namespace clothid::moving_obstacle_test {
namespace {

constexpr double kGravity = 9.81;  // m/s^2
const Eigen::Vector3d kUp = Eigen::Vector3d::UnitZ();

// A small cloth that lies on the plane z = 0, which follows `path`.
Scene OnPlane(Integrator integrator, double mu, const std::shared_ptr<const RigidPath>& path, double time_step) {
  Scene scene = ClothScene(SquareGrid(4, 0.06), time_step);
  scene.integrator = integrator;
  scene.obstacles.push_back({"belt", std::make_shared<Plane>(Eigen::Vector3d::Zero(), kUp), mu, 0.0, path});
  return scene;
}

class MovingObstacleTest : public testing::TestWithParam<Integrator> {};

// x'' = mu g until the speed of the belt is reached at t_1 = V/(mu g), then x' = V; it lags by V t_1/2.
TEST_P(MovingObstacleTest, ABeltDragsTheClothUntilItSticks) {
  constexpr double kMu = 0.3, kSpeed = 0.5, kDuration = 0.4, kTimeStep = 0.002;
  const auto belt = PathThrough(
      0.0, 1.0, 3, [](double t) { return Eigen::Vector3d(kSpeed * t, 0.0, 0.0); }, NoTurn);
  const Rollout rollout =
      SimulateNominal(OnPlane(GetParam(), kMu, belt, kTimeStep), static_cast<int>(kDuration / kTimeStep));
  const double stick_time = kSpeed / (kMu * kGravity);
  const Eigen::VectorXd& start = rollout.initial_positions;
  const auto advance = [&](int step) { return (rollout.positions(step) - start).reshaped(3, start.size() / 3); };
  for (int step = 1; step <= rollout.num_steps(); ++step) {
    const double t = step * kTimeStep;
    const double expected = t < stick_time ? 0.5 * kMu * kGravity * t * t : kSpeed * t - 0.5 * kSpeed * stick_time;
    EXPECT_LE((advance(step).colwise() - Eigen::Vector3d(expected, 0.0, 0.0)).norm(), 4.0 * kTimeStep * kSpeed) << t;
  }
  const int stuck = static_cast<int>(stick_time / kTimeStep) + 2;
  for (int step = stuck; step < rollout.num_steps(); ++step) {
    EXPECT_LE((rollout.positions(step + 1) - rollout.positions(step) -
               Eigen::Vector3d(kSpeed * kTimeStep, 0.0, 0.0).replicate(start.size() / 3, 1))
                  .norm(),
              1e-12);
  }
}

// On a turntable a node sticks where omega^2 r < mu g, and is then carried round exactly. (The cloth is wide, and the
// first stage of SDIRK2 strains a turning cloth by (gamma omega h)^2/2, which pulls at its nodes, too.)
TEST_P(MovingObstacleTest, ATurntableCarriesWhatFrictionHolds) {
  constexpr double kRadius = 0.3, kSpin = 3.0, kTimeStep = 0.01;
  const auto table = PathThrough(0.0, 2.0, 101, NoShift, [](double t) { return Eigen::Vector3d(0.0, 0.0, kSpin * t); });
  const double least = kSpin * kSpin * kRadius / kGravity;  // mu at which it sticks
  for (const double mu : {1.8 * least, 0.7 * least}) {
    Scene scene = OnPlane(GetParam(), mu, table, kTimeStep);
    scene.material.stretch_stiffness = 10.0;
    for (int node = 0; node < scene.mesh.num_nodes(); ++node) {
      auto x = scene.initial_positions.segment<3>(3 * node);
      x.x() += kRadius;
      scene.initial_velocities.segment<3>(3 * node) = Eigen::Vector3d(0.0, 0.0, kSpin).cross(Eigen::Vector3d(x));
    }
    const Rollout rollout = SimulateNominal(scene, 100);
    const Eigen::Matrix3d turned = ExponentialOf({0.0, 0.0, kSpin * 1.0}).toRotationMatrix();
    const Eigen::Matrix3Xd carried = turned * rollout.initial_positions.reshaped(3, scene.mesh.num_nodes());
    const double off = (rollout.positions(100) - carried.reshaped()).lpNorm<Eigen::Infinity>();
    if (mu > least) {
      EXPECT_LE(off, 1e-9);
    } else {
      EXPECT_GE(off, 0.05);
    }
  }
}

// A plate that lifts the cloth and comes to rest: carried exactly, whatever the acceleration of the plate (below g).
TEST_P(MovingObstacleTest, APlateThatSpeedsUpCarriesTheCloth) {
  constexpr double kTimeStep = 0.01;
  const auto height = [](double t) {
    return Eigen::Vector3d(0.05 * std::sin(3.0 * t), 0.0, 0.1 * (1.0 - std::cos(4.0 * t)));
  };
  const auto plate = PathThrough(0.0, 1.2, 121, height, NoTurn);
  Scene scene = OnPlane(GetParam(), 0.8, plate, kTimeStep);
  scene.initial_velocities = plate->At(0.0).rate.col(3).replicate(scene.mesh.num_nodes(), 1);
  const Rollout rollout = SimulateNominal(scene, 100);
  for (int step = 1; step <= 100; ++step) {
    const Eigen::Vector3d moved = plate->At(step * kTimeStep).pose.col(3);
    EXPECT_LE((rollout.positions(step) - rollout.initial_positions - moved.replicate(scene.mesh.num_nodes(), 1))
                  .lpNorm<Eigen::Infinity>(),
              1e-10)
        << step;
  }
}

// A ball that lifts a cloth does the work that the cloth gains and friction takes, but for what the integrator loses.
TEST_P(MovingObstacleTest, ABallThatLiftsDoesTheWork) {
  Scene scene = ClothScene(SquareGrid(8, 0.4), 0.005);
  scene.integrator = GetParam();
  scene.material.bending_stiffness = 1e-5;
  const Eigen::Vector3d middle = scene.mesh.rest_positions.rowwise().mean();
  const auto rise = [&](double t) {
    return Eigen::Vector3d(middle + Eigen::Vector3d(0.02 * t, 0.0, -0.082 + 0.3 * (1.0 - std::cos(5.0 * t))));
  };
  scene.obstacles.push_back(
      {"ball", std::make_shared<Sphere>(Eigen::Vector3d::Zero(), 0.08), 0.4, 0.0,
       PathThrough(0.0, 1.0, 101, rise, [](double t) { return Eigen::Vector3d(0.0, 0.3 * t, 0.2 * t); })});
  const EnergyAccount account(scene, 80);
  EXPECT_GE(account.contact.work, 0.02);
  EXPECT_NEAR(account.change, account.explained(), 1e-8 * account.contact.work);
}

INSTANTIATE_TEST_SUITE_P(Integrators, MovingObstacleTest, testing::Values(Integrator::kEuler, Integrator::kSdirk2),
                         [](const auto& test) { return std::string(IntegratorName(test.param)); });

// An obstacle with a path that does not move it gives what one without a path does.
TEST(MovingObstacleTest, APathThatRestsChangesNothing) {
  for (const Integrator integrator : {Integrator::kEuler, Integrator::kSdirk2}) {
    Scene scene = ClothScene(SquareGrid(6, 0.3), 0.005);
    scene.integrator = integrator;
    const Eigen::Vector3d centre(0.02, -0.01, -0.12);
    scene.obstacles.push_back({"ball", std::make_shared<Sphere>(centre, 0.1), 0.3, 0.0});
    const Rollout at_rest = SimulateNominal(scene, 60);
    scene.obstacles[0].shape = std::make_shared<Sphere>(Eigen::Vector3d::Zero(), 0.1);
    scene.obstacles[0].path = PathThrough(
        0.0, 0.1, 2, [&](double) { return centre; }, NoTurn);
    const Rollout on_path = SimulateNominal(scene, 60);
    EXPECT_LE((on_path.positions(60) - at_rest.positions(60)).lpNorm<Eigen::Infinity>(), 1e-9);
  }
}

// A cloth, strained at first, slips all the time on a belt that goes in circles, and up and down.
TEST(MovingObstacleOrderTest, IsTwoWhereNothingHits) {
  Scene scene = ClothScene(SquareGrid(3, 0.4), 0.01);
  scene.duration = 0.2;
  scene.material.stretch_stiffness = 2.0;
  const auto place = [](double t) {
    return Eigen::Vector3d(0.2 * std::sin(8.0 * t), 0.2 * std::cos(8.0 * t), 0.04 * (1.0 - std::cos(6.0 * t)));
  };
  const auto path = PathThrough(0.0, 0.3, 301, place, NoTurn);
  scene.obstacles.push_back({"belt", std::make_shared<Plane>(Eigen::Vector3d::Zero(), kUp), 0.2, 0.0, path});
  scene.initial_positions *= 1.02;
  ExpectOrderTwo(scene);
}

}  // namespace
}  // namespace clothid::moving_obstacle_test
