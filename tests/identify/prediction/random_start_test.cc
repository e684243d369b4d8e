// Draws of a start are as far off as they are told, and stay out of obstacles; grippers move as one.
#include "identify/prediction/random_start.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/costs/synthetic_motion.h"

namespace clothid::random_start_test {
namespace {

Scene HeldSheet() {
  Scene scene = ClothScene(9, 20);
  scene.handles.nodes = {0, 1, 8};
  return scene;
}

// The root mean square over draws of what `change` gives for draw d.
template <typename Change>
double RootMeanSquare(int num_draws, const Change& change) {
  double sum = 0.0, num = 0.0;
  for (int draw = 0; draw < num_draws; ++draw) {
    const Eigen::VectorXd values = change(draw);
    sum += values.squaredNorm();
    num += static_cast<double>((values.array() != 0.0).count());
  }
  return std::sqrt(sum / num);
}

TEST(RandomStartTest, StartsAreAsFarOffAsTheyAreTold) {
  const Scene scene = HeldSheet();
  const LearntStart told = {0.002, 0.05, 0.0, 0.0};
  const RandomStart start(scene, told, true, true);
  EXPECT_TRUE(start.moves_start());
  EXPECT_FALSE(start.moves_handles()) << "nothing is told of them";
  const auto moved = [&](int draw) {
    Scene drawn = scene;
    start.MoveStart(1, draw, &drawn);
    EXPECT_EQ(drawn.initial_positions.head(6), scene.initial_positions.head(6)) << "handles";
    return std::pair<Eigen::VectorXd, Eigen::VectorXd>(drawn.initial_positions - scene.initial_positions,
                                                       drawn.initial_velocities - scene.initial_velocities);
  };
  EXPECT_NEAR(RootMeanSquare(400, [&](int draw) { return moved(draw).first; }), 0.002, 2e-4);
  EXPECT_NEAR(RootMeanSquare(400, [&](int draw) { return moved(draw).second; }), 0.05, 5e-3);
  EXPECT_EQ(moved(3).first, moved(3).first);
  EXPECT_NE(moved(3).first, moved(4).first);
}

// In the plane a cloth does not stretch by more than is believed: 3 % of its edges, times what a mode is sure to have.
TEST(RandomStartTest, StartsAreShapesOfACloth) {
  const Scene scene = HeldSheet();
  const RandomStart start(scene, {0.002, 0.0, 0.0, 0.0}, true, false);
  const double edge = (scene.initial_positions.segment<3>(3) - scene.initial_positions.segment<3>(0)).norm();
  const auto strain = [&](int draw) {
    Scene drawn = scene;
    start.MoveStart(1, draw, &drawn);
    Eigen::VectorXd strains(7);
    for (int i = 0; i < 7; ++i) {
      const Eigen::Vector3d along =
          drawn.initial_positions.segment<3>(3 * (37 + i)) - drawn.initial_positions.segment<3>(3 * (36 + i));
      strains[i] = along.norm() / edge - 1.0;
    }
    return strains;
  };
  EXPECT_LT(RootMeanSquare(200, strain), 0.03);
}

TEST(RandomStartTest, NobodyIsPutIntoAnObstacle) {
  Scene scene = HeldSheet();
  SceneObstacle floor;
  floor.name = "floor";
  floor.shape = std::make_shared<Plane>(scene.initial_positions.segment<3>(0), Eigen::Vector3d::UnitZ());
  scene.obstacles = {floor};
  const RandomStart start(scene, {0.005, 0.0, 0.0, 0.0}, true, false);
  for (int draw = 0; draw < 10; ++draw) {
    Scene drawn = scene;
    start.MoveStart(1, draw, &drawn);
    for (int node = 0; node < drawn.mesh.num_nodes(); ++node) {
      EXPECT_GE(drawn.initial_positions[3 * node + 2], scene.initial_positions[2] - 1e-12);
    }
  }
}

TEST(RandomStartTest, HandlesOfOneGripperMoveTogether) {
  const Scene scene = HeldSheet();
  const RandomStart start(scene, {0.0, 0.0, 0.003, 0.05}, true, true);
  EXPECT_FALSE(start.moves_start());
  ASSERT_TRUE(start.moves_handles());
  const auto late = [&](int draw) {
    const HandlePath path = start.HandleOffsets(1, draw);
    EXPECT_EQ(path.num_handles(), 3);
    EXPECT_EQ(path.At(scene.start_time).norm(), 0.0);
    const Eigen::VectorXd offsets = path.At(scene.start_time + 0.1);
    EXPECT_EQ(offsets.segment<3>(0), offsets.segment<3>(3)) << "nodes 0 and 1 are joined";
    EXPECT_NE(offsets.segment<3>(0), offsets.segment<3>(6));
    return offsets;
  };
  EXPECT_NEAR(RootMeanSquare(600, late), 0.003, 3e-4);
  const RandomStart constant(scene, {0.0, 0.0, 0.003, 0.0}, true, true);
  const HandlePath path = constant.HandleOffsets(1, 0);
  EXPECT_EQ(path.At(scene.start_time + 0.1), path.At(scene.start_time + 5.0));
}

}  // namespace
}  // namespace clothid::random_start_test
