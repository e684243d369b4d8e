// Paths of obstacles that come to a recording from files.
#include "datasets/importing/obstacle_tracks.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "datasets/importing/import_motion.h"
#include "sim/path/pose_csv.h"
#include "tests/datasets/importing/made_up_capture.h"
#include "tests/expect_error.h"
#include "tests/temporary_folder.h"

namespace clothid::obstacle_tracks_test {
namespace {

constexpr ErrorKind kBadData = ErrorKind::kBadData, kUsage = ErrorKind::kUsage;

constexpr char kScene[] = R"({"clothid_scene": 2, "handles": [0, 7], "obstacles": [
    {"type": "plane", "point": [0, 0, -1], "normal": [0, 0, 1]},
    {"name": "bar", "type": "capsule", "from": [0, -0.2, 0], "to": [0, 0.2, 0], "radius": 0.02}]})";

// A bar that goes along x and turns about z, at `time` s.
Eigen::Isometry3d BarPose(double time) {
  Eigen::Isometry3d pose(Eigen::AngleAxisd(0.3 * std::sin(2.0 * time), Eigen::Vector3d::UnitZ()));
  pose.translation() = Eigen::Vector3d(0.2 * time * time, 0.3, 0.5);
  return pose;
}

// A row of BarPose(time) as it is seen from `frame`.
std::string Row(double time, const Eigen::Isometry3d& frame, const std::string& time_text) {
  const Eigen::Isometry3d pose = frame * BarPose(time);
  const Eigen::Quaterniond rotation(pose.linear());
  std::string row = time_text;
  for (const double number : pose.translation()) row += "," + std::to_string(number);
  for (const double number : rotation.coeffs()) row += "," + std::to_string(number);
  return row + "\n";
}

class ObstacleTracksTest : public testing::Test {
 protected:
  ObstacleTracksTest() : capture_(MadeUpCapture()) {
    options_.scene_path = folder_.Write("scene.json", kScene);
    options_.mesh = capture_.mesh;
    options_.handle_nodes = {0, 7};
    robot_ = Eigen::AngleAxisd(0.8, Eigen::Vector3d(1.0, 2.0, 3.0).normalized());
    robot_.translation() = Eigen::Vector3d(0.5, -0.2, 0.1);
  }

  // From 1 s before the first frame to 1 s after the last, at 50 Hz, on a clock 100 s ahead, in the robot's frame of
  // reference.
  std::string WriteCsv() {
    std::string csv = "time,x,y,z,qx,qy,qz,qw\n";
    for (int i = -50; i <= 150; ++i) csv += Row(0.02 * i, robot_, std::to_string(100.0 + 0.02 * i));
    return folder_.Write("bar.csv", csv);
  }

  // The largest difference of the path of an obstacle of a recording from BarPose at its frames.
  double Error(const MotionTensors& motion, std::size_t obstacle = 1) {
    const RigidPath path = *InterpretMotion(motion, "motion.bin", {}).scene.obstacles.at(obstacle).path;
    double largest = 0.0;
    for (Eigen::Index frame = 0; frame < motion.times.size(); ++frame) {
      const double time = capture_.times[frame];
      const AffineMap expected = BarPose(time).matrix().topRows<3>();
      largest = std::max(largest, (path.At(motion.times[frame]).pose - expected).cwiseAbs().maxCoeff());
    }
    return largest;
  }

  TemporaryFolder folder_;
  MotionTensors capture_;
  ImportOptions options_;
  Eigen::Isometry3d robot_;
};

TEST_F(ObstacleTracksTest, BringsPosesOfAnotherClockAndFrameOfReference) {
  options_.obstacle_files = {{"bar", WriteCsv(), 100.0, robot_.inverse()}};
  const MotionTensors motion = ImportMotion(ToTracks(capture_, "capture.csv"), options_);
  EXPECT_LT(Error(motion), 1e-4);  // of cubics through 50 poses per second
  const nlohmann::json scene = nlohmann::json::parse(motion.scene_text);
  EXPECT_FALSE(scene["obstacles"][0].contains("path"));
  EXPECT_EQ(motion.scene_text.find("bar.csv"), std::string::npos);
  // What lies before the first frame and beyond the last, at 1.97 s, and is not needed there is left out.
  const nlohmann::json& rows = scene["obstacles"][1]["path"];
  EXPECT_NEAR(rows.front()[0].get<double>(), -0.04, 1e-9);
  EXPECT_NEAR(rows.back()[0].get<double>(), 2.0, 1e-9);
}

