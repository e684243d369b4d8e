#include "tools/benchmark/steps/stability_scene.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>

#include "tools/benchmark/base/benchmark_scene.h"

namespace clothid {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kDegree = kPi / 180.0;
constexpr double kClothSize = 1.0;          // m
constexpr double kDuration = 0.3;           // s
constexpr double kDensity = 0.2;            // kg/m^2
constexpr double kBendingStiffness = 1e-3;  // N m
constexpr double kWave = 0.005;             // m
constexpr double kSphereRadius = 0.3;       // m
constexpr double kPushSpeed = 1.0;          // m/s
constexpr double kPushSpin = 10.0;          // rad/s
constexpr double kSlopeAngle = 25.0 * kDegree;
constexpr double kTilt = 3.0 * kDegree;     // of the cloth over the slope
constexpr double kTurned = 20.0 * kDegree;  // the cloth about its normal: no row of nodes lands at once
constexpr double kThickness = 0.005;        // m, of fold
constexpr double kTableFriction = 0.35;     // likewise
constexpr double kArcEdges = 3.0;           // likewise, around which it is folded
constexpr double kLowerShare = 0.6;         // of what is not the arc
constexpr double kDrag = 0.4;               // kg/(m^2 s)

// Waves of two different lengths, so that no symmetry is left.
void AddWaves(int nodes, const Eigen::Vector3d& normal, Mesh* mesh) {
  for (int node = 0; node < mesh->num_nodes(); ++node) {
    const double u = static_cast<double>(node % nodes) / (nodes - 1),
                 v = static_cast<double>(node / nodes) / (nodes - 1);
    mesh->rest_positions.col(node) += kWave * std::sin(2.2 * kPi * u + 0.3) * std::sin(2.9 * kPi * v + 0.8) * normal;
  }
}

Scene MakeDrape(int nodes, double friction_coefficient) {
  Scene scene =
      MakeStabilityCloth(nodes, Eigen::Vector3d(0.05, 0.02, 0.0), Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY());
  const Eigen::Vector3d center(0.0, 0.0, -kSphereRadius - 2.0 * kWave);
  AddObstacle("ball", std::make_shared<Sphere>(center, kSphereRadius), friction_coefficient, &scene);
  StartAtRestShape(Eigen::Vector3d(0.0, 0.0, -1.0), &scene);
  return scene;
}

Scene MakePush(int nodes, double friction_coefficient) {
  Scene scene = MakeDrape(nodes, friction_coefficient);
  scene.obstacles.clear();
  AddObstacle("ball", std::make_shared<Sphere>(Eigen::Vector3d::Zero(), kSphereRadius), friction_coefficient, &scene);
  const auto place = [](double t) { return Eigen::Vector3d(0.0, kPushSpeed * t, -kSphereRadius - 2.0 * kWave); };
  MoveLastObstacle(place, kPushSpin, &scene);
  return scene;
}

Scene MakeSlope(int nodes, double friction_coefficient) {
  const Eigen::AngleAxisd slope(kSlopeAngle, Eigen::Vector3d::UnitY());
  const Eigen::Vector3d normal = slope * Eigen::Vector3d::UnitZ();
  const Eigen::Quaterniond turn =
      slope * Eigen::AngleAxisd(kTilt, Eigen::Vector3d::UnitY()) * Eigen::AngleAxisd(kTurned, Eigen::Vector3d::UnitZ());
  Scene scene = MakeStabilityCloth(nodes, Eigen::Vector3d::Zero(), turn * Eigen::Vector3d::UnitX(),
                                   turn * Eigen::Vector3d::UnitY());
  const double lowest = (normal.transpose() * scene.mesh.rest_positions).minCoeff();
  AddObstacle("plane", std::make_shared<Plane>((lowest - kWave) * normal, normal), friction_coefficient, &scene);
  StartAtRestShape(-0.5 * normal, &scene);
  return scene;
}

Scene MakeFold(int nodes, double friction_coefficient) {
  Scene scene = MakeStabilityCloth(nodes, Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY());
  const double arc = kArcEdges * kClothSize / (nodes - 1), radius = arc / kPi;
  const double lower = kLowerShare * (kClothSize - arc);
  const Eigen::Vector3d thrown(0.0, 0.5, -1.0);  // m/s
  for (int node = 0; node < scene.mesh.num_nodes(); ++node) {
    const Eigen::Vector3d rest = scene.mesh.rest_positions.col(node);
    const double way = rest.x() + 0.5 * kClothSize, share = std::clamp((way - lower) / arc, 0.0, 1.0);
    const double out = radius - rest.z();  // from the axis of the arc
    const double along = share < 1.0 ? std::min(way, lower) : 2.0 * lower + arc - way;
    scene.initial_positions.segment<3>(3 * node) << along + out * std::sin(kPi * share), rest.y(),
        radius - out * std::cos(kPi * share);
    scene.initial_velocities.segment<3>(3 * node) = share * thrown;
  }
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  AddObstacle("table", std::make_shared<Plane>(-2.0 * kWave * up, up), kTableFriction, &scene);
  scene.self_contact = SelfContact{friction_coefficient, kThickness};
  return scene;
}

Scene MakeWind(int nodes) {
  Scene scene = MakeStabilityCloth(nodes, Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitX(), -Eigen::Vector3d::UnitZ());
  scene.handles.nodes = {0, nodes - 1};
  scene.material.drag = kDrag;
  scene.wind.mean = Eigen::Vector3d(0.5, 3.0, 0.0);
  scene.wind.gust = Eigen::Vector3d(0.0, 3.0, 1.0);
  scene.wind.frequency = 12.0;
  scene.wind.wave_vector = Eigen::Vector3d(3.0, 0.0, 2.0);
  return scene;
}

}  // namespace

