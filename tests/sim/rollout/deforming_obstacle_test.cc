// Cloth on obstacles that deform, against rigid ones and what is known in closed form.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "sim/obstacle/surface_sequence.h"
#include "sim/rollout/rollout.h"
#include "sim/scene/scene.h"
#include "tests/sim/energy_account.h"
#include "tests/sim/moving_paths.h"
#include "tests/sim/moving_surfaces.h"
#include "tests/sim/order_of_convergence.h"
#include "tests/sim/plain_scenes.h"

namespace clothid::deforming_obstacle_test {
namespace {

using Eigen::Vector3d;

class DeformingObstacleTest : public testing::TestWithParam<Integrator> {
 protected:
  // A cloth above a tilted cube, which the contact distance rounds off.
  Scene OverCube() const {
    Scene scene = ClothScene(SquareGrid(8, 0.4), 0.005);
    scene.integrator = GetParam();
    scene.material.bending_stiffness = 1e-5;
    scene.obstacles.push_back({"cube", nullptr, 0.4, 0.01});
    return scene;
  }

  // A soft cloth that lies on a slab.
  Scene OnSlab(double time_step) const {
    Scene scene = ClothScene(SquareGrid(5, 0.2), time_step);
    scene.integrator = GetParam();
    scene.material.stretch_stiffness = 0.02;
    scene.obstacles.push_back({"slab", nullptr, 2.0, 0.0});
    return scene;
  }
};

Vector3d Middle(const Scene& scene) { return scene.mesh.rest_positions.rowwise().mean(); }

// The positions of all steps, largest difference.
double Difference(const Rollout& one, const Rollout& other) {
  double largest = 0.0;
  for (int step = 0; step <= one.num_steps(); ++step) {
    largest = std::max(largest, (one.positions(step) - other.positions(step)).lpNorm<Eigen::Infinity>());
  }
  return largest;
}

TEST_P(DeformingObstacleTest, ASequenceThatShiftsIsAPath) {
  Scene scene = OverCube();
  const Vector3d under = Middle(scene) - Vector3d(0.0, 0.0, 0.13);
  const Eigen::Matrix3d tilt = ExponentialOf({0.3, 0.2, 0.1}).toRotationMatrix();
  const auto shift = [&](double t) -> Vector3d {
    return under + Vector3d(0.1 * t, 0.0, 0.1 * (1.0 - std::cos(6.0 * t)));
  };
  TriangleMesh cube = Split(CubeMesh(0.06));
  cube.vertices = tilt * cube.vertices;
  const auto place = [&](const Vector3d& p, double t) -> Vector3d { return p + shift(t); };
  Deform(cube, 0.0, 0.4, 21, place, &scene.obstacles[0]);
  const Rollout deformed = SimulateNominal(scene, 60);
  scene.obstacles[0].sequence = nullptr;
  scene.obstacles[0].path = PathThrough(0.0, 0.4, 21, shift, NoTurn);
  const Rollout moved = SimulateNominal(scene, 60);
  EXPECT_GE((deformed.positions(60) - deformed.positions(0)).lpNorm<Eigen::Infinity>(), 0.05);
  EXPECT_GE(deformed.records[deformed.last_record[59]].contacts.nodes.size(), 3u);
  EXPECT_LE(Difference(deformed, moved), 1e-9);
}

// But for what the curves of the vertices are off those of the rotation, and by SDIRK2 for the distance from an edge in
// the second stage, which starts from faces that are stretched by terms of second order in the step.
TEST_P(DeformingObstacleTest, ASequenceThatTurnsIsAPath) {
  Scene scene = OverCube();
  const Vector3d under = Middle(scene) - Vector3d(0.0, 0.0, 0.13);
  const auto shift = [&](double t) -> Vector3d { return under + Vector3d(0.0, 0.0, 0.05 * t); };
  const auto turn = [](double t) { return Vector3d(0.2, 0.1, 1.5 * t); };
  const TriangleMesh cube = Split(CubeMesh(0.06));
  const auto place = [&](const Vector3d& p, double t) -> Vector3d { return ExponentialOf(turn(t)) * p + shift(t); };
  const auto error = [&](int frames, int steps) {
    scene.time_step = 0.2 / steps;
    Deform(cube, 0.0, 0.4, frames, place, &scene.obstacles[0]);
    scene.obstacles[0].path = nullptr;
    const Rollout deformed = SimulateNominal(scene, steps);
    scene.obstacles[0].sequence = nullptr;
    scene.obstacles[0].path = PathThrough(0.0, 0.4, frames, shift, turn);
    return Difference(deformed, SimulateNominal(scene, steps));
  };
  const double coarse = error(41, 40);
  EXPECT_LE(coarse, 1e-6);
  EXPECT_LE(GetParam() == Integrator::kEuler ? error(81, 40) : error(81, 80), 0.5 * coarse);
}

// Shears and stretches in its plane, unevenly, and is carried, tilted and turned.
Vector3d Warp(const Vector3d& p, double t) {
  const double swing = 0.15 * (1.0 - std::cos(5.0 * t));
  const Vector3d flat(p.x() + swing * (0.5 * p.y() + 0.3 * p.x()) + 0.1 * swing * std::sin(8.0 * p.x()),
                      p.y() * (1.0 - 0.2 * swing), p.z());
  return ExponentialOf({0.0, 0.3 * swing, 0.2 * swing}) * flat + Vector3d(0.1 * swing, 0.0, 0.2 * swing);
}

// Every node keeps its barycentric coordinates, exactly.
TEST_P(DeformingObstacleTest, WhatSticksIsCarriedWithItsBarycentricPoint) {
  constexpr double kTimeStep = 0.01;
  Scene scene = OnSlab(kTimeStep);
  scene.initial_positions.reshaped(3, scene.mesh.num_nodes()).colwise() += Vector3d(-0.093, -0.107, 0.0);
  Deform(SlabMesh(0.3, 2), 0.0, 1.0, 51, Warp, &scene.obstacles[0]);
  const SurfaceSequence& sequence = *scene.obstacles[0].sequence;
  const TriangulatedSurface start = sequence.MovedTo(sequence.At({}, 0.0).pose);
  const Rollout rollout = SimulateNominal(scene, 80);
  for (int node = 0; node < scene.mesh.num_nodes(); ++node) {
    const Vector3d x = scene.initial_positions.segment<3>(3 * node);
    const int face = start.Nearest(x).face;
    const AffineMap map = sequence.FaceAt(face, {}, 0.0).pose;
    const Vector3d point = map.leftCols<3>().inverse() * (x - map.col(3));
    for (int step = 1; step <= 80; ++step) {
      const Vector3d carried = Apply(sequence.FaceAt(face, {}, step * kTimeStep).pose, point);
      ASSERT_LE((rollout.positions(step).segment<3>(3 * node) - carried).norm(), 1e-9) << node << " at step " << step;
    }
  }
  EXPECT_GE((rollout.positions(60) - rollout.positions(0)).lpNorm<Eigen::Infinity>(), 0.02);
}

// A slab that bulges does the work that the cloth gains and friction takes, but for what the integrator loses.
TEST_P(DeformingObstacleTest, ASlabThatBulgesDoesTheWork) {
  Scene scene = OnSlab(0.005);
  scene.material.stretch_stiffness = 20.0;
  scene.obstacles[0].friction_coefficient = 0.3;
  scene.initial_positions.reshaped(3, scene.mesh.num_nodes()).colwise() += Vector3d(-0.1, -0.1, 0.0);
  const auto bulge = [](const Vector3d& p, double t) -> Vector3d {
    const double rise = p.z() > -0.05 ? 0.05 * (1.0 - std::cos(6.0 * t)) : 0.0;
    return p + Vector3d(0.0, 0.0, rise * std::exp(-20.0 * p.head<2>().squaredNorm()));
  };
  Deform(SlabMesh(0.3, 3), 0.0, 1.0, 51, bulge, &scene.obstacles[0]);
  const EnergyAccount account(scene, 60);
  EXPECT_GE(account.contact.work, 1e-3);
  EXPECT_NEAR(account.change, account.explained(), 1e-8 * account.contact.work);
}

INSTANTIATE_TEST_SUITE_P(Integrators, DeformingObstacleTest, testing::Values(Integrator::kEuler, Integrator::kSdirk2),
                         [](const auto& test) { return std::string(IntegratorName(test.param)); });

// A cloth, strained at first, slips all the time on a slab that shears and stretches, and goes up and down.
TEST(DeformingObstacleOrderTest, IsTwoWhereNothingHits) {
  Scene scene = ClothScene(SquareGrid(3, 0.2), 0.01);
  scene.duration = 0.2;
  scene.material.stretch_stiffness = 2.0;
  scene.obstacles.push_back({"slab", nullptr, 0.2, 0.0});
  scene.initial_positions *= 1.02;
  const auto place = [](const Vector3d& p, double t) {
    const double swing = std::sin(8.0 * t);
    return Vector3d(p.x() * (1.0 + 0.3 * swing) + 0.2 * swing * p.y() + 0.2 * swing,
                    p.y() * (1.2 - 0.2 * std::cos(8.0 * t)) + 0.2 * std::cos(8.0 * t),
                    p.z() + 0.04 * (1.0 - std::cos(6.0 * t)));
  };
  Deform(SlabMesh(1.0, 0), 0.0, 0.3, 301, place, &scene.obstacles[0]);
  ExpectOrderTwo(scene);
}

// A sequence that does not move its mesh gives what that mesh gives.
TEST(DeformingObstacleRestTest, ASequenceThatRestsChangesNothing) {
  for (const Integrator integrator : {Integrator::kEuler, Integrator::kSdirk2}) {
    Scene scene = ClothScene(SquareGrid(6, 0.3), 0.005);
    scene.integrator = integrator;
    TriangleMesh ball = IcosphereMesh(2, 0.1);
    ball.vertices.colwise() += Vector3d(0.152, 0.147, -0.12);
    scene.obstacles.push_back({"ball", nullptr, 0.3, 0.005});
    const auto rest = [](const Vector3d& p, double) { return p; };
    Deform(ball, 0.0, 0.1, 2, rest, &scene.obstacles[0]);
    const Rollout deformed = SimulateNominal(scene, 60);
    scene.obstacles[0].sequence = nullptr;
    EXPECT_LE(Difference(deformed, SimulateNominal(scene, 60)), 1e-9);
  }
}

}  // namespace
}  // namespace clothid::deforming_obstacle_test
