// A recording on a mesh of twice the density: what was measured stays what it is.
#include "datasets/motion/refined_motion.h"

#include <gtest/gtest.h>

#include <cmath>

#include "datasets/motion/motion_validation.h"

namespace clothid::refined_motion_test {
namespace {

RecordedMotion SmallMotion() {
  RecordedMotion motion;
  motion.name = "a.bin";
  GridOptions grid;
  grid.nodes = {3, 3};
  motion.scene.mesh = MakeGrid(grid);
  motion.scene.initial_positions = motion.scene.mesh.rest_positions.reshaped();
  motion.scene.initial_velocities.setZero(27);
  motion.scene.handles.nodes = {0, 1};
  motion.times = Eigen::VectorXd::LinSpaced(4, 0.0, 0.3);
  return motion;
}

void AddPoint(const Eigen::Vector3d& weights, int face, RecordedMotion* motion) {
  ObservedPoint point;
  point.num_nodes = 3;
  for (int k = 0; k < 3; ++k) {
    point.nodes[k] = motion->scene.mesh.faces(k, face);
    point.weights[k] = weights[k];
  }
  motion->points.push_back(point);
}

Eigen::Vector3d RestPosition(const ObservedPoint& point, const Mesh& mesh) {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  for (int k = 0; k < point.num_nodes; ++k) position += point.weights[k] * mesh.rest_positions.col(point.nodes[k]);
  return position;
}

TEST(RefineMotionTest, KeepsMaterialPoints) {
  RecordedMotion motion = SmallMotion();
  motion.points.push_back({});
  motion.points.back().nodes[0] = 8;
  for (int face = 0; face < motion.scene.mesh.num_faces(); ++face) {
    AddPoint({0.7, 0.2, 0.1}, face, &motion);  // of the corners' triangles
    AddPoint({0.05, 0.9, 0.05}, face, &motion);
    AddPoint({0.0, 0.3, 0.7}, face, &motion);  // on an edge
    AddPoint({0.4, 0.3, 0.3}, face, &motion);  // of the one in the middle
    AddPoint({0.5, 0.5, 0.0}, face, &motion);  // on a new node
  }
  motion.positions = Eigen::MatrixXd::Random(3 * motion.num_points(), 4);
  const RecordedMotion refined = RefineMotion(motion);
  EXPECT_NO_THROW(ValidateMotion(refined));
  EXPECT_EQ(refined.points[0].nodes[0], 8);
  EXPECT_EQ(refined.positions, motion.positions);
  for (int p = 0; p < motion.num_points(); ++p) {
    const Eigen::Vector3d before = RestPosition(motion.points[p], motion.scene.mesh);
    EXPECT_LT((RestPosition(refined.points[p], refined.scene.mesh) - before).norm(), 1e-15) << p;
    for (int k = 0; k < refined.points[p].num_nodes; ++k) EXPECT_GE(refined.points[p].weights[k], -1e-15) << p;
  }
}

// A point is looked for on the triangle that it lies on: nothing is extrapolated, and the corners of it are joined.
TEST(RefineMotionTest, PointsLieOnTriangles) {
  RecordedMotion motion = SmallMotion();
  AddPoint({0.4, 0.3, 0.3}, 2, &motion);
  AddPoint({0.1, 0.2, 0.7}, 2, &motion);
  motion.positions = Eigen::MatrixXd::Zero(6, 4);
  const RecordedMotion refined = RefineMotion(motion);
  for (const ObservedPoint& point : refined.points) {
    bool is_face = false;
    for (int face = 0; face < refined.scene.mesh.num_faces(); ++face) {
      int num_shared = 0;
      for (const int node : point.nodes) {
        num_shared += (refined.scene.mesh.faces.col(face).array() == node).any() ? 1 : 0;
      }
      is_face = is_face || num_shared == 3;
    }
    EXPECT_TRUE(is_face);
  }
}

TEST(RefineMotionTest, NewHandlesAreNotMeasured) {
  RecordedMotion motion = SmallMotion();
  motion.handle_measurements.times = Eigen::VectorXd::LinSpaced(5, 0.0, 1.0);
  motion.handle_measurements.deviations = Eigen::MatrixXd::Random(6, 5);
  motion.handle_measurements.sigma = Eigen::Vector2d(1e-3, 3e-3);
  const RecordedMotion refined = RefineMotion(motion);
  ASSERT_EQ(refined.scene.handles.nodes.size(), 3u);
  ASSERT_EQ(refined.handle_measurements.deviations.rows(), 9);
  EXPECT_EQ(refined.handle_measurements.deviations.topRows(6), motion.handle_measurements.deviations);
  EXPECT_TRUE(refined.handle_measurements.deviations.bottomRows(3).array().isNaN().all());
  EXPECT_EQ(refined.handle_measurements.sigma, Eigen::Vector3d(1e-3, 3e-3, 2e-3));
}

}  // namespace
}  // namespace clothid::refined_motion_test
