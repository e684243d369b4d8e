#include "tools/benchmark/continuity/sphere_slide.h"

#include <Eigen/Geometry>
#include <cmath>
#include <memory>
#include <stdexcept>

#include "sim/scene/mesh.h"
#include "sim/scene/obstacle.h"
#include "sim/scene/triangulated_surface.h"
#include "tools/benchmark/continuity/icosphere.h"

namespace clothid {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180.0;
constexpr double kRadius = 1.0;             // m
constexpr double kClothSize = 0.2;          // m
constexpr double kOffTop = 10.0 * kDegree;  // of the cloth's centre
constexpr double kTurned = 20.0 * kDegree;  // the cloth about its normal: no symmetry makes nodes switch together
constexpr double kTimeStep = 0.004;         // s
constexpr int kNumSteps = 200;
constexpr double kDensity = 0.3;            // kg/m^2
constexpr double kStretchStiffness = 5.0;   // N/m: soft enough for nodes to stick and slip one by one
constexpr double kBendingStiffness = 5e-6;  // N m: not enough to lift the rim off the sphere

// Turned so that each watched node is 4 to 24 mm above an edge, which it crosses within 50 steps where friction is
// small, and no face under the cloth is steeper than mu = 0.35.
Eigen::Matrix3d TurnOfTriangles() {
  return Eigen::AngleAxisd(2.4, Eigen::Vector3d(0.0, 1.0, 3.0).normalized()).toRotationMatrix();
}

std::shared_ptr<const Obstacle> MakeShape(const SlideSurface& surface) {
  if (surface.num_splits < 0) return std::make_shared<Sphere>(Eigen::Vector3d::Zero(), kRadius);
  const Mesh mesh = MakeIcosphere(surface.num_splits);
  return std::make_shared<TriangulatedSurface>(kRadius * TurnOfTriangles() * mesh.rest_positions, mesh.faces);
}

// The point of the sphere at distance |p| from the cloth's centre along a great circle in the direction of p.
Eigen::Vector3d RollOntoSphere(const Eigen::Vector2d& p) {
  const Eigen::Vector3d center(std::sin(kOffTop), 0.0, std::cos(kOffTop));
  const Eigen::Vector3d down(std::cos(kOffTop), 0.0, -std::sin(kOffTop));
  const Eigen::Vector2d turned = Eigen::Rotation2Dd(kTurned) * p;
  const double distance = p.norm();
  if (distance == 0.0) return kRadius * center;
  const Eigen::Vector3d direction = (turned[0] * down + turned[1] * Eigen::Vector3d::UnitY()) / distance;
  return kRadius * (std::cos(distance / kRadius) * center + std::sin(distance / kRadius) * direction);
}

Mesh MakeCloth(const Obstacle& shape, int nodes) {
  GridOptions grid;
  grid.nodes = {nodes, nodes};
  grid.size = {kClothSize, kClothSize};
  grid.origin = Eigen::Vector3d(-0.5 * kClothSize, -0.5 * kClothSize, 0.0);
  Mesh mesh = MakeGrid(grid);
  for (int node = 0; node < mesh.num_nodes(); ++node) {
    const Eigen::Vector3d position = RollOntoSphere(mesh.rest_positions.col(node).head<2>());
    const SurfacePoint closest = shape.Closest(position);
    mesh.rest_positions.col(node) = position - closest.gap * closest.normal;
  }
  return mesh;
}

}  // namespace

SphereSlide MakeSphereSlide(const SlideSurface& surface, int nodes, ContactMode contact_mode) {
  if (nodes < 3 || nodes % 2 == 0) throw std::logic_error("a slide needs an odd number of nodes, at least 3");
  SphereSlide slide;
  SceneObstacle ball;
  ball.name = "ball";
  ball.shape = MakeShape(surface);
  Scene& scene = slide.scene;
  scene.integrator = Integrator::kEuler;  // of whose steps the contact sets are counted
  scene.time_step = kTimeStep;
  scene.duration = kNumSteps * kTimeStep;
  scene.contact_mode = contact_mode;
  scene.mesh = MakeCloth(*ball.shape, nodes);
  scene.initial_positions =
      Eigen::Map<const Eigen::VectorXd>(scene.mesh.rest_positions.data(), scene.mesh.rest_positions.size());
  scene.initial_velocities = Eigen::VectorXd::Zero(scene.initial_positions.size());
  scene.obstacles.push_back(std::move(ball));
  scene.material.density = kDensity;
  scene.material.stretch_stiffness = kStretchStiffness;
  scene.material.bending_stiffness = kBendingStiffness;
  scene.bending.is_flat_at_rest = true;
  const int middle = nodes / 2;
  slide.watched_nodes = {nodes - 1, nodes * middle, nodes * middle + middle};
  return slide;
}

}  // namespace clothid
