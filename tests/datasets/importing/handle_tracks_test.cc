// Paths of handles: of measured points, or of files with their own clock.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>
#include <string>

#include "tests/datasets/importing/import_fixture.h"
#include "tests/expect_error.h"

namespace clothid::handle_tracks_test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr ErrorKind kBadData = ErrorKind::kBadData, kUsage = ErrorKind::kUsage;

class HandleTracksTest : public ImportFixture {};

TEST_F(HandleTracksTest, FillsGapsInMeasuredHandles) {
  const Eigen::VectorXd measured = tracks_.positions.row(0);
  for (const int frame : {0, 20, 21, 59}) tracks_.positions.col(frame).head<3>().setConstant(kNaN);
  const MotionTensors motion = ImportMotion(tracks_, options_);
  EXPECT_TRUE(motion.handle_positions.allFinite());
  EXPECT_EQ(motion.handle_positions(0, 0), measured[1]);    // stands still before it is first seen
  EXPECT_EQ(motion.handle_positions(0, 59), measured[58]);  // and after it was last seen
  EXPECT_NEAR(motion.handle_positions(0, 20), measured[20], 5.0 * kCaptureNoise);
  EXPECT_TRUE(motion.positions.col(20).head<3>().hasNaN());
  tracks_.positions.topRows(3).setConstant(kNaN);
  ExpectError([&] { ImportMotion(tracks_, options_); }, kBadData, {"point 0", "never seen"});
}

// Paths at 50 Hz by a clock that is 100 s ahead and runs before the recording is put at 0.
TEST_F(HandleTracksTest, ResamplesHandlesOfAnotherClock) {
  std::string csv = "time,x0,y0,z0,x1,y1,z1\n";
  const auto number = [](double value) { return "," + std::to_string(value); };
  for (int i = -5; i <= 110; ++i) {
    const double time = 0.02 * i;
    csv += std::to_string(1100.0 + time);
    for (const int node : {0, 7}) {
      for (const double coordinate : CapturedPlace(node, 0, time)) csv += number(coordinate - 1.0);
    }
    csv += "\n";
  }
  tracks_.times.array() += 1000.0;
  options_.edit.start_at = 0.0;
  options_.handle_file = HandleFile{folder_.Write("handles.csv", csv), 100.0, Eigen::Isometry3d::Identity(), ""};
  options_.handle_file->transform.translation().setOnes();
  const MotionTensors motion = ImportMotion(tracks_, options_);
  const HandlePath path(motion.handle_times, motion.handle_positions);
  for (int frame = 0; frame < kCaptureFrames; ++frame) {
    EXPECT_LT((path.At(motion.times[frame]) - capture_.handle_positions.col(frame)).cwiseAbs().maxCoeff(), 1e-5);
  }
  // What lies beyond the last frame, at 1.97 s, and is not needed there is left out.
  EXPECT_NEAR(motion.handle_times[0], -0.04, 1e-9);
  EXPECT_NEAR(motion.handle_times[motion.handle_times.size() - 1], 2.0, 1e-9);
  options_.handle_file->time_offset = 0.0;
  ExpectError([&] { ImportMotion(tracks_, options_); }, kBadData, {"handles.csv", "time offset"});
  options_.handle_nodes.clear();
  ExpectError([&] { ImportMotion(tracks_, options_); }, kUsage, {"handles.csv", "nodes"});
}

// A tool that turns about z and holds two nodes.
TEST_F(HandleTracksTest, LetsAToolHoldNodes) {
  std::string csv =
      "%time,p.position.x,p.position.y,p.position.z,p.orientation.x,p.orientation.y,p.orientation.z,"
      "p.orientation.w\n";
  csv += "0,1,0,0,0,0,0,1\n3000000000,1,0,0,0,0,0.70710678118654752,0.70710678118654752\n";
  options_.handle_file = HandleFile{folder_.Write("tool.csv", csv), 0.0, Eigen::Isometry3d::Identity(), ""};
  ExpectError([&] { ImportMotion(tracks_, options_); }, kUsage, {"tool.csv", "2 nodes"});
  const auto offsets = [&](const std::string& text) {
    options_.handle_file->offsets_path = folder_.Write("offsets.json", text);
  };
  offsets(R"({"0": [0, 0.1, 0]})");
  ExpectError([&] { ImportMotion(tracks_, options_); }, kBadData, {"offsets.json", "'7'"});
  offsets(R"({"0": [0, 0.1, 0], "7": [0.2, 0, 0], "8": [0, 0, 0]})");
  ExpectError([&] { ImportMotion(tracks_, options_); }, kBadData, {"offsets.json", "'8'", "handles"});
  offsets(R"({"0": [0, 0.1, 0], "7": [0.2, 0, 0]})");
  options_.edit.times = Eigen::VectorXd::LinSpaced(kCaptureFrames, 0.0, 3.0);
  const MotionTensors motion = ImportMotion(tracks_, options_);
  EXPECT_TRUE(motion.handle_positions.col(0).isApprox((Eigen::VectorXd(6) << 1, 0.1, 0, 1.2, 0, 0).finished(), 1e-12));
  EXPECT_EQ(motion.handle_times, Eigen::Vector2d(0, 3));
  EXPECT_TRUE(motion.handle_positions.col(1).isApprox((Eigen::VectorXd(6) << 0.9, 0, 0, 1, 0.2, 0).finished(), 1e-12));
}

// A path with times of its own keeps all of them where frames are left out.
TEST_F(HandleTracksTest, HandlesKeepTheirOwnTimes) {
  capture_.handle_times = Eigen::VectorXd::LinSpaced(5, -1.0, 3.0);
  capture_.handle_positions = capture_.handle_positions.leftCols(5).eval();
  ImportOptions options;
  options.edit.scale = 2.0;
  options.edit.time_scale = 0.5;
  options.edit.start_at = 10.0;
  options.edit.skipped_frames = {3, 4};
  const MotionTensors motion = ConvertMotion(capture_, "capture.bin", options);
  EXPECT_TRUE(motion.handle_times.isApprox(Eigen::VectorXd::LinSpaced(5, 9.5, 11.5)));
  EXPECT_EQ(motion.handle_positions, 2.0 * capture_.handle_positions);
  options.edit.frame_rate = 30.0;
  ExpectError([&] { ConvertMotion(capture_, "capture.bin", options); }, kUsage, {"capture.bin", "handles have times"});
  options.handle_nodes = {0, 7};
  EXPECT_EQ(ConvertMotion(capture_, "capture.bin", options).handle_times.size(), 0);  // those of the measured points
}

}  // namespace
}  // namespace clothid::handle_tracks_test
