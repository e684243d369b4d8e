// A step is a continuous function of the state that it starts from, through all branches of the contact law: on a
// smooth obstacle in gap mode. On triangles, and in velocity mode, it jumps.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "sim/obstacle/triangulated_surface.h"
#include "sim/rollout/rollout.h"
#include "sim/rollout/simulator.h"
#include "tests/sim/scene/triangle_meshes.h"

namespace clothid::continuity_test {
namespace {

constexpr int kNodes = 5, kLines = 3, kPoints = 513;  // along a line
constexpr double kClothSize = 0.2;                    // m
constexpr double kTimeStep = 0.004;                   // s
constexpr double kSpeed = 9.81 * kTimeStep;           // m/s

// A soft cloth that lies on a unit sphere, 10 degrees off its top, with friction that holds some of its nodes.
Scene MakeScene(std::shared_ptr<const Obstacle> shape, ContactMode mode) {
  Scene scene;
  scene.integrator = Integrator::kEuler;
  scene.contact_mode = mode;
  scene.time_step = kTimeStep;
  scene.duration = kTimeStep;
  scene.solver.step_tolerance = 1e-12;
  scene.material.density = 0.3;
  scene.material.stretch_stiffness = 5.0;
  scene.material.bending_stiffness = 5e-6;
  GridOptions grid;
  grid.nodes = {kNodes, kNodes};
  grid.size = {kClothSize, kClothSize};
  grid.origin = Eigen::Vector3d(std::sin(0.17) - 0.5 * kClothSize, -0.47 * kClothSize, 1.0);
  scene.mesh = MakeGrid(grid);
  for (int node = 0; node < scene.mesh.num_nodes(); ++node) {
    const SurfacePoint closest = shape->Closest(scene.mesh.rest_positions.col(node));
    scene.mesh.rest_positions.col(node) -= closest.gap * closest.normal;
  }
  scene.initial_positions = scene.mesh.rest_positions.reshaped();
  scene.initial_velocities = Eigen::VectorXd::Zero(scene.initial_positions.size());
  SceneObstacle ball;
  ball.name = "ball";
  ball.shape = std::move(shape);
  ball.friction_coefficient = 0.35;
  scene.obstacles.push_back(std::move(ball));
  return scene;
}

// A difference of states: velocities of the size that gravity gives in a step, positions off the surface of the size
// that it moves a node by, and a shift of all nodes along it.
void AddRandom(double factor, std::mt19937_64 generator, Scene* scene) {
  std::normal_distribution<double> normal;
  const auto random_vector = [&] {
    const double x = normal(generator), y = normal(generator), z = normal(generator);
    return Eigen::Vector3d(x, y, z);
  };
  const Eigen::Vector3d shift = 0.005 * random_vector();
  for (int node = 0; node < scene->mesh.num_nodes(); ++node) {
    const Eigen::Vector3d n = scene->obstacles[0].shape->Closest(scene->mesh.rest_positions.col(node)).normal;
    const double lift = kTimeStep * kSpeed * normal(generator);
    scene->initial_positions.segment<3>(3 * node) += factor * (shift - n.dot(shift) * n + lift * n);
    scene->initial_velocities.segment<3>(3 * node) += factor * kSpeed * random_vector();
  }
}

// The largest change of any node's velocity from one point of a line of start states to the next but `stride` - 1.
class Jumps {
 public:
  explicit Jumps(const Scene& scene) {
    for (int line = 0; line < kLines; ++line) {
      std::vector<Eigen::VectorXd> velocities;
      for (int i = 0; i < kPoints; ++i) {
        Scene start = scene;
        AddRandom(1.0, std::mt19937_64(2 * line), &start);
        AddRandom(2.0 * i / (kPoints - 1) - 1.0, std::mt19937_64(2 * line + 1), &start);
        Simulator simulator(start);
        const Rollout rollout = Simulate(start.nominal_parameters(), 1, &simulator);
        EXPECT_TRUE(rollout.ok());
        velocities.push_back(rollout.records.back().velocities);
        for (const ContactRecord& contact : rollout.records.back().contacts.nodes) branches_.insert(contact.branch);
      }
      lines_.push_back(std::move(velocities));
    }
  }

  double Largest(int stride) const {
    double largest = 0.0;
    for (const std::vector<Eigen::VectorXd>& line : lines_) {
      for (int i = stride; i < kPoints; i += stride) {
        const Eigen::VectorXd change = line[i] - line[i - stride];
        largest = std::max(largest, change.reshaped(3, change.size() / 3).colwise().norm().maxCoeff());
      }
    }
    return largest;
  }

  const std::set<ContactBranch>& branches() const { return branches_; }

 private:
  std::vector<std::vector<Eigen::VectorXd>> lines_;
  std::set<ContactBranch> branches_;
};

std::shared_ptr<const Obstacle> UnitSphere() { return std::make_shared<Sphere>(Eigen::Vector3d::Zero(), 1.0); }

TEST(ContinuityTest, OnASphereInGapModeJumpsHalveWithTheDistanceOfTheStarts) {
  const Jumps jumps(MakeScene(UnitSphere(), ContactMode::kGap));
  EXPECT_EQ(jumps.branches().count(ContactBranch::kStick), 1u);
  EXPECT_EQ(jumps.branches().count(ContactBranch::kSlip), 1u);
  for (const int stride : {1, 2, 4}) EXPECT_LE(jumps.Largest(stride), 0.6 * jumps.Largest(2 * stride)) << stride;
}

TEST(ContinuityTest, OnTrianglesVelocitiesJump) {
  const TriangleMesh mesh = IcosphereMesh(2, 1.0);
  const Jumps jumps(MakeScene(std::make_shared<TriangulatedSurface>(mesh.vertices, mesh.faces), ContactMode::kGap));
  EXPECT_GE(jumps.Largest(1), 0.85 * jumps.Largest(2));
}

TEST(ContinuityTest, InVelocityModeVelocitiesJumpOnTheSphereToo) {
  const Jumps jumps(MakeScene(UnitSphere(), ContactMode::kVelocity));
  EXPECT_GE(jumps.Largest(1), 0.85 * jumps.Largest(2));
}

}  // namespace
}  // namespace clothid::continuity_test
