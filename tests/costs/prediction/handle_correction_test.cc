// Where the handles of a recording are off: their groups, what a shift and a turn of them do, and derivatives, adjoint
// = sensitivity = central differences; beside the size of the cloth.
#include "costs/prediction/handle_correction.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <string>
#include <vector>

#include "costs/rollout_cost.h"
#include "sim/base/error.h"
#include "tests/costs/synthetic_motion.h"
#include "tests/expect_error.h"

namespace clothid::handle_correction_test {
namespace {

// Two corners of a cloth that a tool moves and turns.
Scene ToolScene() {
  Scene scene = SwingScene();
  scene.material.damping = 0.01;
  Eigen::MatrixXd places(6, 4);
  for (int k = 0; k < 4; ++k) {
    const Eigen::AngleAxisd turn(0.2 * k, Eigen::Vector3d(0.1, 0.3, 1.0).normalized());
    for (int i = 0; i < 2; ++i) {
      places.col(k).segment<3>(3 * i) =
          turn * scene.initial_positions.segment<3>(12 * i) + Eigen::Vector3d(0.01 * k, 0.02 * k * k, 0.0);
    }
  }
  scene.handles.path = HandlePath(Eigen::Vector4d(0.0, 0.05, 0.12, 0.2), places);
  return scene;
}

std::vector<ParameterBlock> BlocksOf(const RecordedMotion& motion, const std::vector<std::string>& names) {
  std::vector<ParameterBlock> blocks;
  for (const std::string& name : names) blocks.push_back(MakeParameterBlock(name, motion, {}));
  return blocks;
}

TEST(HandleGroupsTest, AreThoseOfForcesOrOfNeighbours) {
  RecordedMotion motion = MakeMotion(SwingScene(), {});
  EXPECT_EQ(HandleGroups(motion), (std::vector<std::vector<int>>{{0}, {4}}));
  motion.scene.handles.nodes = {4, 24, 3, 0, 19};
  EXPECT_EQ(HandleGroups(motion), (std::vector<std::vector<int>>{{0}, {4, 3}, {24, 19}}));
  motion.forces.groups = {{0, 24}, {4}};
  EXPECT_EQ(HandleGroups(motion), motion.forces.groups);
}

TEST(HandleGroupsTest, NamesThoseThatThereAre) {
  RecordedMotion motion = MakeMotion(SwingScene(), {});
  EXPECT_NO_THROW(MakeParameterBlock("handle_shift2.x", motion, {}));
  ExpectError([&] { MakeParameterBlock("handle_shift3.x", motion, {}); }, ErrorKind::kUsage,
              {"handle_shift3.x", "synthetic", "2 groups of handles"});
  motion.scene.handles.nodes = {0};
  ExpectError([&] { MakeParameterBlock("handle_turn.x", motion, {}); }, ErrorKind::kUsage, {"two handles"});
}

TEST(HandleCorrectionTest, HasPriorsUnlessOthersAreGiven) {
  const RecordedMotion motion = MakeMotion(SwingScene(), {});
  EXPECT_EQ(MakeParameterBlock("handle_shift1.x", motion, {}).prior.spread, 0.01);
  EXPECT_EQ(MakeParameterBlock("handle_turn.y", motion, {}).prior.spread, 0.05);
  EXPECT_EQ(MakeParameterBlock("size.x", motion, {}).prior.spread, 1.03);
  EXPECT_EQ(MakeParameterBlock("size.x", motion, {}).prior.center, 1.0);
  EXPECT_FALSE(MakeParameterBlock("shift.x", motion, {}).prior.is_given());
  ParameterOverrides overrides;
  overrides.priors["handle_shift"] = {0.002, 0.3};
  EXPECT_EQ(MakeParameterBlock("handle_shift.x", motion, overrides).prior.spread, 0.3);
}

TEST(HandleCorrectionTest, TurnsAboutTheMiddleOfTheHandlesAtEveryTime) {
  const Scene scene = ToolScene();
  const HandleCorrection correction(scene, {{0}, {4}}, {}, true);
  Alignment alignment;
  alignment.handle_turn = {0.02, -0.1, 0.05};
  alignment.Set({ParameterKind::kHandleShift, 1, 1}, 0.003);
  const HandlePath offsets = correction.OffsetsAt(alignment, nullptr);
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(alignment.handle_turn.norm(), alignment.handle_turn.normalized()).toRotationMatrix();
  for (const double time : {0.0, 0.03, 0.05, 0.11, 0.2}) {
    const Eigen::VectorXd path = scene.handles.path.At(time), moved = path + offsets.At(time);
    const Eigen::Vector3d middle = 0.5 * (path.head<3>() + path.tail<3>());
    EXPECT_LT((moved.head<3>() - middle - turn * (path.head<3>() - middle)).norm(), 1e-14);
    EXPECT_LT((moved.tail<3>() - middle - turn * (path.tail<3>() - middle) - Eigen::Vector3d(0.0, 0.003, 0.0)).norm(),
              1e-14);
  }
}

// The corrections and the sizes, among other parameters; also where the start is unknown, whose offsets have knots of
// their own.
TEST(HandleCorrectionTest, AdjointIsSensitivityIsCentralDifferences) {
  MotionOptions options;
  options.true_values = {{"k_stretch", 90.0}};
  options.noise = 1e-3;
  RecordedMotion motion = MakeMotion(ToolScene(), options);
  const std::vector<ParameterBlock> blocks =
      BlocksOf(motion, {"handle_turn.z", "size.y", "k_stretch", "handle_shift1.y", "v0.x", "handle_turn.x", "shift.y",
                        "handle_shift.z", "size.x", "handle_turn.y", "handle_shift2.x"});
  Eigen::VectorXd point(11);
  point << 0.3, std::log(1.02), std::log(80.0), -0.05, 0.1, -0.2, 0.02, 0.1, std::log(0.99), 0.25, 0.15;
  for (const bool is_unknown : {false, true}) {
    if (is_unknown) {
      motion.start_source = StartSource::kRest;
      motion.handle_measurements.times = Eigen::VectorXd::LinSpaced(12, 0.0, 0.2);
      motion.handle_measurements.deviations = Eigen::MatrixXd::Zero(6, 12);
      motion.handle_measurements.sigma = Eigen::VectorXd::Constant(2, 1e-3);
    }
    RolloutCostOptions method;
    const RolloutCost adjoint(motion, blocks, method);
    method.jacobian = JacobianMethod::kSensitivity;
    const RolloutCost sensitivity(motion, blocks, method);
    Eigen::VectorXd all = Eigen::VectorXd::Zero(adjoint.model().num_coordinates());
    all.head(point.size()) = point;
    double value = 0.0, same_value = 0.0, above_value = 0.0, below_value = 0.0;
    Eigen::VectorXd a, s;
    ASSERT_TRUE(adjoint.EvaluateGradient(all, &value, &a)) << adjoint.last_failure();
    ASSERT_TRUE(sensitivity.EvaluateGradient(all, &same_value, &s)) << sensitivity.last_failure();
    for (Eigen::Index i = 0; i < point.size(); ++i) {
      EXPECT_NEAR(a[i], s[i], 1e-10 * s.head(point.size()).norm()) << blocks[i].name << " " << is_unknown;
      Eigen::VectorXd above = all, below = all;
      above[i] += 1e-5;
      below[i] -= 1e-5;
      ASSERT_TRUE(adjoint.EvaluateGradient(above, &above_value, nullptr));
      ASSERT_TRUE(adjoint.EvaluateGradient(below, &below_value, nullptr));
      EXPECT_NEAR(a[i], (above_value - below_value) / 2e-5, 2e-6 * std::abs(a[i]) + 1e-7 * s.head(point.size()).norm())
          << blocks[i].name << " " << is_unknown;
    }
  }
}

}  // namespace
}  // namespace clothid::handle_correction_test
