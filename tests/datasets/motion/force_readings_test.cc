// Forces in motion.bin: written, read, and every fault named.
#include "datasets/motion/force_readings.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <string>

#include "datasets/motion/motion_file.h"
#include "datasets/motion/motion_validation.h"
#include "tests/expect_error.h"
#include "tests/temporary_folder.h"

namespace clothid::force_readings_test {
namespace {

constexpr ErrorKind kBadData = ErrorKind::kBadData;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// Three frames of 3 x 3 nodes that hang at two corners, and seven readings of two sensors.
MotionTensors SmallMotion() {
  MotionTensors tensors;
  GridOptions grid;
  grid.nodes = {3, 3};
  tensors.mesh = MakeGrid(grid);
  tensors.times = Eigen::Vector3d(0.0, 0.1, 0.2);
  tensors.positions = tensors.mesh.rest_positions.reshaped().replicate(1, 3);
  tensors.scene_text = R"({"clothid_scene": 2, "handles": [0, 2]})";
  tensors.forces.times = Eigen::VectorXd::LinSpaced(7, 0.0, 0.19);
  tensors.forces.groups = {{2}, {0}};
  tensors.forces.sigma = Eigen::Vector2d(0.01, 0.02);
  tensors.forces.values = Eigen::MatrixXd::NullaryExpr(
      6, 7, [](Eigen::Index i, Eigen::Index j) { return 0.1 * static_cast<double>(i) - static_cast<double>(j); });
  tensors.forces.values(1, 3) = kNaN;
  return tensors;
}

bool SameNumbers(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return a.rows() == b.rows() && a.cols() == b.cols() &&
         ((a.array() == b.array()) || (a.array().isNaN() && b.array().isNaN())).all();
}

class ForceReadingsTest : public testing::Test {
 protected:
  std::string Path() const { return folder_.File("hung.motion.bin"); }
  std::string Bytes() const {
    std::ifstream file(Path(), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  // One change of the tensors is refused when they are written, the same in a recording in memory.
  void ExpectRefused(const std::function<void(ForceReadings*)>& spoil, const std::string& word) const {
    MotionTensors tensors = SmallMotion();
    spoil(&tensors.forces);
    ExpectError([&] { WriteMotion(tensors, Path()); }, kBadData, {"hung.motion.bin", word.c_str()});
    EXPECT_FALSE(std::filesystem::exists(Path()));
    RecordedMotion motion = InterpretMotion(SmallMotion(), "memory");
    spoil(&motion.forces);
    ExpectError([&] { ValidateMotion(motion); }, kBadData, {"memory", word.c_str()});
  }

  TemporaryFolder folder_;
};

TEST_F(ForceReadingsTest, AreReadAsTheyWereWritten) {
  const MotionTensors written = SmallMotion();
  WriteMotion(written, Path());
  const std::string bytes = Bytes();
  const MotionTensors read = ReadMotionTensors(Path());
  EXPECT_TRUE(SameNumbers(read.forces.times, written.forces.times));
  EXPECT_TRUE(SameNumbers(read.forces.values, written.forces.values));
  EXPECT_TRUE(SameNumbers(read.forces.sigma, written.forces.sigma));
  EXPECT_EQ(read.forces.groups, written.forces.groups);
  WriteMotion(read, Path());
  EXPECT_EQ(Bytes(), bytes);
  const RecordedMotion motion = ReadMotion(Path());
  EXPECT_TRUE(SameNumbers(motion.forces.values, written.forces.values));
  EXPECT_EQ(motion.forces.num_groups(), 2);
  EXPECT_EQ(motion.forces.num_readings(), 7);
}

TEST_F(ForceReadingsTest, AreOfAllHandlesWithoutGroups) {
  MotionTensors tensors = SmallMotion();
  tensors.forces.groups.clear();
  tensors.forces.values = tensors.forces.values.topRows(3).eval();
  tensors.forces.sigma = tensors.forces.sigma.head(1).eval();
  WriteMotion(tensors, Path());
  const RecordedMotion motion = ReadMotion(Path());
  EXPECT_TRUE(motion.forces.groups.empty());
  EXPECT_EQ(motion.forces.num_groups(), 1);
}

// A program that does not know them refuses a file that has them, by their names; one without them has not changed.
TEST_F(ForceReadingsTest, LeaveNoTraceWhereThereAreNone) {
  MotionTensors tensors = SmallMotion();
  WriteMotion(tensors, Path());
  EXPECT_NE(Bytes().find("handle_forces"), std::string::npos);
  tensors.forces = ForceReadings();
  WriteMotion(tensors, Path());
  EXPECT_EQ(Bytes().find("force"), std::string::npos);
  EXPECT_TRUE(ReadMotion(Path()).forces.is_empty());
}

TEST_F(ForceReadingsTest, AreRefusedWhereTheyAreWrong) {
  ExpectRefused([](ForceReadings* forces) { forces->times[3] = forces->times[2]; }, "force_times");
  ExpectRefused([](ForceReadings* forces) { forces->times[3] = kNaN; }, "force_times");
  ExpectRefused([](ForceReadings* forces) { forces->values.conservativeResize(5, 7); }, "handle_forces");
  ExpectRefused([](ForceReadings* forces) { forces->values(0, 0) = std::numeric_limits<double>::infinity(); },
                "handle_forces");
  ExpectRefused([](ForceReadings* forces) { forces->values.setConstant(kNaN); }, "handle_forces");
  ExpectRefused([](ForceReadings* forces) { forces->sigma[1] = 0.0; }, "force_sigma");
  ExpectRefused([](ForceReadings* forces) { forces->sigma.conservativeResize(1); }, "force_sigma");
  ExpectRefused([](ForceReadings* forces) { forces->groups[1] = {9}; }, "force_nodes");
  ExpectRefused([](ForceReadings* forces) { forces->groups[1] = {2}; }, "listed twice");
  ExpectRefused([](ForceReadings* forces) { forces->groups[1].clear(); }, "without a node");
  ExpectRefused([](ForceReadings* forces) { forces->times = Eigen::VectorXd(); }, "force_times");
}

TEST_F(ForceReadingsTest, AreRefusedWhereTheSceneHasNoSuchHandle) {
  MotionTensors tensors = SmallMotion();
  tensors.forces.groups = {{2}, {1}};
  ExpectError([&] { ValidateMotion(InterpretMotion(tensors, "memory")); }, kBadData, {"node 1 is no handle"});
  tensors.scene_text = R"({"clothid_scene": 2})";
  ExpectError([&] { ValidateMotion(InterpretMotion(tensors, "memory")); }, kBadData, {"has no handles"});
}

TEST_F(ForceReadingsTest, AreRefusedOutsideOfTheSimulatedTime) {
  MotionTensors tensors = SmallMotion();
  tensors.forces.times[0] = -0.1;
  ExpectError([&] { ValidateMotion(InterpretMotion(tensors, "memory")); }, kBadData,
              {"force_times", "before the start"});
}

}  // namespace
}  // namespace clothid::force_readings_test
