// What a recording of every node tells of a cloth that meets itself.
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include "datasets/checking/motion_check.h"
#include "datasets/motion/motion_file.h"
#include "tests/sim/self_contact_scenes.h"

namespace clothid::self_contact_check_test {
namespace {

constexpr int kFrames = 30;
constexpr char kSceneText[] =
    R"({"clothid_scene": 2, "time_step": 0.005, "self_contact": {"mu": 0.3, "thickness": 0.003}})";

// A layer of 28 nodes that moves along x, 3 mm above a larger one.
MotionTensors Layers() {
  const Scene scene = LayersOnASlope(2, 0.0, 0.3, Integrator::kEuler, 0.005);
  MotionTensors tensors;
  tensors.mesh = scene.mesh;
  tensors.single_precision = false;
  tensors.times = Eigen::VectorXd::LinSpaced(kFrames, 0.0, 0.29);
  tensors.positions = scene.initial_positions.replicate(1, kFrames);
  for (int frame = 0; frame < kFrames; ++frame) {
    tensors.positions.col(frame).tail(3 * 28) += Eigen::Vector3d(1e-3 * frame, 0.0, 0.0).replicate(28, 1);
  }
  tensors.scene_text = kSceneText;
  return tensors;
}

void LowerUpper(int frame, double by, MotionTensors* tensors) {
  tensors->positions.col(frame).tail(3 * 28) -= Eigen::Vector3d(0.0, 0.0, by).replicate(28, 1);
}

std::optional<Finding> SelfContactOf(const MotionTensors& tensors) {
  ReadMotionOptions options;
  options.smooth_handles = false;
  for (const Finding& finding : CheckMotion(InterpretMotion(tensors, "layers", options))) {
    if (finding.what == "self-contact") return finding;
  }
  return std::nullopt;
}

TEST(SelfContactCheckTest, TellsHowNearPartsCome) {
  MotionTensors tensors = Layers();
  std::optional<Finding> finding = SelfContactOf(tensors);
  ASSERT_TRUE(finding);
  EXPECT_EQ(finding->severity, Severity::kOk);
  EXPECT_NE(finding->value.find("no triangles cut each other"), std::string::npos) << finding->value;
  LowerUpper(5, 0.001, &tensors);
  finding = SelfContactOf(tensors);
  EXPECT_EQ(finding->severity, Severity::kOk);
  EXPECT_NE(finding->value.find("than its thickness of 3 mm by 1 mm at most"), std::string::npos) << finding->value;
  LowerUpper(7, 0.002, &tensors);
  finding = SelfContactOf(tensors);
  EXPECT_EQ(finding->severity, Severity::kWarning);
  EXPECT_EQ(finding->frames, std::vector<int>{7});
  EXPECT_NE(finding->value.find("by 2 mm at most"), std::string::npos) << finding->value;
}

TEST(SelfContactCheckTest, FindsFramesInWhichTheClothCutsItself) {
  MotionTensors tensors = Layers();
  const Eigen::Index node = tensors.mesh.num_nodes() - 10;
  tensors.positions(3 * node + 2, 9) -= 0.006;
  tensors.positions(3 * node + 2, 12) -= 0.006;
  tensors.positions(0, 8) = std::nan("");  // of a frame that is not seen as a whole nothing is told
  tensors.positions(3 * node + 2, 8) -= 0.006;
  const std::optional<Finding> finding = SelfContactOf(tensors);
  ASSERT_TRUE(finding);
  EXPECT_EQ(finding->severity, Severity::kWarning);
  EXPECT_EQ(finding->frames, std::vector<int>{9});
  EXPECT_NE(finding->value.find("cut each other, in 2 of 29 frames, from frame 9 on"), std::string::npos)
      << finding->value;
  EXPECT_FALSE(finding->hint.empty());
}

TEST(SelfContactCheckTest, IsSilentWhereNothingCanBeTold) {
  MotionTensors tensors = Layers();
  tensors.scene_text = R"({"clothid_scene": 2, "time_step": 0.005})";
  EXPECT_FALSE(SelfContactOf(tensors));
  tensors = Layers();
  tensors.sigma = Eigen::VectorXd::Constant(tensors.mesh.num_nodes(), 0.002);
  EXPECT_FALSE(SelfContactOf(tensors)) << "noise hides it";
  tensors = Layers();
  tensors.positions.conservativeResize(tensors.positions.rows() - 3, Eigen::NoChange);
  tensors.node_index.resize(static_cast<std::size_t>(tensors.mesh.num_nodes()) - 1);
  std::iota(tensors.node_index.begin(), tensors.node_index.end(), 0);
  EXPECT_FALSE(SelfContactOf(tensors)) << "a node is not seen";
}

}  // namespace
}  // namespace clothid::self_contact_check_test
