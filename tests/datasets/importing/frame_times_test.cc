// Where the times of frames come from, and in what unit.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <string>

#include "datasets/importing/clock_times.h"
#include "tests/datasets/importing/import_fixture.h"
#include "tests/expect_error.h"

namespace clothid::frame_times_test {
namespace {

constexpr ErrorKind kBadData = ErrorKind::kBadData, kUsage = ErrorKind::kUsage;

class FrameTimesTest : public ImportFixture {};

TEST_F(FrameTimesTest, TakesTimesFromElsewhere) {
  tracks_.times.resize(0);
  ExpectError([&] { ImportMotion(tracks_, options_); }, kUsage, {"capture.csv", "no times"});
  options_.edit.frame_rate = 25.0;
  EXPECT_EQ(ImportMotion(tracks_, options_).times[10], 0.4);
  options_.edit.times = Eigen::VectorXd::LinSpaced(kCaptureFrames, 0.0, 5.9);
  ExpectError([&] { ImportMotion(tracks_, options_); }, kUsage, {"frame_rate"});
  options_.edit.frame_rate = 0.0;
  EXPECT_DOUBLE_EQ(ImportMotion(tracks_, options_).times[59], 5.9);
  options_.edit.times[7] = 0.0;
  ExpectError([&] { ImportMotion(tracks_, options_); }, kBadData, {"frame 7"});
  options_.edit.times_name = "t.txt";
  options_.edit.times = Eigen::VectorXd::Zero(3);
  ExpectError([&] { ImportMotion(tracks_, options_); }, kBadData,
              {"t.txt: expected 60 times", "of capture.csv", "found 3"});
}

// A frame that is missing leaves a gap of time, not frames that come too early.
TEST_F(FrameTimesTest, NumbersOfFramesGiveTimes) {
  tracks_.times.resize(0);
  for (int frame = 0; frame < kCaptureFrames; ++frame) tracks_.frame_numbers.push_back(frame < 7 ? frame : frame + 1);
  options_.edit.frame_rate = 10.0;
  options_.edit.first_frame = 5;
  const MotionTensors motion = ImportMotion(tracks_, options_);
  EXPECT_DOUBLE_EQ(motion.times[1], 0.6);
  EXPECT_DOUBLE_EQ(motion.times[2], 0.8);
  EXPECT_EQ(EditTracks(tracks_, options_.edit).tracks.frame_numbers[2], 3);
  options_.edit.frame_rate = 0.0;
  options_.edit.times = Eigen::VectorXd::LinSpaced(kCaptureFrames + 1, 0.0, 6.0);  // of the missing one, too
  EXPECT_DOUBLE_EQ(ImportMotion(tracks_, options_).times[2], 0.8);
  options_.edit.times = Eigen::VectorXd::LinSpaced(kCaptureFrames, 0.0, 5.9);
  EXPECT_DOUBLE_EQ(ImportMotion(tracks_, options_).times[2], 0.7);
  options_.edit.times.resize(0);
  options_.edit.frame_rate = 10.0;
  tracks_.frame_numbers.back() = 1000;
  ExpectError([&] { ImportMotion(tracks_, options_); }, kBadData, {"capture.csv: ", "60 files leave out 941"});
}

// Other formats may hold them, a recording not.
TEST_F(FrameTimesTest, NamesTheUnitOfTimesThatAreNoSeconds) {
  options_.edit.times = 1e9 * tracks_.times;
  options_.edit.times_name = "stamps.npy";
  ExpectError([&] { ImportMotion(tracks_, options_); }, kBadData,
              {"stamps.npy: times look like nanoseconds", "divide by 1e9"});
  EXPECT_EQ(EditTracks(tracks_, options_.edit).tracks.times, options_.edit.times);
  options_.edit.times *= 1e-3;
  ExpectError([&] { ImportMotion(tracks_, options_); }, kBadData, {"stamps.npy: times look like microseconds"});
  options_.edit.time_scale = 1e-6;
  EXPECT_TRUE(ImportMotion(tracks_, options_).times.isApprox(capture_.times, 1e-12));
}

TEST_F(FrameTimesTest, ReadsTimesOfFrames) {
  EXPECT_EQ(ReadTimes(folder_.Write("times.txt", "0\n 0.5 \r\n\n1e0\n")), Eigen::Vector3d(0, 0.5, 1));
  const auto expect_bad = [&](const std::string& text, const char* fragment) {
    const std::string path = folder_.Write("times.txt", text);
    ExpectError([&] { ReadTimes(path); }, kBadData, {"times.txt", fragment});
  };
  expect_bad("0\n1 2\n", ":2");
  expect_bad("0\nnan\n", ":2");
  expect_bad("0\n1\n1\n", ":3: column 'time': expected a time after 1 s of line 2, found '1'");
  expect_bad("\n", "at least one");
  ExpectError([&] { ReadTimes(folder_.File("absent")); }, ErrorKind::kIo, {"absent"});
}

}  // namespace
}  // namespace clothid::frame_times_test
