#include "tools/benchmark/base/benchmark_scene.h"

#include <cmath>
#include <iterator>
#include <memory>

#include "tools/benchmark/base/common.h"

namespace clothid {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kWindForce = 0.0043;  // N on each of kWindNodes nodes
constexpr int kWindNodes = 576;
constexpr double kSlopeAngle = 42.3 * kPi / 180.0;
constexpr double kSphereRadius = 0.3;                                              // m
constexpr double kFoldSize = 0.3, kTableDistance = 0.001, kFoldThickness = 0.003;  // m
constexpr double kFoldFriction = 0.3;

void SetGrid(int nodes, double size, const Eigen::Vector3d& origin, const Eigen::Vector3d& first_axis,
             const Eigen::Vector3d& second_axis, Scene* scene) {
  GridOptions grid;
  grid.nodes = {nodes, nodes};
  grid.size = {size, size};
  grid.origin = origin;
  grid.axes = {first_axis, second_axis};
  scene->mesh = MakeGrid(grid);
  scene->initial_positions =
      Eigen::Map<const Eigen::VectorXd>(scene->mesh.rest_positions.data(), scene->mesh.rest_positions.size());
  scene->initial_velocities = Eigen::VectorXd::Zero(scene->initial_positions.size());
}

void MakeWind(int nodes, Scene* scene) {
  SetGrid(nodes, 6.0, Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitX(), -Eigen::Vector3d::UnitZ(), scene);
  scene->handles.nodes = {0, nodes - 1};
  const double force = kWindForce * kWindNodes / (nodes * nodes);
  scene->node_force = Eigen::Vector3d(0.0, force, force);
  scene->material.density = 0.054;
  scene->material.bending_stiffness = 0.0;
}

void MakeSlope(int nodes, Scene* scene) {
  const Eigen::Vector3d down(std::cos(kSlopeAngle), 0.0, -std::sin(kSlopeAngle));
  const Eigen::Vector3d normal(std::sin(kSlopeAngle), 0.0, std::cos(kSlopeAngle));
  SetGrid(nodes, 1.0, Eigen::Vector3d::Zero(), down, Eigen::Vector3d::UnitY(), scene);
  AddObstacle("plane", std::make_shared<Plane>(Eigen::Vector3d::Zero(), normal), 0.5, scene);
  scene->material.density = 0.2;
  scene->material.bending_stiffness = 0.0;
}

// Off the middle, so that no symmetry is left to keep nodes on a branch boundary.
void MakeSphere(int nodes, Scene* scene) {
  SetGrid(nodes, 1.0, Eigen::Vector3d(-0.5, -0.5, 0.0), Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), scene);
  const Eigen::Vector3d center(0.043, 0.021, -kSphereRadius - 0.01);
  AddObstacle("ball", std::make_shared<Sphere>(center, kSphereRadius), 0.4, scene);
  scene->material.density = 0.2;
  scene->material.bending_stiffness = 1e-3;
}

// The first row of nodes is the gripper's edge.
void MakeFold(int nodes, Scene* scene) {
  SetGrid(nodes, kFoldSize, Eigen::Vector3d(0.0, 0.0, kTableDistance), Eigen::Vector3d::UnitX(),
          Eigen::Vector3d::UnitY(), scene);
  static constexpr double kKnots[][3] = {{0.0, 0.0, 0.001},   {0.12, 0.02, 0.05},  {0.3, 0.1, 0.1},
                                         {0.5, 0.2, 0.05},    {0.6, 0.225, 0.012}, {0.75, 0.225, 0.008},
                                         {0.95, 0.18, 0.008}, {1.15, 0.22, 0.008}, {1.2, 0.22, 0.008}};  // t, x, z
  Eigen::VectorXd times(static_cast<Eigen::Index>(std::size(kKnots)));
  Eigen::MatrixXd positions(3 * nodes, times.size());
  for (Eigen::Index k = 0; k < times.size(); ++k) {
    times[k] = kKnots[k][0];
    for (int row = 0; row < nodes; ++row) {
      positions.col(k).segment<3>(3 * row) << kKnots[k][1], kFoldSize * row / (nodes - 1), kKnots[k][2];
    }
  }
  for (int row = 0; row < nodes; ++row) scene->handles.nodes.push_back(nodes * row);
  scene->handles.path = HandlePath(times, positions);
  AddObstacle("table", std::make_shared<Plane>(Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ()), 0.5, scene);
  scene->obstacles.back().contact_distance = kTableDistance;
  scene->material.density = 0.2;
  scene->material.bending_stiffness = 2e-5;
  scene->material.drag = scene->material.damping = 0.05;
  scene->duration = times[times.size() - 1];
}

}  // namespace

void AddObstacle(const std::string& name, std::shared_ptr<const Obstacle> shape, double friction_coefficient,
                 Scene* scene) {
  SceneObstacle obstacle;
  obstacle.name = name;
  obstacle.shape = std::move(shape);
  obstacle.friction_coefficient = friction_coefficient;
  scene->obstacles.push_back(std::move(obstacle));
}

Scene MakeBenchmarkScene(const std::string& name, int nodes, double stretch_stiffness, double time_step) {
  ExpectUsage(nodes >= 2, "--nodes: expected at least 2 nodes along an axis");
  RequireKnown({name}, kForwardScenes, "--scene");
  Scene scene;
  scene.integrator = Integrator::kEuler;  // unless a benchmark asks for both
  scene.time_step = time_step;
  scene.material.stretch_stiffness = stretch_stiffness;
  scene.material.drag = 0.0;
  if (name == "wind") {
    MakeWind(nodes, &scene);
  } else if (name == "slope") {
    MakeSlope(nodes, &scene);
  } else if (name == "fold" || name == "fold_through") {
    MakeFold(nodes, &scene);
    if (name == "fold") scene.self_contact = SelfContact{kFoldFriction, kFoldThickness};
  } else {
    MakeSphere(nodes, &scene);
  }
  return scene;
}

}  // namespace clothid