TEST_F(ObstacleTracksTest, GoesWithTheClockOfAnImport) {
  options_.obstacle_files = {{"bar", WriteCsv(), 100.0, robot_.inverse()}};
  options_.edit.start_at = 7.0;
  EXPECT_LT(Error(ImportMotion(ToTracks(capture_, "capture.csv"), options_)), 1e-4);
}

TEST_F(ObstacleTracksTest, ReadsRosPosesAndReplacesAPath) {
  std::string csv =
      "%time,p.position.x,p.position.y,p.position.z,p.orientation.x,p.orientation.y,p.orientation.z,"
      "p.orientation.w\n";
  for (int i = 0; i <= 100; ++i) {
    csv += Row(0.02 * i, Eigen::Isometry3d::Identity(), std::to_string(20000000LL * i));
  }
  ImportOptions options;
  options.obstacle_files = {{"plane", folder_.Write("ros.csv", csv), 0.0, Eigen::Isometry3d::Identity()}};
  capture_.scene_text = kScene;
  MotionTensors motion = ConvertMotion(capture_, "capture.bin", options);
  EXPECT_LT(Error(motion, 0), 1e-4);
  // In place of the path that it has now, beside another one.
  options.obstacle_files = {{"bar", WriteCsv(), 100.0, robot_.inverse()},
                            {"plane", WriteCsv(), 100.0, Eigen::Isometry3d::Identity()}};
  motion = ConvertMotion(motion, "capture.bin", options);
  EXPECT_LT(Error(motion, 1), 1e-4);
  EXPECT_GT(Error(motion, 0), 0.1);
}

// A recording takes the paths of its obstacles along to another clock.
TEST_F(ObstacleTracksTest, ARecordingKeepsOneClock) {
  options_.obstacle_files = {{"bar", WriteCsv(), 100.0, robot_.inverse()}};
  const MotionTensors motion = ImportMotion(ToTracks(capture_, "capture.csv"), options_);
  ImportOptions options;
  options.edit.start_at = 7.0;
  options.edit.time_scale = 0.5;
  const MotionTensors converted = ConvertMotion(motion, "capture.bin", options);
  EXPECT_NEAR(converted.times[1] - converted.times[0], 0.5 / kCaptureRate, 1e-12);
  EXPECT_LT(Error(converted), 1e-4);
  options.edit.frame_rate = 30.0;
  options.handle_nodes = {0, 7};
  ExpectError([&] { ConvertMotion(motion, "capture.bin", options); }, kUsage, {"capture.bin", "obstacles", "times"});
}

TEST_F(ObstacleTracksTest, RefusesWhatDoesNotFit) {
  const auto convert = [&](const std::vector<ObstacleFile>& files) {
    capture_.scene_text = kScene;
    ImportOptions options;
    options.obstacle_files = files;
    ConvertMotion(capture_, "capture.bin", options);
  };
  const std::string path = WriteCsv();
  ExpectError([&] { convert({{"ball", path, 100.0}}); }, kUsage, {"bar.csv", "'ball'", "of the scene: plane, bar"});
  ExpectError([&] { convert({{"bar", path, 100.0}, {"bar", path, 100.0}}); }, kUsage, {"bar.csv", "second", "'bar'"});
  ExpectError([&] { convert({{"bar", path, 0.0}}); }, kBadData, {"bar.csv: is known from 99", "another time offset"});
  ExpectError([&] { convert({{"bar", "absent.csv"}}); }, ErrorKind::kIo, {"absent.csv"});
  const std::string table = folder_.Write("handles.csv", "time,x0,y0,z0\n0,1,2,3\n");
  ExpectError([&] { convert({{"bar", table}}); }, kBadData, {"handles.csv:1", "qw"});
  const std::string twice = folder_.Write(
      "twice.csv",
      "%time,p.position.x,p.position.y,p.position.z,"
      "p.orientation.x,p.orientation.y,p.orientation.z,p.orientation.w\n0,0,0,0,0,0,0,1\n0,0,0,0,0,0,0,1\n");
  ExpectError([&] { convert({{"bar", twice}}); }, kBadData, {"twice.csv: row 1", "time"});
}

}  // namespace
}  // namespace clothid::obstacle_tracks_test
