// Experiments of datasets/experiments against what is known of them in closed form.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "sim/rollout/handle_forces.h"
#include "tests/datasets/experiments/experiment.h"
#include "tests/sim/heavy_elastica.h"
#include "tests/sim/plain_scenes.h"

namespace clothid::experiment_forms_test {
namespace {

constexpr double kGravity = 9.81;  // m/s^2

std::vector<int> NodesFrom(int first, int count) {
  std::vector<int> nodes(count);
  std::iota(nodes.begin(), nodes.end(), first);
  return nodes;
}

// The forces [3G x (T + 1)] N on groups of handles.
Eigen::MatrixXd ForcesOver(const Scene& scene, const std::vector<std::vector<int>>& groups) {
  Simulator simulator(scene);
  const Parameters parameters = scene.nominal_parameters();
  const Rollout rollout = Simulate(parameters, scene.num_steps(), &simulator);
  EXPECT_TRUE(rollout.ok()) << rollout.failure->ToString();
  const HandleForces forces(simulator.model(), parameters, scene.num_steps(), groups);
  Eigen::MatrixXd positions(3 * forces.nodes().size(), scene.num_steps() + 1);
  for (int step = 0; step <= scene.num_steps(); ++step) positions.col(step) = forces.Gather(rollout.positions(step));
  return forces.Over(positions);
}

// ASTM D1388. The strip is brought to rest by long steps of backward Euler.
class CantileverTest : public testing::Test {
 protected:
  static constexpr int kColumns = 7;

  CantileverTest() : scene_(Experiment("cantilever")) {
    const auto& rest = scene_.mesh.rest_positions;
    length_ = rest(1, rest.cols() - 1);
    scene_.integrator = Integrator::kEuler;
    scene_.time_step = 0.1;
    const Rollout rollout = SimulateNominal(scene_, kNumSteps);
    const int last_row = scene_.mesh.num_nodes() - kColumns;
    tip_ = MeanOf(rollout.positions(kNumSteps), last_row, kColumns);
    EXPECT_LE((tip_ - MeanOf(rollout.positions(kNumSteps - 1), last_row, kColumns)).norm(), 1e-5 * length_);
  }

  // B/(rho g), m^3.
  double bending_cube() const { return scene_.material.bending_stiffness / (scene_.material.density * kGravity); }
  double angle() const {
    return std::atan2(-tip_.z(), tip_.y());
  }  // of the line from edge to tip, below the horizontal

