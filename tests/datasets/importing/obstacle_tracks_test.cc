// Paths of obstacles that come to a recording from files.
#include "datasets/importing/obstacle_tracks.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>

#include "datasets/formats/track_file.h"
#include "datasets/importing/import_motion.h"
#include "datasets/motion/motion_file.h"
#include "sim/obstacle/surface_sequence.h"
#include "sim/path/pose_csv.h"
#include "tests/datasets/importing/made_up_capture.h"
#include "tests/expect_error.h"
#include "tests/sim/scene/triangle_meshes.h"
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
  ExpectError([&] { convert({{"bar", twice}}); }, kBadData, {"twice.csv:3: row 1", "time"});
}

// A cube that a capture sees, from another frame of reference: it grows, or goes the way of the bar.
class BodyTracksTest : public ObstacleTracksTest {
 protected:
  BodyTracksTest() : cube_(CubeMesh(0.1)) {
    nlohmann::json scene = nlohmann::json::parse(kScene);
    nlohmann::json body = {{"type", "mesh"}, {"name", "body"}};
    for (const auto& vertex : cube_.vertices.colwise()) body["vertices"].push_back({vertex[0], vertex[1], vertex[2]});
    for (const auto& face : cube_.faces.colwise()) body["faces"].push_back({face[0], face[1], face[2]});
    scene["obstacles"].push_back(body);
    options_.scene_path = folder_.Write("body.json", scene.dump());
    tracks_.name = "body";
    tracks_.times = Eigen::VectorXd::LinSpaced(201, 99.0, 103.0);
  }

  // The vertices in `frame`, which grow: by a factor of its time.
  Eigen::Matrix3Xd GrownAt(double time) const { return (1.0 + 0.1 * std::sin(time)) * cube_.vertices; }
  void SetTracks(const std::function<Eigen::Matrix3Xd(double)>& places) {
    tracks_.positions.resize(places(0.0).size(), tracks_.times.size());
    for (Eigen::Index i = 0; i < tracks_.times.size(); ++i) {
      tracks_.positions.col(i) = Eigen::Matrix3Xd(robot_ * places(tracks_.times[i] - 100.0)).reshaped();
    }
  }
  MotionTensors Import(const std::string& path, double time_offset = 100.0) {
    options_.obstacle_files = {{"body", path, time_offset, robot_.inverse()}};
    return ImportMotion(ToTracks(capture_, "capture.csv"), options_);
  }
  SceneObstacle Body(const MotionTensors& motion) const {
    return InterpretMotion(motion, "motion.bin", {}).scene.obstacles.at(2);
  }

  TriangleMesh cube_;
  PointTracks tracks_;
};

TEST_F(BodyTracksTest, BringsVerticesOfAnotherClockAndFrameOfReference) {
  SetTracks([&](double time) { return GrownAt(time); });
  tracks_.faces = cube_.faces;
  const std::string path = folder_.File("body.npy");
  WriteTracks(tracks_, path);
  const MotionTensors motion = Import(path);
  const std::string file = folder_.File("motion.bin");
  WriteMotion(motion, file);
  const MotionTensors read = ReadMotionTensors(file);
  EXPECT_EQ(read.sequences.at("body"), motion.sequences.at("body"));
  EXPECT_EQ(read.scene_text.find("body.npy"), std::string::npos);
  const SceneObstacle body = Body(read);
  ASSERT_NE(body.sequence, nullptr);
  for (const double time : capture_.times) {
    EXPECT_LE((body.sequence->At({}, time).pose - GrownAt(time)).cwiseAbs().maxCoeff(), 1e-6) << time;
  }
  EXPECT_NEAR(body.sequence->times()[0], -0.04, 1e-9);  // what is not needed is left out
  // It goes with the clock of a recording, and gives way to a path.
  ImportOptions options;
  options.edit.time_scale = 0.5;
  const SceneObstacle faster = Body(ConvertMotion(read, "motion.bin", options));
  EXPECT_NEAR(faster.sequence->times()[0], -0.02, 1e-9);
  options.edit.time_scale = 1.0;
  options.obstacle_files = {{"body", WriteCsv(), 100.0, robot_.inverse()}};
  const MotionTensors on_path = ConvertMotion(read, "motion.bin", options);
  EXPECT_TRUE(on_path.sequences.empty());
  EXPECT_EQ(Body(on_path).sequence, nullptr);
  EXPECT_LT(Error(on_path, 2), 1e-4);
}

