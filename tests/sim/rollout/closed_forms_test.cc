// The simulator against what is known in closed form. Where backward Euler has a discrete closed form, it is met to
// rounding; elsewhere the limit is met to the order of the method.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "sim/mesh/mesh.h"
#include "sim/obstacle/obstacle.h"
#include "sim/rollout/rollout.h"
#include "sim/rollout/simulator.h"
#include "sim/scene/scene.h"
#include "tests/sim/plain_scenes.h"

namespace clothid::closed_forms_test {
namespace {

constexpr double kGravity = 9.81;  // m/s^2

// The largest distance of a node from `translation` away from where it started.
double TranslationError(const Rollout& rollout, int step, const Eigen::Vector3d& translation) {
  const Eigen::VectorXd moved = rollout.positions(step) - rollout.initial_positions;
  return (moved.reshaped(3, moved.size() / 3).colwise() - translation).colwise().norm().maxCoeff();
}

// The largest distance of a node's velocity after `step` steps from `velocity`.
double VelocityError(const Rollout& rollout, int step, const Eigen::Vector3d& velocity) {
  const Eigen::VectorXd& velocities = rollout.records[rollout.last_record[step - 1]].velocities;
  return (velocities.reshaped(3, velocities.size() / 3).colwise() - velocity).colwise().norm().maxCoeff();
}

void SetUniformVelocity(const Eigen::Vector3d& velocity, Scene* scene) {
  scene->initial_velocities = velocity.replicate(scene->mesh.num_nodes(), 1);
}

double FreeFallError(double time_step, double duration) {
  const Scene scene = ClothScene(SquareGrid(5, 0.3), time_step);
  const int num_steps = static_cast<int>(std::lround(duration / time_step));
  const Rollout rollout = SimulateNominal(scene, num_steps);
  return TranslationError(rollout, num_steps, {0.0, 0.0, -0.5 * kGravity * duration * duration});
}

// v_n = -n h g, x_n - x_0 = -h^2 g n (n + 1)/2.
TEST(FreeFallTest, MeetsTheDiscreteFormula) {
  constexpr double kTimeStep = 0.01;
  constexpr int kNumSteps = 50;
  const Rollout rollout = SimulateNominal(ClothScene(SquareGrid(5, 0.3), kTimeStep), kNumSteps);
  for (const int step : {1, 10, kNumSteps}) {
    const double fall = kGravity * kTimeStep * kTimeStep * step * (step + 1) / 2.0;
    EXPECT_LE(TranslationError(rollout, step, {0.0, 0.0, -fall}), 1e-10 * fall) << "step " << step;
  }
}

// The error against g t^2/2 is g h t/2.
TEST(FreeFallTest, ConvergesInFirstOrderToTheParabola) {
  constexpr double kDuration = 0.4;  // s
  const double coarse = FreeFallError(0.02, kDuration);
  const double fine = FreeFallError(0.01, kDuration);
  EXPECT_NEAR(coarse, 0.5 * kGravity * 0.02 * kDuration, 1e-8);
  EXPECT_NEAR(coarse / fine, 2.0, 1e-6);
}

struct InclineCase {
  ContactMode mode;
  double angle;             // degrees
  double contact_distance;  // m
};

class InclineTest : public testing::TestWithParam<InclineCase> {
 protected:
  double angle() const { return GetParam().angle * kPi / 180.0; }
  // Down the slope.
  Eigen::Vector3d downhill() const { return {std::cos(angle()), 0.0, -std::sin(angle())}; }

