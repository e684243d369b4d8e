// Every scene of datasets/experiments runs, moves and touches what it should, and the page lists it as it is.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <map>
#include <set>
#include <string>

#include "sim/base/text_file.h"
#include "sim/fabric/fabric.h"
#include "tests/datasets/experiments/experiment.h"
#include "tests/sim/plain_scenes.h"

namespace clothid::experiments_test {
namespace {

struct Case {
  const char* name;
  double least_way;  // m, that some node is away from its start at the end or before it
  double
      least_friction;  // m, that some node is elsewhere at the end where mu is higher by a fifth; 0: it touches nothing

  bool touches() const { return least_friction > 0.0; }
};

// The clamp decides where the cloth of `edge` is: its friction is felt by the force (EdgeTest).
constexpr Case kCases[] = {
    {"cantilever", 0.02, 0.0}, {"cusick", 0.05, 0.0},     {"edge", 0.1, 1e-4},   {"incline", 0.2, 0.01},
    {"shake_fast", 0.03, 0.0}, {"shake_slow", 0.06, 0.0}, {"sphere", 0.1, 0.01}, {"swing", 0.2, 0.0},
    {"table", 0.3, 0.01},      {"tensile", 0.0079, 0.0},
};

class ExperimentTest : public testing::TestWithParam<Case> {
 protected:
  void SetUp() override { scene_ = Experiment(GetParam().name); }

  Rollout Run() const {
    Simulator simulator(scene_);
    return Simulate(scene_.nominal_parameters(), scene_.num_steps(), &simulator);
  }

