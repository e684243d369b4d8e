#include "datasets/importing/force_file.h"

#include <gtest/gtest.h>

#include <cmath>

#include "datasets/checking/motion_check.h"
#include "datasets/importing/import_motion.h"
#include "sim/base/npy_file.h"
#include "tests/expect_error.h"
#include "tests/temporary_folder.h"

namespace clothid::force_file_test {
namespace {

constexpr ErrorKind kUsage = ErrorKind::kUsage, kBadData = ErrorKind::kBadData;

class ForceFileTest : public testing::Test {
 protected:
  ForceFileTest() { file_.sigma = 0.05; }

  void Write(const std::string& name, const std::string& text) { file_.path = folder_.Write(name, text); }

  TemporaryFolder folder_;
  ForceFile file_;
  const Eigen::Vector4d frames_ = {1.0, 1.1, 1.2, 1.3};
};

TEST_F(ForceFileTest, ReadsCsvOnItsOwnClock) {
  Write("f.csv", "time, x, z\n10.5,1,2\n11.02,3,\n11.25,nan,5\r\n12,6,7\n");
  file_.time_offset = 10.0;
  file_.scale = -2.0;
  const ForceReadings forces = ReadForces(file_, frames_, 0.0);
  ASSERT_EQ(forces.times.size(), 2);  // those between the first frame and the last
  EXPECT_NEAR(forces.times[0], 1.02, 1e-12);
  EXPECT_EQ(forces.values(0, 0), -6.0);
  EXPECT_TRUE(std::isnan(forces.values(2, 0)));
  EXPECT_TRUE(std::isnan(forces.values(1, 0)));  // no such column
  EXPECT_TRUE(std::isnan(forces.values(0, 1)));
  EXPECT_EQ(forces.values(2, 1), -10.0);
  EXPECT_EQ(forces.sigma, Eigen::VectorXd::Constant(1, 0.05));
  EXPECT_TRUE(forces.groups.empty());
}

TEST_F(ForceFileTest, ReadsGroups) {
  Write("f.csv", "time,z1,x0\n1,2,3\n1.1,4,5\n");
  file_.groups = {{0, 1}, {4}};
  const ForceReadings forces = ReadForces(file_, frames_, 0.0);
  EXPECT_EQ(forces.groups, file_.groups);
  EXPECT_EQ(forces.values(0, 1), 5.0);
  EXPECT_EQ(forces.values(5, 1), 4.0);
  EXPECT_EQ(forces.values.array().isNaN().count(), 8);
}

TEST_F(ForceFileTest, ReadsQuotedCells) {
  Write("f.csv", "\"time\",\"z1\", \"x0\"\r\n\"1\",\"2\",\r\n1.1,\"4\",\" 5\"\r\n");
  file_.groups = {{0, 1}, {4}};
  const ForceReadings forces = ReadForces(file_, frames_, 0.0);
  EXPECT_EQ(forces.values(0, 1), 5.0);
  EXPECT_EQ(forces.values(5, 1), 4.0);
  EXPECT_TRUE(std::isnan(forces.values(0, 0)));
  Write("f.csv", "time,z1,x0\n1,\"2\" 3,4\n");
  ExpectError([&] { ReadForces(file_, frames_, 0.0); }, kBadData, {"f.csv:2: expected quoted cells to end"});
}

TEST_F(ForceFileTest, ReadsArrays) {
  Write("f.npy", NpyBytes(NpyArray{{4}, {1.0, 2.0, 3.0, 4.0}}));
  ExpectError([&] { ReadForces(file_, frames_, 0.0); }, kUsage, {"f.npy", "expected its axis"});
  file_.axis = 1;
  ForceReadings forces = ReadForces(file_, frames_, 0.0);
  EXPECT_EQ(forces.times, frames_);
  EXPECT_EQ(forces.values(1, 2), 3.0);
  EXPECT_EQ(forces.values.array().isNaN().count(), 8);
  file_.time_offset = 0.1;
  forces = ReadForces(file_, frames_, 0.5);
  ASSERT_EQ(forces.times.size(), 3);  // the first is from before the recording
  EXPECT_NEAR(forces.times[1], 1.1, 1e-12);
  EXPECT_EQ(forces.values(1, 1), 3.0);
  file_.time_offset = 2.0;
  ExpectError([&] { ReadForces(file_, frames_, 0.0); }, kBadData, {"f.npy", "another time offset"});
  file_.time_offset = 0.0;

  Write("g.npy", NpyBytes(NpyArray{{2, 3}, {1.0, 2.0, 3.0, 4.0, 5.0, 6.0}}));
  ExpectError([&] { ReadForces(file_, frames_, 0.0); }, kUsage, {"g.npy", "expected no axis"});
  file_.axis.reset();
  ExpectError([&] { ReadForces(file_, frames_, 0.0); }, kBadData, {"g.npy", "a file with their times"});
  file_.times_path = folder_.Write("t.npy", NpyBytes(NpyArray{{2}, {1.05, 1.15}}));
  forces = ReadForces(file_, frames_, 0.0);
  EXPECT_EQ(forces.times, Eigen::Vector2d(1.05, 1.15));
  file_.times_path = folder_.Write("t.txt", "1.05\n1.15\n");
  EXPECT_EQ(ReadForces(file_, frames_, 0.0).times, forces.times);
  file_.times_path = folder_.Write("t.txt", "1.05\n1.05\n");
  ExpectError([&] { ReadForces(file_, frames_, 0.0); }, kBadData, {"t.txt:2: column 'time'", "of line 1"});
  file_.times_path = folder_.Write("t.txt", "1.05\n");
  ExpectError([&] { ReadForces(file_, frames_, 0.0); }, kBadData, {"t.txt: holds 1 times", "2 readings of", "g.npy"});
  EXPECT_EQ(forces.values.col(1), Eigen::Vector3d(4.0, 5.0, 6.0));
}

TEST_F(ForceFileTest, ReadsBackWhatIsWritten) {
  ForceReadings written;
  written.times = Eigen::Vector3d(1.0, 1.1, 1.3);
  written.groups = {{0, 1}, {4}};
  written.values = Eigen::MatrixXd::Constant(6, 3, 1.0 / 3.0);
  written.values(4, 1) = std::nan("");
  file_.groups = written.groups;
  Write("f.csv", ForceCsv(written));
  const ForceReadings read = ReadForces(file_, frames_, 0.0);
  EXPECT_EQ(read.times, written.times);
  EXPECT_TRUE(std::isnan(read.values(4, 1)));
  EXPECT_EQ((read.values.array() == 1.0 / 3.0).count(), 17);
}

TEST_F(ForceFileTest, NamesFaults) {
  const auto expect = [&](const std::string& text, const std::string& word) {
    Write("f.csv", text);
    ExpectError([&] { ReadForces(file_, frames_, 0.0); }, kBadData, {"f.csv", word.c_str()});
  };
  expect("", "expected the header 'time,x,y,z'");
  expect("t,x\n1,2\n", ":1: column 'time'");
  expect("time,w\n1,2\n", ":1: expected a column of a component, as in 'time,x,y,z', found 'time,w'");
  expect("time,x,x0\n1,2,3\n", ":1: column 'x0'");
  expect("time,x\n1,1\n1,1\n", ":3: column 'time': expected a time after 1 s of line 2");
  expect("time,x\n0,1\n10000000,1\n20000000,1\n", ": times look like nanoseconds");
  expect("time,x1\n1,2\n", "column 'x1'");
  expect("time,x\n1\n", ":2: expected 2 cells");
  expect("time,x\na,1\n", ":2: column 'time'");
  expect("time,x\n1,b\n", ":2: column 'x'");
  expect("time,x\n3,1\n4,1\n", "another time offset");
  Write("f.csv", "time,x\n1,1\n");
  file_.sigma = 0.0;
  ExpectError([&] { ReadForces(file_, frames_, 0.0); }, kUsage, {"standard deviation"});
}

TEST(ForceGroupsTest, AreParsed) {
  EXPECT_EQ(ParseForceGroups("0,1:4", "--force_nodes"), (std::vector<std::vector<int>>{{0, 1}, {4}}));
  EXPECT_TRUE(ParseForceGroups("", "--force_nodes").empty());
  for (const char* text : {":", "0,", "a", "-1", "0:"}) {
    ExpectError([&] { ParseForceGroups(text, "--force_nodes"); }, kUsage, {"--force_nodes"});
  }
}

// A cloth of 0.1 kg/m^2 x 0.09 m^2 that hangs still: 88 mN.
RecordedMotion HangingCloth(const Eigen::Vector3d& force) {
  MotionTensors tensors;
  GridOptions grid;
  grid.nodes = {4, 4};
  grid.size = {0.3, 0.3};
  grid.axes = {Eigen::Vector3d::UnitX(), -Eigen::Vector3d::UnitZ()};
  tensors.mesh = MakeGrid(grid);
  tensors.times = Eigen::VectorXd::LinSpaced(11, 0.0, 1.0);
  tensors.positions = tensors.mesh.rest_positions.reshaped().replicate(1, 11);
  tensors.scene_text = R"({"clothid_scene": 2, "handles": [0, 1, 2, 3], "materials": {"density": 0.1}})";
  tensors.forces.times = tensors.times;
  tensors.forces.sigma = Eigen::VectorXd::Constant(1, 1e-3);
  tensors.forces.values = force.replicate(1, 11);
  for (int i = 0; i < 11; ++i) tensors.forces.values.col(i).array() += 1e-3 * (i % 2);
  return InterpretMotion(tensors, "hung");
}

std::string FindingsOf(const RecordedMotion& motion, const std::string& what) {
  for (const Finding& finding : CheckMotion(motion)) {
    if (finding.what == what) return SeverityName(finding.severity) + ": " + finding.value + " -> " + finding.hint;
  }
  return "none";
}

TEST(ForceCheckTest, ComparesWithTheWeight) {
  const std::string what = "weight at the handles";
  EXPECT_EQ(FindingsOf(HangingCloth({0.0, 0.0, 0.088}), what).substr(0, 3), "ok:");
  EXPECT_NE(FindingsOf(HangingCloth({0.0, 0.0, -0.088}), what).find("--force_scale -1"), std::string::npos);
  EXPECT_NE(FindingsOf(HangingCloth({0.0, 0.0, 0.5}), what).find("force_bias"), std::string::npos);
  EXPECT_NE(FindingsOf(HangingCloth({0.0, 0.0, 0.0}), what).find("note: "), std::string::npos);
}

TEST(ForceCheckTest, FindsWhatNeverChangesAndWhatIsOutside) {
  RecordedMotion motion = HangingCloth({0.0, 0.0, 0.088});
  EXPECT_EQ(FindingsOf(motion, "constant force"), "none");
  EXPECT_EQ(FindingsOf(motion, "force times"), "none");
  EXPECT_EQ(FindingsOf(motion, "forces").substr(0, 3), "ok:");
  motion.forces.values.row(1).setZero();
  EXPECT_EQ(FindingsOf(motion, "constant force").substr(0, 10), "warning: y");
  motion.forces.times.array() += 0.55;
  EXPECT_EQ(FindingsOf(motion, "force times").substr(0, 16), "warning: 6 of 11");
  motion.forces = ForceReadings();
  EXPECT_EQ(FindingsOf(motion, "forces"), "none");
}

// Forces turn with the axes of the points and stay on their clock.
TEST(ConvertedForcesTest, GoWithTheRecording) {
  const RecordedMotion motion = HangingCloth({0.0, 0.0, 0.088});
  MotionTensors tensors;
  tensors.mesh = motion.scene.mesh;
  tensors.times = motion.times;
  tensors.positions = motion.positions;
  tensors.scene_text = motion.scene_text;
  tensors.forces = motion.forces;
  ImportOptions options;
  options.edit.start_at = 5.0;
  options.edit.first_frame = 2;
  options.edit.transform.linear() = Eigen::AngleAxisd(M_PI / 2.0, Eigen::Vector3d::UnitX()).toRotationMatrix();
  const MotionTensors converted = ConvertMotion(tensors, "hung", options);
  ASSERT_EQ(converted.forces.num_readings(), 9);
  EXPECT_NEAR(converted.forces.times[0], 5.0, 1e-12);
  EXPECT_NEAR(converted.forces.values(1, 0), -0.088, 1e-12);
  EXPECT_NEAR(converted.forces.values(2, 0), 0.0, 1e-12);
  tensors.forces.values.row(0).setConstant(std::nan(""));
  ExpectError([&] { ConvertMotion(tensors, "hung", options); }, kBadData, {"cannot be turned"});
}

}  // namespace
}  // namespace clothid::force_file_test