  static constexpr int kNumSteps = 60;
  Scene scene_;
  double length_ = 0.0;  // of what overhangs, m
  Eigen::Vector3d tip_;  // at rest; the edge is at y = z = 0
};

TEST_F(CantileverTest, HasTheWidthOfTheStandardAndTheClampAtTheEdge) {
  const auto& rest = scene_.mesh.rest_positions;
  EXPECT_NEAR(rest.row(0).maxCoeff() - rest.row(0).minCoeff(), 0.025, 1e-9);
  EXPECT_EQ(rest.row(1).minCoeff(), 0.0);
  ASSERT_EQ(scene_.handles.clamped.size(), static_cast<std::size_t>(kColumns - 1));
  for (const ClampedEdge& edge : scene_.handles.clamped) EXPECT_EQ(rest(1, edge.nodes[0]), 0.0);
}

TEST_F(CantileverTest, SagsAsTheElasticaToTheLineOfTheStandard) {
  const Eigen::Vector2d expected = HeavyElastica(std::pow(length_, 3) / bending_cube(), length_).tip();
  EXPECT_NEAR(tip_.y(), expected.x(), 0.006 * length_);
  EXPECT_NEAR(-tip_.z(), expected.y(), 0.006 * length_);
  EXPECT_NEAR(angle() * 180.0 / kPi, 41.5, 1.0);
}

// Peirce: the bending length is c = (B/(rho g))^(1/3) = l (cos(a/2)/(8 tan a))^(1/3), which is l/2 at 41.5 degrees.
TEST_F(CantileverTest, ShowsTheBendingLengthOfPeirce) {
  const double expected = std::cbrt(bending_cube());
  EXPECT_NEAR(length_ * std::cbrt(std::cos(angle() / 2.0) / (8.0 * std::tan(angle()))), expected, 0.03 * expected);
  EXPECT_NEAR(length_ / 2.0, expected, 0.03 * expected);
}

// ISO 13934-1. A membrane by ARAP has no lateral contraction: T = k e w. Half of the difference of what the jaws pull
// is free of the weight, their sum is the weight.
TEST(TensileStripTest, PullsWithStiffnessTimesStrainTimesWidth) {
  constexpr double kWidth = 0.05, kLength = 0.2;  // m
  constexpr int kColumns = 6;
  Scene scene = Experiment("tensile");
  const int last_row = scene.mesh.num_nodes() - kColumns;
  const Eigen::MatrixXd forces = ForcesOver(scene, {NodesFrom(0, kColumns), NodesFrom(last_row, kColumns)});
  const double weight = scene.material.density * kWidth * kLength * kGravity;
  for (const int step : {30, 60, 90, scene.num_steps()}) {
    const double strain = step * scene.time_step * 0.1 / 60.0 / kLength;  // 100 mm/min
    const double expected = scene.material.stretch_stiffness * strain * kWidth;
    EXPECT_NEAR((forces(2, step) - forces(5, step)) / 2.0, expected, 0.01 * expected) << "step " << step;
    EXPECT_NEAR(forces(2, step) + forces(5, step), weight, 0.01 * weight) << "step " << step;
  }
}

// s = (sin a - mu cos a) g t^2/2 for mu < tan a, else nothing.
TEST(InclineExperimentTest, SlipsByTheLawOfCoulomb) {
  const double angle = 25.0 * kPi / 180.0;
  for (const double mu : {0.0, 0.3, 0.45, 0.5}) {
    Scene scene = Experiment("incline");
    scene.obstacles[0].friction_coefficient = mu;
    scene.material.drag = 0.0;
    const int num_nodes = scene.mesh.num_nodes(), last = scene.num_steps();
    const Rollout rollout = SimulateNominal(scene, last);
    const Eigen::Vector3d way =
        MeanOf(rollout.positions(last), 0, num_nodes) - MeanOf(rollout.initial_positions, 0, num_nodes);
    const double downhill = std::cos(angle) * way.x() - std::sin(angle) * way.z();
    const double expected = std::max(0.0, std::sin(angle) - mu * std::cos(angle)) * kGravity;
    const double seconds = last * scene.time_step;
    EXPECT_NEAR(2.0 * downhill / (seconds * seconds), expected, 0.01 * expected + 1e-6) << "mu " << mu;
  }
}

// A stiff sheet is a compound pendulum: its period is 2 pi sqrt(I/(m g d))/agm(1, cos(a/2)) with the amplitude a, its
// moment of inertia I about the edge that is held and its centre d below it.
TEST(SwingTest, HasThePeriodOfACompoundPendulumWhereItIsStiff) {
  Scene scene = Experiment("swing");
  scene.material.bending_stiffness = 1.0;
  scene.material.stretch_stiffness = 1e4;
  scene.material.drag = 0.0;
  scene.duration = 1.4;
  const Eigen::VectorXd areas = NodeAreas(scene.mesh);
  double moment = 0.0, inertia = 0.0;
  for (int node = 0; node < scene.mesh.num_nodes(); ++node) {
    const double radius = scene.mesh.rest_positions.col(node).tail<2>().norm();
    moment += areas[node] * radius;
    inertia += areas[node] * radius * radius;
  }
  double a = 1.0, g = std::cos(15.0 * kPi / 180.0);  // of half the amplitude
  for (int i = 0; i < 6; ++i) std::tie(a, g) = std::make_pair((a + g) / 2.0, std::sqrt(a * g));
  const double period = 2.0 * kPi * std::sqrt(inertia / (moment * kGravity)) / a;

  const Rollout rollout = SimulateNominal(scene, scene.num_steps());
  const auto y = [&](int step) { return MeanOf(rollout.positions(step), 0, scene.mesh.num_nodes()).y(); };
  std::vector<double> crossings;  // s
  for (int step = 1; step <= scene.num_steps(); ++step) {
    const double before = y(step - 1), after = y(step);
    if (before * after < 0.0) crossings.push_back(scene.time_step * (step - 1 + before / (before - after)));
  }
  ASSERT_GE(crossings.size(), 3u);
  EXPECT_NEAR(crossings[2] - crossings[0], period, 0.01 * period);
}

// The tension of a heavy belt that is drawn up over a quarter of a cylinder, from `hanging` N below. At the angle t
// from where it meets the cylinder, with G = rho g w r: dT/dt = mu (T + G sin t) + G cos t.
double TensionBeyondTheEdge(double hanging, double mu, double weight) {
  const double b = -2.0 * mu * weight / (1.0 + mu * mu);
  const double a = weight * (1.0 - mu * mu) / (1.0 + mu * mu);  // T = a sin t + b cos t + (T_0 - b) exp(mu t)
  return a + (hanging - b) * std::exp(mu * kPi / 2.0);
}

// The force at the clamp is that tension and the friction of what lies on the table.
TEST(EdgeTest, PullsByTheLawOfTheCapstan) {
  constexpr double kWidth = 0.1, kLength = 0.4, kRadius = 0.025, kFlat = 0.18, kSpeed = 0.05, kStarts = 0.2;
  for (const double mu : {0.0, 0.4}) {
    Scene scene = Experiment("edge");
    scene.obstacles[0].friction_coefficient = mu;
    scene.material.drag = 0.0;
    scene.material.stretch_stiffness = 1e3;  // N/m: what stretches is longer beyond the edge
    scene.material.damping = 1.0;            // N s/m: the weight, which is there at once, must not ring along the strip
    const Eigen::MatrixXd forces = ForcesOver(scene, {scene.handles.nodes});
    const double weight = scene.material.density * kGravity * kWidth;  // N/m along the strip
    double sum = 0.0, expected = 0.0;
    for (int step = 40; step < 120; ++step) {  // drawn at an even speed
      const double flat = kFlat + kSpeed * (step * scene.time_step - kStarts / 2.0);
      const double hanging = kLength - flat - kRadius * kPi / 2.0;
      sum -= forces(1, step);
      expected += TensionBeyondTheEdge(weight * hanging, mu, weight * kRadius) + mu * weight * flat;
    }
    EXPECT_NEAR(sum, expected, 0.02 * expected) << "mu " << mu;
  }
}

}  // namespace
}  // namespace clothid::experiment_forms_test