Scene MakeStabilityCloth(int nodes, const Eigen::Vector3d& center, const Eigen::Vector3d& first_axis,
                         const Eigen::Vector3d& second_axis) {
  Scene scene;
  GridOptions grid;
  grid.nodes = {nodes, nodes};
  grid.size = {kClothSize, kClothSize};
  grid.origin = center - 0.5 * kClothSize * (first_axis + second_axis);
  grid.axes = {first_axis, second_axis};
  scene.mesh = MakeGrid(grid);
  AddWaves(nodes, first_axis.cross(second_axis), &scene.mesh);
  scene.duration = kDuration;
  scene.material.density = kDensity;
  scene.material.bending_stiffness = kBendingStiffness;
  StartAtRestShape(Eigen::Vector3d::Zero(), &scene);
  return scene;
}

void StartAtRestShape(const Eigen::Vector3d& velocity, Scene* scene) {
  const Eigen::Matrix3Xd& rest = scene->mesh.rest_positions;
  scene->initial_positions = Eigen::Map<const Eigen::VectorXd>(rest.data(), rest.size());
  scene->initial_velocities = velocity.replicate(scene->mesh.num_nodes(), 1);
}

void MoveLastObstacle(const std::function<Eigen::Vector3d(double)>& place, double spin, Scene* scene) {
  constexpr int kRows = 301;  // one a millisecond
  const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(kRows, 0.0, kDuration);
  Eigen::Matrix3Xd positions(3, kRows);
  Eigen::Matrix4Xd rotations(4, kRows);
  for (int i = 0; i < kRows; ++i) {
    positions.col(i) = place(times[i]);
    const double half = 0.5 * spin * times[i];
    rotations.col(i) << std::sin(half), 0.0, 0.0, std::cos(half);
  }
  scene->obstacles.back().path = std::make_shared<RigidPath>(times, positions, rotations);
}

bool StabilitySceneHasObstacle(const std::string& name) { return name != "wind"; }

bool StabilitySceneMeetsItself(const std::string& name) { return name == "fold"; }

Scene MakeStabilityScene(const StabilityCell& cell, int nodes) {
  Scene scene = !StabilitySceneHasObstacle(cell.scene) ? MakeWind(nodes)
                : cell.scene == "drape"                ? MakeDrape(nodes, cell.friction_coefficient)
                : cell.scene == "fold"                 ? MakeFold(nodes, cell.friction_coefficient)
                : cell.scene == "push"                 ? MakePush(nodes, cell.friction_coefficient)
                                                       : MakeSlope(nodes, cell.friction_coefficient);
  scene.contact_mode = cell.contact_mode;
  scene.time_step = cell.time_step;
  scene.integrator = cell.integrator;
  Material& material = scene.material;
  if (cell.stiffening > 0.0) {
    scene.membrane = MembraneLaw::kYarn;
    material.stretch_stiffness = 0.0;
    material.warp_stiffness = material.weft_stiffness = cell.stretch_stiffness;
    material.shear_stiffness = 0.5 * cell.stretch_stiffness;
    material.warp_stiffening = material.weft_stiffening = cell.stiffening;
  } else {
    material.stretch_stiffness = cell.stretch_stiffness;
  }
  return scene;
}

}  // namespace clothid
