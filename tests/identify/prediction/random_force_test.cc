// Draws of a force are as large, as long and as smooth as they are told, and are told so again; and a cloth at rest has
// none.
#include "identify/prediction/random_force.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "sim/mesh/mesh.h"
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

// f [3N x T] N/m^2 of one draw, on a cloth that has moved.
Eigen::MatrixXd DrawForces(const std::vector<LastingForce>& parts, const Simulator& simulator, int num_steps,
                           int draw) {
  const ClothModel& cloth = simulator.model();
  const Material& material = simulator.scene().material;
  const auto drawn = ForceSource(parts, cloth).Draw(1.0, cloth, material, num_steps, 1, draw);
  const Correction& random = *drawn;
  Eigen::MatrixXd forces = Eigen::MatrixXd::Zero(3 * cloth.num_nodes(), num_steps + 1);
  Eigen::VectorXd positions, velocities;
  const Eigen::VectorXd start = simulator.scene().initial_positions;
  const Eigen::VectorXd moved = start.array() + 1.0;
  for (int step = 1; step <= num_steps; ++step) {
    EXPECT_TRUE(random.Corrects(step));
    random.Evaluate(step, {start, moved}, &positions, &velocities);
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

// A draw of a force at its second step, and what a step that starts somewhere and ends at `end` gets of it.
class MovedShareTest : public testing::Test {
 protected:
  explicit MovedShareTest(const Scene& scene = Sheet()) : simulator_(scene) {}

  const Eigen::VectorXd& start() const { return simulator_.scene().initial_positions; }
  // Moved by `distance` m in the root mean square over nodes, in another direction each.
  Eigen::VectorXd Moved(double distance) const {
    NormalStream stream(7, 0, DrawStream::kNoise);
    const Eigen::VectorXd change = stream.Draw(start().size(), 1);
    return start() + distance * std::sqrt(static_cast<double>(start().size()) / 3.0) / change.norm() * change;
  }
  Eigen::VectorXd ChangeAt(const Eigen::VectorXd& end) const {
    Eigen::VectorXd positions, velocities;
    force_->Evaluate(2, {start(), end}, &positions, &velocities);
    return velocities;
  }

  Simulator simulator_;
  std::shared_ptr<const Correction> force_ = ForceSource({{0.2, 0.05, 0.1}}, simulator_.model())
                                                 .Draw(1.0, simulator_.model(), simulator_.scene().material, 5, 1, 0);
  const double reach_ = RandomForce::kMovedShare * ClothSize(simulator_.scene().mesh);
};

TEST_F(MovedShareTest, AForceGrowsWithTheWayFromRestUpToItsReach) {
  const Eigen::VectorXd full = ChangeAt(Moved(2.0 * reach_));
  EXPECT_GT(full.norm(), 0.0);
  EXPECT_EQ(ChangeAt(start()).norm(), 0.0);
  EXPECT_NEAR((ChangeAt(Moved(0.3 * reach_)) - 0.3 * full).norm(), 0.0, 1e-12 * full.norm());
  EXPECT_EQ(ChangeAt(Moved(5.0 * reach_)), full);
}

TEST_F(MovedShareTest, DerivativesAreThoseOfDifferencesAndOfEachOther) {
  for (const double distance : {0.4 * reach_, 3.0 * reach_}) {
    const Eigen::VectorXd end = Moved(distance);
    NormalStream stream(8, 0, DrawStream::kNoise);
    const Eigen::MatrixXd changes = stream.Draw(end.size(), 2), adjoints = stream.Draw(end.size(), 2);
    Eigen::MatrixXd positions, velocities, by_start, by_end;
    force_->Times(2, {start(), end}, changes, changes, &positions, &velocities);
    force_->TimesTransposed(2, {start(), end}, adjoints, adjoints, &by_start, &by_end);
    EXPECT_EQ(positions.norm(), 0.0);
    EXPECT_EQ(by_start.norm(), 0.0);
    constexpr double kStep = 1e-6;
    for (Eigen::Index i = 0; i < 2; ++i) {
      const Eigen::VectorXd differences =
          (ChangeAt(end + kStep * changes.col(i)) - ChangeAt(end - kStep * changes.col(i))) / (2.0 * kStep);
      EXPECT_NEAR((differences - velocities.col(i)).norm(), 0.0, 1e-6 * (differences.norm() + 1e-12));
    }
    const Eigen::MatrixXd forward = adjoints.transpose() * velocities, backward = by_end.transpose() * changes;
    EXPECT_NEAR((forward - backward).norm(), 0.0, 1e-10 * forward.norm() + 1e-18);
    EXPECT_EQ(forward.norm() > 0.0, distance < reach_);
  }
}

Scene MovingSheet() {
  Scene scene = Sheet();
  scene.initial_velocities.setConstant(0.1);
  return scene;
}

class MovingStartTest : public MovedShareTest {
 protected:
  MovingStartTest() : MovedShareTest(MovingSheet()) {}
};

TEST_F(MovingStartTest, AClothThatStartsInMotionHasItAllFromTheStart) {
  EXPECT_GT(ChangeAt(start()).norm(), 0.0);
  EXPECT_EQ(ChangeAt(start()), ChangeAt(Moved(2.0 * reach_)));
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