  // A cloth that lies flat on a plane inclined about the y axis.
  Scene MakeScene(double friction_coefficient) const {
    const Eigen::Vector3d normal(std::sin(angle()), 0.0, std::cos(angle()));
    GridOptions grid = SquareGrid(6, 0.2);
    grid.axes = {downhill(), Eigen::Vector3d::UnitY()};
    grid.origin = GetParam().contact_distance * normal;
    Scene scene = ClothScene(grid, 0.005);
    scene.contact_mode = GetParam().mode;
    scene.obstacles.push_back({"slope", std::make_shared<Plane>(Eigen::Vector3d::Zero(), normal), friction_coefficient,
                               GetParam().contact_distance});
    return scene;
  }
};

constexpr int kInclineSteps = 40;

// All nodes carry load in proportion to their mass, so they stick or slide as one.
TEST_P(InclineTest, SticksWhereTheFrictionConeHoldsTheSlope) {
  for (const double factor : {1.001, 1.5}) {
    const Rollout rollout = SimulateNominal(MakeScene(factor * std::tan(angle())), kInclineSteps);
    EXPECT_LE(TranslationError(rollout, kInclineSteps, Eigen::Vector3d::Zero()), 1e-10) << "factor " << factor;
    for (const StepRecord& record : rollout.records) {
      for (const ContactRecord& contact : record.contacts.nodes) EXPECT_EQ(contact.branch, ContactBranch::kStick);
      EXPECT_EQ(record.contacts.nodes.size(), 36u);
    }
  }
}

// s_n = h^2 g (sin alpha - mu cos alpha) n (n + 1)/2.
TEST_P(InclineTest, SlidesWithTheAccelerationOfCoulombFriction) {
  for (const double factor : {0.0, 0.5, 0.999}) {
    const double mu = factor * std::tan(angle());
    const Scene scene = MakeScene(mu);
    const Rollout rollout = SimulateNominal(scene, kInclineSteps);
    const double acceleration = kGravity * (std::sin(angle()) - mu * std::cos(angle()));
    const double way = acceleration * scene.time_step * scene.time_step * kInclineSteps * (kInclineSteps + 1) / 2.0;
    EXPECT_LE(TranslationError(rollout, kInclineSteps, way * downhill()), 1e-9) << "factor " << factor;
    for (const ContactRecord& contact : rollout.records.back().contacts.nodes) {
      EXPECT_EQ(contact.branch, ContactBranch::kSlip);
    }
    EXPECT_EQ(rollout.records.back().contacts.nodes.size(), 36u);
  }
}

INSTANTIATE_TEST_SUITE_P(
    AnglesAndModes, InclineTest,
    testing::Values(InclineCase{ContactMode::kGap, 10.0, 0.0}, InclineCase{ContactMode::kGap, 25.0, 0.002},
                    InclineCase{ContactMode::kGap, 50.0, 0.0}, InclineCase{ContactMode::kVelocity, 10.0, 0.0},
                    InclineCase{ContactMode::kVelocity, 25.0, 0.002}, InclineCase{ContactMode::kVelocity, 50.0, 0.0}),
    [](const auto& test) {
      return std::string(test.param.mode == ContactMode::kGap ? "Gap" : "Velocity") +
             std::to_string(std::lround(test.param.angle));
    });

// The height of the lowest row below the highest, of cloth hung by its highest row, from rows of height `row_height`
// and width `width`. ARAP has no lateral contraction, so a row is stretched by diag(1, lambda) and carries the tension
// k (lambda - 1) width, which is the weight of the rows below it. `row_masses` [rows], the highest first, in kg.
double HungLength(const Eigen::VectorXd& row_masses, double row_height, double width, double stretch_stiffness) {
  double length = 0.0, weight = 0.0;
  for (Eigen::Index row = row_masses.size() - 1; row > 0; --row) {
    weight += kGravity * row_masses[row];
    length += row_height * (1.0 + weight / (stretch_stiffness * width));
  }
  return length;
}

// Masses of the rows of a mesh whose rows are blocks of `row_size` consecutive nodes.
Eigen::VectorXd RowMasses(const Mesh& mesh, double density, int row_size) {
  const Eigen::VectorXd areas = NodeAreas(mesh);
  return density * areas.reshaped(row_size, areas.size() / row_size).colwise().sum().transpose();
}

// Hangs the mesh of `scene`, whose rows are blocks of `row_size` nodes with the highest first, from its first row with
// large implicit steps (which damp) until it rests; returns the mean depth of the last row below the first.
double SimulatedHungLength(Scene scene, int row_size, int num_steps) {
  scene.time_step = 0.1;
  for (int node = 0; node < row_size; ++node) scene.handles.nodes.push_back(node);
  scene.material.drag = 0.05;
  const Rollout rollout = SimulateNominal(scene, num_steps);
  EXPECT_LE(rollout.records.back().velocities.cwiseAbs().maxCoeff(), 1e-9) << "not at rest";
  const Eigen::VectorXd& positions = rollout.positions(num_steps);
  const auto heights = positions.reshaped(3, positions.size() / 3).row(2);
  return heights.head(row_size).mean() - heights.tail(row_size).mean();
}

// A sleeve hung by its upper rim: every node of a ring is like the others, so the uniaxial state is exact.
TEST(HangingTest, SleeveStretchesByItsOwnWeightExactly) {
  constexpr int kRings = 12, kRingSize = 8;
  constexpr double kRowHeight = 0.025, kRadius = 0.05;  // m
  Scene scene = ClothScene(SquareGrid(2, 0.1), 0.1);
  scene.material.stretch_stiffness = 10.0;
  PutSleeve(kRings, kRingSize, kRadius, kRowHeight, &scene);
  const Mesh& mesh = scene.mesh;

  const double girth = kRingSize * 2.0 * kRadius * std::sin(kPi / kRingSize);
  const double expected = HungLength(RowMasses(mesh, scene.material.density, kRingSize), kRowHeight, girth,
                                     scene.material.stretch_stiffness);
  EXPECT_GT(expected, 1.02 * kRowHeight * (kRings - 1));
  EXPECT_NEAR(SimulatedHungLength(scene, kRingSize, 100), expected, 1e-9 * expected);
}

// The same with an orthotropic membrane, whose tension at the stretch 1 + e is k e (1 + e)(1 + e/2).
TEST(HangingTest, OrthotropicSleeveStretchesByItsOwnWeightExactly) {
  constexpr int kRings = 12, kRingSize = 8;
  constexpr double kRowHeight = 0.025, kRadius = 0.05, kWarp = 30.0, kWeft = 10.0;  // m, N/m
  Scene scene = ClothScene(SquareGrid(2, 0.1), 0.1);
  PutSleeve(kRings, kRingSize, kRadius, kRowHeight, &scene);
  scene.membrane = MembraneLaw::kOrthotropic;
  scene.material.warp_stiffness = kWarp;
  scene.material.weft_stiffness = kWeft;
  scene.material.shear_stiffness = 4.0;
  const double girth = kRingSize * 2.0 * kRadius * std::sin(kPi / kRingSize);
  const Eigen::VectorXd masses = RowMasses(scene.mesh, scene.material.density, kRingSize);
  for (const bool warp_hangs : {true, false}) {
    scene.warp = {Eigen::Vector3d::UnitZ(), warp_hangs ? 0.0 : 90.0};
    const double stiffness = warp_hangs ? kWarp : kWeft;
    double expected = 0.0, weight = 0.0;
    for (Eigen::Index row = kRings - 1; row > 0; --row) {
      weight += kGravity * masses[row];
      double e = 0.0;
      for (int i = 0; i < 50; ++i) e = weight / (girth * stiffness * (1.0 + e) * (1.0 + e / 2.0));
      expected += kRowHeight * (1.0 + e);
    }
    EXPECT_GT(expected, 1.005 * kRowHeight * (kRings - 1));
    EXPECT_NEAR(SimulatedHungLength(scene, kRingSize, 100), expected, 1e-9 * expected) << warp_hangs;
  }
}

// And with yarns, whose tension is k (exp(b e) - 1)/b: the uppermost ring is some fifteen times as stiff as at rest.
TEST(HangingTest, SleeveOfYarnsStretchesByItsOwnWeightExactly) {
  constexpr int kRings = 12, kRingSize = 8;
  constexpr double kRowHeight = 0.025, kRadius = 0.05, kStiffness = 0.5, kStiffening = 20.0;  // m, N/m, 1
  Scene scene = ClothScene(SquareGrid(2, 0.1), 0.1);
  PutSleeve(kRings, kRingSize, kRadius, kRowHeight, &scene);
  scene.membrane = MembraneLaw::kYarn;
  scene.warp.direction = Eigen::Vector3d::UnitZ();
  scene.material.warp_stiffness = kStiffness;
  scene.material.warp_stiffening = kStiffening;
  scene.material.weft_stiffness = 10.0;
  scene.material.shear_stiffness = 4.0;
  const double girth = kRingSize * 2.0 * kRadius * std::sin(kPi / kRingSize);
  const Eigen::VectorXd masses = RowMasses(scene.mesh, scene.material.density, kRingSize);
  double expected = 0.0, weight = 0.0;
  for (Eigen::Index row = kRings - 1; row > 0; --row) {
    weight += kGravity * masses[row];
    expected += kRowHeight * (1.0 + std::log1p(kStiffening * weight / (girth * kStiffness)) / kStiffening);
  }
  EXPECT_GT(expected, 1.1 * kRowHeight * (kRings - 1));
  EXPECT_NEAR(SimulatedHungLength(scene, kRingSize, 100), expected, 1e-9 * expected);
}

// A flat strip: the two corners of its last row differ in mass, which tilts the rows by a little; the mean length feels
// that in second order.
TEST(HangingTest, StripStretchesByItsOwnWeight) {
  constexpr int kRows = 31;
  constexpr double kWidth = 0.02, kRowHeight = 0.01;  // m
  GridOptions grid;
  grid.nodes = {2, kRows};
  grid.size = {kWidth, kRowHeight * (kRows - 1)};
  grid.axes = {Eigen::Vector3d::UnitX(), -Eigen::Vector3d::UnitZ()};
  Scene scene = ClothScene(grid, 0.1);
  scene.material.stretch_stiffness = 20.0;
  const double expected = HungLength(RowMasses(scene.mesh, scene.material.density, 2), kRowHeight, kWidth,
                                     scene.material.stretch_stiffness);
  EXPECT_GT(expected, 1.01 * grid.size[1]);
  EXPECT_NEAR(SimulatedHungLength(scene, 2, 600), expected, 1e-5 * expected);
}

// v_n = v_inf (1 - (1 + h c_d/rho)^-n), v_inf = rho g/c_d.
TEST(DragTest, FallsToTheTerminalVelocity) {
  Scene scene = ClothScene(SquareGrid(4, 0.2), 0.05);
  scene.material.drag = 1.2;
  constexpr int kNumSteps = 80;
  const Rollout rollout = SimulateNominal(scene, kNumSteps);
  const double terminal = scene.material.density * kGravity / scene.material.drag;
  for (const int step : {1, 5, kNumSteps}) {
    const double decay = std::pow(1.0 + scene.time_step * scene.material.drag / scene.material.density, -step);
    EXPECT_LE(VelocityError(rollout, step, {0.0, 0.0, -terminal * (1.0 - decay)}), 1e-10) << "step " << step;
  }
  EXPECT_NEAR(rollout.records.back().velocities[2], -terminal, 1e-10);
}

// Without gravity the velocity relaxes to the wind: v_n = w + (v_0 - w) (1 + h c_d/rho)^-n.
TEST(DragTest, RelaxesToASteadyWind) {
  Scene scene = ClothScene(SquareGrid(4, 0.2), 0.02);
  scene.gravity.setZero();
  scene.material.drag = 0.3;
  scene.wind.mean = Eigen::Vector3d(1.0, -2.0, 0.5);
  const Eigen::Vector3d start(0.5, 0.2, -1.0);  // m/s
  SetUniformVelocity(start, &scene);
  const Rollout rollout = SimulateNominal(scene, 50);
  for (const int step : {1, 7, 50}) {
    const double decay = std::pow(1.0 + scene.time_step * scene.material.drag / scene.material.density, -step);
    const Eigen::Vector3d expected = scene.wind.mean + decay * (start - scene.wind.mean);
    EXPECT_LE(VelocityError(rollout, step, expected), 1e-10) << "step " << step;
  }
}

// Where a cloth that hangs by one edge and swings under a sideways push is after `duration`.
Eigen::VectorXd SwingingCloth(double time_step, double duration) {
  GridOptions grid = SquareGrid(6, 0.3);
  grid.axes = {Eigen::Vector3d::UnitX(), -Eigen::Vector3d::UnitZ()};
  Scene scene = ClothScene(grid, time_step);
  scene.material = {0.15, 5.0, 1e-3, 0.05};
  for (int node = 0; node < 6; ++node) scene.handles.nodes.push_back(node);
  for (int node = 6; node < scene.mesh.num_nodes(); ++node) {
    scene.initial_velocities[3 * node + 1] = -3.0 * scene.mesh.rest_positions(2, node);
  }
  const int num_steps = static_cast<int>(std::lround(duration / time_step));
  return SimulateNominal(scene, num_steps).positions(num_steps);
}

// The distance between the solutions of h and h/2 is the error of h up to a factor: it halves when h halves.
TEST(ConvergenceTest, SwingingClothIsFirstOrderInTheTimeStep) {
  constexpr double kDuration = 0.2;  // s
  std::vector<Eigen::VectorXd> solutions;
  for (const double time_step : {1e-3, 5e-4, 2.5e-4, 1.25e-4}) solutions.push_back(SwingingCloth(time_step, kDuration));
  double coarse = (solutions[0] - solutions[1]).norm();
  for (size_t level = 1; level + 1 < solutions.size(); ++level) {
    const double fine = (solutions[level] - solutions[level + 1]).norm();
    EXPECT_NEAR(coarse / fine, 2.0, 0.2) << "level " << level;
    coarse = fine;
  }
}

}  // namespace
}  // namespace clothid::closed_forms_test