  Scene scene_;
};

double LongestWay(const Rollout& rollout) {
  double longest = 0.0;
  for (int step = 1; step <= rollout.num_steps(); ++step) {
    const Eigen::VectorXd way = rollout.positions(step) - rollout.initial_positions;
    longest = std::max(longest, way.reshaped(3, way.size() / 3).colwise().norm().maxCoeff());
  }
  return longest;
}

TEST_P(ExperimentTest, RunsWithoutAFailedStepAndMoves) {
  const Rollout rollout = Run();
  ASSERT_TRUE(rollout.ok()) << rollout.failure->ToString();
  EXPECT_EQ(rollout.counts.failed_steps, 0);
  EXPECT_EQ(rollout.counts.substeps, 0);
  EXPECT_EQ(rollout.counts.contacts > 0, GetParam().touches());
  EXPECT_GE(LongestWay(rollout), GetParam().least_way);
  EXPECT_LE(LongestWay(rollout), 1.0) << "it falls out of the picture";
}

TEST_P(ExperimentTest, FrictionIsFeltWhereItTouches) {
  ASSERT_EQ(!scene_.obstacles.empty(), GetParam().touches());
  if (scene_.obstacles.empty()) return;
  const Rollout nominal = Run();
  for (SceneObstacle& obstacle : scene_.obstacles) {
    EXPECT_EQ(obstacle.friction_coefficient, 0.3);
    obstacle.friction_coefficient *= 1.2;
  }
  const Rollout rougher = Run();
  const int last = scene_.num_steps();
  EXPECT_GE((nominal.positions(last) - rougher.positions(last)).cwiseAbs().maxCoeff(), GetParam().least_friction);
}

TEST_P(ExperimentTest, StartsOutsideItsObstaclesWithoutStrain) {
  for (const SceneObstacle& obstacle : scene_.obstacles) {
    for (int node = 0; node < scene_.mesh.num_nodes(); ++node) {
      const SurfacePoint closest = obstacle.shape->Closest(scene_.initial_positions.segment<3>(3 * node));
      EXPECT_GE(closest.gap - obstacle.contact_distance, -1e-8) << obstacle.name << ", node " << node;
    }
  }
  for (int k = 0; k < scene_.mesh.num_faces(); ++k) {
    for (int i = 0; i < 3; ++i) {
      const int a = scene_.mesh.faces(i, k), b = scene_.mesh.faces((i + 1) % 3, k);
      const double rest = (scene_.mesh.rest_positions.col(a) - scene_.mesh.rest_positions.col(b)).norm();
      const double start =
          (scene_.initial_positions.segment<3>(3 * a) - scene_.initial_positions.segment<3>(3 * b)).norm();
      EXPECT_NEAR(start / rest, 1.0, 0.01) << "nodes " << a << " and " << b;  // `cusick` starts in low waves
    }
  }
}

TEST_P(ExperimentTest, IsAFabricOfMediumWeightInStepsOfSecondOrder) {
  const Fabric* medium = FindFabric("medium");
  EXPECT_EQ(scene_.fabric, "medium");
  EXPECT_EQ(scene_.material.density, medium->density.typical);
  EXPECT_EQ(scene_.material.bending_stiffness, medium->k_bend.typical);
  EXPECT_EQ(scene_.integrator, Integrator::kSdirk2);
  EXPECT_LE(scene_.num_steps(), 200);
}

INSTANTIATE_TEST_SUITE_P(Scenes, ExperimentTest, testing::ValuesIn(kCases),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(ExperimentsPageTest, ListsTheScenesOfTheFolderWithNodesAndSteps) {
  const std::string page = ReadText(std::string(CLOTHID_SOURCE_DIR) + "/datasets/README.md", 1 << 20);
  std::set<std::string> found;
  for (const auto& entry : std::filesystem::directory_iterator(kExperiments)) {
    const std::string file = entry.path().filename().string(), ending = ".scene.json";
    if (file.size() <= ending.size() || file.substr(file.size() - ending.size()) != ending) continue;
    const std::string name = file.substr(0, file.size() - ending.size());
    found.insert(name);
    const Scene scene = Experiment(name);
    const std::size_t row = page.find("\n| `" + name + "` | ");
    ASSERT_NE(row, std::string::npos) << name << " has no row";
    const std::string line = page.substr(row + 1, page.find('\n', row + 1) - row - 1);
    const std::string sizes =
        " | " + std::to_string(scene.mesh.num_nodes()) + ", " + std::to_string(scene.num_steps()) + " |";
    EXPECT_NE(line.find(sizes), std::string::npos) << line << " should end with" << sizes;
  }
  std::set<std::string> tested;
  for (const Case& experiment : kCases) tested.insert(experiment.name);
  EXPECT_EQ(found, tested);
}

// A hand goes to and fro once in a period.
TEST(ShakeTest, HasTheFrequencyThatIsStated) {
  for (const auto& [name, frequency] : std::map<std::string, double>{{"shake_slow", 1.0}, {"shake_fast", 2.5}}) {
    const Scene scene = Experiment(name);
    const auto y = [&](double time) { return scene.handles.path.At(time)[1]; };
    const double stroke = y(0.5 / frequency) - y(0.0);
    EXPECT_GE(stroke, 0.02) << name;
    for (const double time : {0.1, 0.37, 0.9}) {
      EXPECT_NEAR(y(time + 0.5 / frequency), stroke - y(time), 1e-3 * stroke) << name << " at " << time;
    }
  }
}

// ISO 9073-9: a specimen 30 cm wide, held within 9 cm of its middle.
TEST(CusickTest, HoldsTheSpecimenWithinTheDisc) {
  const Scene scene = Experiment("cusick");
  const std::set<int> held(scene.handles.nodes.begin(), scene.handles.nodes.end());
  std::set<double> held_rings, free_rings;
  for (int node = 0; node < scene.mesh.num_nodes(); ++node) {
    const double radius = std::round(1e6 * scene.mesh.rest_positions.col(node).norm()) / 1e6;
    (held.count(node) > 0 ? held_rings : free_rings).insert(radius);
  }
  EXPECT_NEAR(*free_rings.rbegin(), 0.15, 1e-6);
  EXPECT_GT(*free_rings.begin(), *held_rings.rbegin());
  EXPECT_NEAR((*held_rings.rbegin() + *std::next(held_rings.rbegin())) / 2.0, 0.09, 1e-6);
}

}  // namespace
}  // namespace clothid::experiments_test