TEST_F(BodyTracksTest, RefusesVerticesThatDoNotFit) {
  SetTracks([&](double time) { return GrownAt(time); });
  const std::string path = folder_.File("body.npy");
  tracks_.faces = cube_.faces;
  tracks_.faces.col(0).swap(tracks_.faces.col(1));
  WriteTracks(tracks_, path);
  ExpectError([&] { Import(path); }, kBadData, {"body.npy: has other triangles than the mesh of the obstacle"});
  tracks_.faces.resize(3, 0);
  tracks_.positions(4, 7) = std::nan("");
  WriteTracks(tracks_, path);
  ExpectError([&] { Import(path); }, kBadData, {"body.npy: frame 7: vertex 1 is not finite"});
  ExpectError([&] { Import(folder_.File("body.pc2")); }, ErrorKind::kIo, {"body.pc2"});
  WriteTracks(tracks_, folder_.File("body.pc2"));
  ExpectError([&] { Import(folder_.File("body.pc2")); }, kUsage, {"body.pc2: has 201 frames without times", "60"});
  tracks_.positions = tracks_.positions.topRows<21>().eval();
  WriteTracks(tracks_, path);
  ExpectError([&] { Import(path); }, kBadData, {"body.npy: frames of 7 vertices; expected the 8 of the mesh"});
  options_.obstacle_files = {{"bar", path, 100.0}};
  ExpectError([&] { ImportMotion(ToTracks(capture_, "capture.csv"), options_); }, kUsage,
              {"body.npy", "expected a mesh, and the obstacle 'bar' is none"});
}

// The sides of the cube as squares that begin at another corner: their fans are other triangles than those of the
// scene.
TEST_F(BodyTracksTest, CutsPolygonsAsTheMeshOfTheObstacle) {
  std::string text =
      "ply\nformat ascii 1.0\nelement face 6\nproperty list uchar int vertex_indices\nelement vertex 8\n"
      "property float x\nproperty float y\nproperty float z\nend_header\n"
      "4 2 3 1 0\n4 5 7 6 4\n4 1 5 4 0\n4 6 7 3 2\n4 4 6 2 0\n4 3 7 5 1\n";
  std::string obj;
  for (const auto vertex : cube_.vertices.colwise()) {
    const Eigen::Vector3d seen = robot_ * Eigen::Vector3d(vertex);
    const std::string place =
        std::to_string(seen.x()) + " " + std::to_string(seen.y()) + " " + std::to_string(seen.z()) + "\n";
    text += place;
    obj += "v " + place;
  }
  obj += "f 3 4 2 1\nf 6 8 7 5\nf 2 6 5 1\nf 7 8 4 3\nf 5 7 3 1\nf 4 8 6 2\n";
  for (int frame = 0; frame < static_cast<int>(capture_.times.size()); ++frame) {
    folder_.Write("body_" + std::to_string(frame) + ".ply", text);
    folder_.Write("body_" + std::to_string(frame) + ".obj", obj);
  }
  for (const char* pattern : {"body_#.ply", "body_#.obj"}) {
    const SceneObstacle body = Body(Import(folder_.File(pattern)));
    ASSERT_NE(body.sequence, nullptr);
    EXPECT_LE((body.sequence->At({}, 0.1).pose - cube_.vertices).cwiseAbs().maxCoeff(), 1e-5);
  }
}

// Four markers of a body that stands, at the first frame of the file, where the scene has it.
TEST_F(BodyTracksTest, FitsPosesToMarkers) {
  Eigen::Matrix3Xd markers(3, 4);
  markers << 0.1, -0.1, 0.0, 0.05, 0.0, 0.1, -0.1, 0.0, 0.0, 0.02, 0.0, 0.1;
  const Eigen::Isometry3d first = BarPose(-1.0);
  SetTracks([&](double time) { return Eigen::Matrix3Xd(BarPose(time) * markers); });
  tracks_.labels = {"a", "b", "c", "d"};
  tracks_.positions.col(60).head<3>().setConstant(std::nan(""));  // three are enough
  tracks_.positions.col(62).head<6>().setConstant(std::nan(""));  // two are not: the curve goes on
  const std::string path = folder_.File("body.trc");
  WriteTracks(tracks_, path);
  const RigidPath fitted = *Body(Import(path)).path;
  for (const double time : capture_.times) {
    const Eigen::Isometry3d expected = BarPose(time) * first.inverse();
    EXPECT_LE((fitted.At(time).pose - expected.matrix().topRows<3>()).cwiseAbs().maxCoeff(), 1e-4) << time;
  }
  tracks_.positions.col(70).segment<3>(3).swap(tracks_.positions.col(70).segment<3>(6));
  WriteTracks(tracks_, path);
  ExpectError([&] { Import(path); }, kBadData, {"body.trc: frame 70: its markers are", "off a rigid body"});
  tracks_.positions.col(0).head<6>().setConstant(std::nan(""));
  WriteTracks(tracks_, path);
  ExpectError([&] { Import(path); }, kBadData, {"body.trc: frame 0: expected three markers"});
}

}  // namespace
}  // namespace clothid::obstacle_tracks_test
