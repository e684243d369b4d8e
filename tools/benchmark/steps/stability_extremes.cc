// Scenes at the limits.
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <utility>

#include "sim/mesh/mesh.h"
#include "tools/benchmark/base/benchmark_scene.h"
#include "tools/benchmark/steps/stability_scene.h"

namespace clothid {
namespace {

constexpr double kStretchStiffness = 1000.0;  // N/m
constexpr double kTimeStep = 0.005;           // s
constexpr double kMu = 0.35;
constexpr double kGravity = 9.81;    // m/s^2
constexpr double kSliver = 1e-4;     // width of a sliver relative to its length
constexpr int kGradingExponent = 4;  // of the graded mesh: 12 x 12 nodes have masses from 1 to 1.6e7
constexpr std::uint64_t kCrumpleSeed = 5;
constexpr double kBoundaryMu = 0.5;  // exact in floating point, and so are the forces of BranchBoundary

Scene Drape(int nodes) {
  return MakeStabilityScene({"drape", ContactMode::kGap, kStretchStiffness, kTimeStep, kMu}, nodes);
}

// The drape, changed by a function of its scene.
template <typename Change>
std::function<Scene(int)> DrapeWith(Change change) {
  return [change](int nodes) {
    Scene scene = Drape(nodes);
    change(&scene);
    return scene;
  };
}

Mesh FlatGrid(std::array<int, 2> nodes, std::array<double, 2> size, const Eigen::Vector3d& origin) {
  GridOptions grid;
  grid.nodes = nodes;
  grid.size = size;
  grid.origin = origin;
  return MakeGrid(grid);
}

// The drape with another cloth, which falls at `speed` [m/s].
Scene DrapeOf(Mesh mesh, double speed) {
  Scene scene = Drape(2);
  scene.mesh = std::move(mesh);
  StartAtRestShape(Eigen::Vector3d(0.0, 0.0, -speed), &scene);
  return scene;
}

Scene Graded(int nodes) {
  const double corner = -0.45;  // m; the small triangles hang over the side
  Mesh mesh = FlatGrid({nodes, nodes}, {1.0, 1.0}, Eigen::Vector3d::Zero());
  for (int node = 0; node < mesh.num_nodes(); ++node) {
    for (int axis = 0; axis < 2; ++axis) {
      double& x = mesh.rest_positions(axis, node);
      x = std::pow(x, kGradingExponent) + corner;
    }
  }
  return DrapeOf(std::move(mesh), 1.0);
}

// One column of nodes next to another: its triangles are as wide as kSliver times their length.
Scene Slivers(int nodes) {
  const double spacing = 1.0 / (nodes - 1);
  Mesh mesh = FlatGrid({nodes, nodes}, {1.0, 1.0}, Eigen::Vector3d(-0.45, -0.48, 0.0));
  for (int row = 0; row < nodes; ++row) {
    mesh.rest_positions(0, nodes / 2 + nodes * row) -= (1.0 - kSliver) * spacing;
  }
  return DrapeOf(std::move(mesh), 1.0);
}

// The cloth over a plane, 5 cm above, with mu = 0.35.
Scene OverPlane(int nodes) {
  Scene scene = Drape(nodes);
  scene.obstacles.clear();
  const Eigen::Vector3d point(0.0, 0.0, -0.05);
  AddObstacle("plane", std::make_shared<Plane>(point, Eigen::Vector3d::UnitZ()), kMu, &scene);
  return scene;
}

// A flat cloth that falls on the plane, what is beyond `crease` (m, of 1 m) folded back upon the rest without a gap.
Scene Folded(int nodes, double crease) {
  Scene scene = OverPlane(nodes);
  scene.mesh = FlatGrid({nodes, nodes}, {1.0, 1.0}, Eigen::Vector3d::Zero());
  StartAtRestShape(Eigen::Vector3d(0.0, 0.0, -1.0), &scene);
  for (int node = 0; node < scene.mesh.num_nodes(); ++node) {
    double& x = scene.initial_positions[3 * node];
    x = std::min(x, 2.0 * crease - x);
  }
  return scene;
}

Scene FoldedFlat(int nodes) { return Folded(nodes, static_cast<double>(nodes / 2) / (nodes - 1)); }

// The crease lies between two columns of nodes, whose triangles have no area left.
Scene Collapsed(int nodes) { return Folded(nodes, (nodes / 2 - 0.5) / (nodes - 1)); }

// Pressed to a third of its size, every node off its place by up to half the distance of neighbours.
Scene Crumpled(int nodes) {
  Scene scene = OverPlane(nodes);
  std::mt19937_64 generator(kCrumpleSeed);
  std::uniform_real_distribution<double> uniform(-0.5 / nodes, 0.5 / nodes);
  for (double& x : scene.initial_positions) x = x / 3.0 + uniform(generator);
  scene.initial_velocities.setZero();
  return scene;
}

// Two corners jerked to and fro by half the cloth's size, each time within 10 steps.
Scene FastHandle(int nodes) {
  Scene scene = Drape(nodes);
  scene.obstacles.clear();
  StartAtRestShape(Eigen::Vector3d::Zero(), &scene);
  scene.handles.nodes = {0, nodes - 1};
  const Eigen::Vector4d times(0.0, 0.05, 0.1, 0.15), shares(0.0, 0.5, 0.0, -0.5);
  Eigen::MatrixXd path(6, 4);
  for (int handle = 0; handle < 2; ++handle) {
    const Eigen::Vector3d start = scene.initial_positions.segment<3>(3 * scene.handles.nodes[handle]);
    for (int i = 0; i < 4; ++i) path.block<3, 1>(3 * handle, i) = start + shares[i] * Eigen::Vector3d(1.0, 0.0, 1.0);
  }
  scene.handles.path = HandlePath(times, path);
  return scene;
}

// Nothing moves and nothing acts: every term of the step is zero, and so is the scale of its residual.
Scene Nothing(int nodes) {
  Scene scene = Drape(nodes);
  scene.gravity.setZero();
  scene.mesh = FlatGrid({nodes, nodes}, {1.0, 1.0}, Eigen::Vector3d::Zero());
  StartAtRestShape(Eigen::Vector3d::Zero(), &scene);
  return scene;
}

// At rest on a plane, touching it exactly.
Scene OnPlane(int nodes) {
  Scene scene = Nothing(nodes);
  scene.obstacles.clear();
  AddObstacle("plane", std::make_shared<Plane>(Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ()), kBoundaryMu, &scene);
  return scene;
}

// |f_T| = -mu f_N at every node: gravity leans by as much as friction holds.
Scene ConeBoundary(int nodes) {
  Scene scene = OnPlane(nodes);
  scene.gravity = Eigen::Vector3d(kBoundaryMu * kGravity, 0.0, -kGravity);
  return scene;
}

Scene OneTriangle(int) {
  Mesh mesh;
  mesh.rest_positions.resize(3, 3);
  mesh.rest_positions << -0.1, 0.2, 0.05,  //
      -0.1, -0.05, 0.2,                    //
      0.0, 0.01, 0.02;
  mesh.faces = Eigen::Vector3i(0, 1, 2);
  return DrapeOf(std::move(mesh), 1.0);
}

Scene Strip(int nodes) { return DrapeOf(FlatGrid({nodes, 2}, {1.0, 0.1}, Eigen::Vector3d(-0.45, -0.03, 0.0)), 1.0); }

// A copy of the cloth in a plane above it.
Scene TwoPieces(int nodes) {
  Scene scene = Drape(nodes);
  const Mesh one = scene.mesh;
  const int num_nodes = one.num_nodes(), num_faces = one.num_faces();
  scene.mesh.rest_positions.resize(3, 2 * num_nodes);
  scene.mesh.rest_positions << one.rest_positions, one.rest_positions.colwise() + Eigen::Vector3d(0.2, 0.1, 0.1);
  scene.mesh.faces.resize(3, 2 * num_faces);
  scene.mesh.faces << one.faces, one.faces.array() + num_nodes;
  StartAtRestShape(Eigen::Vector3d(0.0, 0.0, -1.0), &scene);
  return scene;
}

// Hits the falling cloth at 5 m/s from below, and stops at once.
void Ram(Scene* scene) {
  MoveLastObstacle([](double t) { return Eigen::Vector3d(0.0, 0.0, std::min(5.0 * t, 0.4)); }, 0.0, scene);
}

void Spin(Scene* scene) {
  // About an axis through the ball.
  const auto* ball = dynamic_cast<const Sphere*>(scene->obstacles[0].shape.get());
  const Eigen::Vector3d center = ball->center();
  scene->obstacles[0].shape = std::make_shared<Sphere>(Eigen::Vector3d::Zero(), ball->radius());
  MoveLastObstacle([center](double) { return center; }, 30.0, scene);
}

// A second ball comes down on the cloth and, at the end, into the first one: what lies between cannot be outside of
// both.
void Pinch(Scene* scene) {
  AddObstacle("jaw", std::make_shared<Sphere>(Eigen::Vector3d(0.1, 0.0, 0.5), 0.3), kMu, scene);
  MoveLastObstacle([](double t) { return Eigen::Vector3d(0.0, 0.0, -2.0 * t); }, 0.0, scene);
}

// Sweeps through the place where the cloth starts, within it at first.
void Sweep(Scene* scene) {
  MoveLastObstacle([](double t) { return Eigen::Vector3d(0.5 * t, 2.0 * t - 0.2, 0.25); }, 0.0, scene);
}

std::vector<StabilityExtreme> MakeExtremes() {
  std::vector<StabilityExtreme> extremes;
  for (const std::string ratio : {"1e-6", "1e-5", "1e-4", "1e-3", "1e-2", "1e-1", "1"}) {
    const double value = std::stod(ratio) * kStretchStiffness;
    extremes.push_back(
        {"bending_" + ratio, DrapeWith([value](Scene* scene) { scene->material.bending_stiffness = value; })});
  }
  for (const std::string density : {"1e-3", "1e-2", "1e-1", "1", "10"}) {
    const double value = std::stod(density);
    extremes.push_back({"density_" + density, DrapeWith([value](Scene* scene) { scene->material.density = value; })});
  }
  const auto inside = [](Scene* scene) {
    for (int node = 0; node < scene->mesh.num_nodes(); ++node) scene->initial_positions[3 * node + 2] -= 0.1;
    scene->initial_velocities.setZero();
  };
  const auto unconnected = [](Scene* scene) {
    scene->mesh.rest_positions.conservativeResize(3, scene->mesh.num_nodes() + 1);
    scene->mesh.rest_positions.rightCols<1>() = Eigen::Vector3d(0.0, 0.0, 1.0);
    StartAtRestShape(Eigen::Vector3d(0.0, 0.0, -1.0), scene);
  };
  const std::vector<StabilityExtreme> others = {
      {"graded", Graded},
      {"slivers", Slivers},
      {"folded", FoldedFlat},
      {"collapsed", Collapsed},
      {"crumpled", Crumpled},
      {"inside", DrapeWith(inside)},
      {"impact", DrapeWith([](Scene* scene) { StartAtRestShape(Eigen::Vector3d(0.0, 0.0, -20.0), scene); })},
      {"fast_handle", FastHandle},
      {"zero_gravity", DrapeWith([](Scene* scene) { scene->gravity.setZero(); })},
      {"nothing", Nothing},
      {"frictionless", DrapeWith([](Scene* scene) { scene->obstacles[0].friction_coefficient = 0.0; })},
      {"touching", OnPlane},
      {"cone_boundary", ConeBoundary},
      {"one_triangle", OneTriangle},
      {"strip", Strip},
      {"two_pieces", TwoPieces},
      {"unconnected", DrapeWith(unconnected)},
      {"rammed", DrapeWith(Ram)},
      {"spinning", DrapeWith(Spin)},
      {"pinched", DrapeWith(Pinch)},
      {"swept_through", DrapeWith(Sweep)},
  };
  extremes.insert(extremes.end(), others.begin(), others.end());
  return extremes;
}

}  // namespace

const std::vector<StabilityExtreme>& StabilityExtremes() {
  static const std::vector<StabilityExtreme> extremes = MakeExtremes();
  return extremes;
}

}  // namespace clothid
