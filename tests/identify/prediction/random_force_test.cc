// Draws of a force are as large, as long and as smooth as they are told, and are told so again.
#include "identify/prediction/random_force.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "sim/rollout/simulator.h"
#include "tests/costs/synthetic_motion.h"

namespace clothid::random_force_test {
namespace {

// 21 x 21 nodes on .3 m.
Scene Sheet() {
  Scene scene = ClothScene(21, 10);
  scene.handles.nodes = {0};
  return scene;
}

// f [3N x T] N/m^2 of one draw.
Eigen::MatrixXd DrawForces(const std::vector<LastingForce>& parts, const Simulator& simulator, int num_steps,
                           int draw) {
  const ClothModel& cloth = simulator.model();
  const Material& material = simulator.scene().material;
  const auto drawn = ForceSource(parts, cloth).Draw(1.0, cloth, material, num_steps, 1, draw);
  const Correction& random = *drawn;
  Eigen::MatrixXd forces = Eigen::MatrixXd::Zero(3 * cloth.num_nodes(), num_steps + 1);
  Eigen::VectorXd positions, velocities;
  const Eigen::VectorXd none;
  for (int step = 1; step <= num_steps; ++step) {
    EXPECT_TRUE(random.Corrects(step));
    random.Evaluate(step, {none, none}, &positions, &velocities);
    EXPECT_EQ(positions.norm(), 0.0);
    forces.col(step) = material.density / simulator.scene().time_step * velocities;
  }
  EXPECT_FALSE(random.Corrects(num_steps + 1));
  return forces;
}

TEST(RandomForceTest, ADrawIsAsItIsTold) {
  const Simulator simulator(Sheet());
  const LastingForce force = {0.2, 0.05, 0.04};
  const Eigen::MatrixXd forces = DrawForces({force}, simulator, 400, 0);
  EXPECT_EQ(forces.topRows(3).norm(), 0.0) << "of a handle";
  const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(401, 0.0, 4.0);
  const LastingForce told = DescribeLastingForce(forces, times, simulator.model());
  EXPECT_NEAR(told.size, force.size, 0.1 * force.size);
  EXPECT_NEAR(told.time, force.time, 0.15 * force.time);
  EXPECT_NEAR(told.length, force.length, 0.15 * force.length);
}

TEST(RandomForceTest, NoiseBesideItIsNotToldAsLasting) {
  const Simulator simulator(Sheet());
  const LastingForce force = {0.2, 0.05, 0.04};
  Eigen::MatrixXd forces = DrawForces({force}, simulator, 400, 0);
  std::mt19937_64 generator(1);
  std::normal_distribution<double> normal(0.0, 0.2);
  for (double& value : forces.rightCols(400).reshaped()) value += normal(generator);
  const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(401, 0.0, 4.0);
  const LastingForce told = DescribeLastingForce(forces, times, simulator.model());
  EXPECT_NEAR(told.size, force.size, 0.1 * force.size);
  EXPECT_NEAR(told.time, force.time, 0.2 * force.time);
}

TEST(RandomForceTest, DrawsDependOnTheirNumberAlone) {
  const Simulator simulator(Sheet());
  const LastingForce force = {0.2, 0.05, 0.1};
  const Eigen::MatrixXd first = DrawForces({force}, simulator, 5, 3);
  EXPECT_EQ(DrawForces({force}, simulator, 5, 3), first);
  EXPECT_NE(DrawForces({force}, simulator, 5, 4), first);
}

// What is lacking fast and what is lacking slowly go together: c_k = sum s_j^2 exp(-k dt/t_j).
TEST(RandomForceTest, ADrawIsTheSumOfItsParts) {
  const Simulator simulator(Sheet());
  const std::vector<LastingForce> parts = {{0.2, 0.03, 0.04}, {0.1, 0.5, 0.04}};
  constexpr int kNumSteps = 1500, kDraws = 2;
  Eigen::Array3d lags(1, 10, 40), told = Eigen::Array3d::Zero(), expected = Eigen::Array3d::Zero();
  for (int draw = 0; draw < kDraws; ++draw) {
    const Eigen::MatrixXd forces = DrawForces(parts, simulator, kNumSteps, draw).bottomRows(3 * 440);
    for (Eigen::Index i = 0; i < 3; ++i) {
      const auto lag = static_cast<Eigen::Index>(lags[i]), num = kNumSteps - lag;
      told[i] += forces.middleCols(1, num).cwiseProduct(forces.middleCols(1 + lag, num)).mean() / kDraws;
    }
  }
  for (const LastingForce& part : parts) expected += part.size * part.size * (-0.01 * lags / part.time).exp();
  for (Eigen::Index i = 0; i < 3; ++i) EXPECT_NEAR(told[i], expected[i], 0.2 * expected[i]) << lags[i];
}

TEST(RandomForceTest, NothingLastsOfWhatHasAnotherSignFromFrameToFrame) {
  const Simulator simulator(Sheet());
  Eigen::MatrixXd forces(3 * simulator.model().num_nodes(), 10);
  for (int i = 0; i < 10; ++i) forces.col(i).setConstant(i % 2 == 0 ? 1.0 : -1.0);
  const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(10, 0.0, 0.09);
  EXPECT_EQ(DescribeLastingForce(forces, times, simulator.model()).size, 0.0);
  EXPECT_EQ(DescribeLastingForce(forces.leftCols(2), times.head(2), simulator.model()).size, 0.0);
}

}  // namespace
}  // namespace clothid::random_force_test
