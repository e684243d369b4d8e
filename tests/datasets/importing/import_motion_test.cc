#include "datasets/importing/import_motion.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>

#include "tests/datasets/importing/made_up_capture.h"
#include "tests/expect_error.h"
#include "tests/temporary_folder.h"

namespace clothid::import_motion_test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr ErrorKind kBadData = ErrorKind::kBadData, kUsage = ErrorKind::kUsage;

constexpr char kFromRest[] = R"({"clothid_scene": 1, "initial": {"positions": "rest"}})";

class ImportTest : public testing::Test {
 protected:
  ImportTest() : capture_(MadeUpCapture()) {
    tracks_ = ToTracks(capture_, "capture.csv");
    options_.scene_path = folder_.Write("scene.json", R"({"clothid_scene": 1, "handles": [0, 7]})");
    options_.mesh = capture_.mesh;
    options_.handle_nodes = {0, 7};
  }

  TemporaryFolder folder_;
  MotionTensors capture_;
  PointTracks tracks_;
  ImportOptions options_;
};

TEST_F(ImportTest, KeepsWhatNeedsNoChange) {
  options_.sigma = 0.004;
  options_.provenance = "a test";
  const MotionTensors motion = ImportMotion(tracks_, options_);
  EXPECT_EQ(motion.positions, capture_.positions);
  EXPECT_EQ(motion.times, capture_.times);
  EXPECT_EQ(motion.mesh.faces, capture_.mesh.faces);
  EXPECT_EQ(motion.handle_index, (std::vector<int>{0, 7}));
  EXPECT_EQ(motion.handle_positions.topRows(3), capture_.positions.topRows(3));
  EXPECT_EQ(motion.sigma, Eigen::VectorXd::Constant(64, 0.004));
  EXPECT_EQ(motion.scene_text, R"({"clothid_scene": 1, "handles": [0, 7]})");
  EXPECT_EQ(motion.provenance, "a test");
  EXPECT_TRUE(motion.node_index.empty());
}

TEST_F(ImportTest, ChangesUnitFrameOfReferenceAndClock) {
  PointTracks tracks = tracks_;
  const Eigen::Isometry3d pose = Eigen::Translation3d(1, 2, 3) * Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 2) / 3.0);
  for (double* place = tracks.positions.data(); place < tracks.positions.data() + tracks.positions.size(); place += 3) {
    Eigen::Map<Eigen::Vector3d> position(place);
    position = 1000.0 * (pose * position);
  }
  tracks.positions.col(5).segment<3>(30)[1] = kNaN;
  tracks.times = 1e9 + 1e3 * tracks.times.array();
  options_.edit.scale = 0.001;
  options_.edit.transform = pose.inverse();
  options_.edit.time_scale = 0.001;
  options_.edit.start_at = 2.0;
  options_.edit.first_frame = 4;
  options_.edit.end_frame = 10;
  const MotionTensors motion = ImportMotion(tracks, options_);
  ASSERT_EQ(motion.times.size(), 6);
  EXPECT_EQ(motion.times[0], 2.0);
  EXPECT_TRUE((motion.times.array() - 2.0).isApprox(capture_.times.segment(4, 6).array() - capture_.times[4], 1e-6));
  EXPECT_EQ(motion.positions.array().isNaN().count(), 3);  // the whole point
  EXPECT_TRUE(motion.positions.col(1).segment<3>(30).hasNaN());
  EXPECT_TRUE(motion.positions.col(0).isApprox(capture_.positions.col(4), 1e-13));
  EXPECT_TRUE(motion.positions.col(5).isApprox(capture_.positions.col(9), 1e-13));
}

// Before unit and axes change.
TEST_F(ImportTest, MakesGapsOfNumbersThatStandForThem) {
  tracks_.positions *= 1000.0;
  tracks_.positions.col(5).segment<3>(30).setZero();
  tracks_.positions.col(6).segment<3>(0).setConstant(-1e6);
  tracks_.positions.col(7).segment<3>(33) << 0.0, 0.0, 1.0;
  options_.edit.missing = MissingValues::Parse("0:-1e6", "missing");
  options_.edit.scale = 0.001;
  options_.edit.transform = Eigen::Translation3d(1.0, 2.0, 3.0);
  const MotionTensors motion = ImportMotion(tracks_, options_);
  EXPECT_EQ(motion.positions.array().isNaN().count(), 6);
  EXPECT_TRUE(motion.positions.col(5).segment<3>(30).array().isNaN().all());
  EXPECT_TRUE(motion.positions.col(6).segment<3>(0).array().isNaN().all());
  EXPECT_TRUE(motion.handle_positions.allFinite());
  EXPECT_LT((motion.handle_positions.col(6) - motion.handle_positions.col(5)).norm(), 0.1);
}

TEST_F(ImportTest, MakesGapsInRecordingsTheirHandlesAndClouds) {
  capture_.positions.col(5).segment<3>(0).setZero();
  capture_.handle_positions.col(5).head<3>().setZero();
  capture_.handle_positions.bottomRows<3>().setZero();  // a handle that stands there
  for (Eigen::Index frame = 0; frame < capture_.times.size(); ++frame) {
    capture_.clouds.emplace_back(Eigen::Matrix3Xd::Ones(3, 4));
    capture_.clouds.back().col(frame % 4).setZero();
  }
  ImportOptions options;
  options.edit.missing = MissingValues::Parse("0,0,0", "missing");
  const MotionTensors motion = ConvertMotion(capture_, "capture.bin", options);
  EXPECT_TRUE(motion.positions.col(5).segment<3>(0).array().isNaN().all());
  EXPECT_EQ(motion.positions.array().isNaN().count(), 3);
  EXPECT_LT((motion.handle_positions.col(5) - motion.handle_positions.col(4)).norm(), 0.1);
  EXPECT_TRUE(motion.handle_positions.bottomRows<3>().isZero(0.0));
  for (const Eigen::Matrix3Xd& cloud : motion.clouds) EXPECT_EQ(cloud, Eigen::Matrix3Xd::Ones(3, 3));
}

TEST_F(ImportTest, TakesTimesFromElsewhere) {
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
TEST_F(ImportTest, NumbersOfFramesGiveTimes) {
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
TEST_F(ImportTest, NamesTheUnitOfTimesThatAreNoSeconds) {
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

TEST_F(ImportTest, ReadsTimesOfFrames) {
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

TEST_F(ImportTest, FillsGapsInMeasuredHandles) {
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
TEST_F(ImportTest, ResamplesHandlesOfAnotherClock) {
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
TEST_F(ImportTest, LetsAToolHoldNodes) {
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

// The points in another order, a little off and turned.
TEST_F(ImportTest, FindsTheNearestNodes) {
  std::vector<int> order(64);
  std::iota(order.begin(), order.end(), 0);
  std::reverse(order.begin(), order.end());
  order.resize(20);
  const Eigen::Isometry3d moved =
      Eigen::Translation3d(0.004, 0.01, -0.003) * Eigen::AngleAxisd(0.03, Eigen::Vector3d::UnitZ());
  PointTracks tracks = tracks_;
  tracks.positions.resize(60, 3);
  tracks.times = Eigen::Vector3d(0, 1, 2);
  for (int p = 0; p < 20; ++p) {
    tracks.positions.middleRows<3>(3 * p).colwise() = moved * capture_.mesh.rest_positions.col(order[p]);
  }
  tracks.positions.col(0).head<3>().setConstant(kNaN);  // another frame shows all of them
  options_.handle_nodes = {63};
  options_.scene_path = folder_.Write("scene.json", R"({"clothid_scene": 1})");
  options_.map = PointMapKind::kNearest;
  const MotionTensors motion = ImportMotion(tracks, options_);
  EXPECT_EQ(motion.node_index, order);
  EXPECT_EQ(motion.handle_positions.col(2), tracks.positions.col(2).head<3>());
  tracks.positions.middleRows<3>(3) = tracks.positions.middleRows<3>(6);
  ExpectError([&] { ImportMotion(tracks, options_); }, kBadData, {"point 1", "point 2", "node 61"});
  tracks.positions.row(3).array() += 1.0;
  ExpectError([&] { ImportMotion(tracks, options_); }, kBadData, {"capture.csv: point", "m off the mesh", "frame 1"});
}

TEST_F(ImportTest, PlacesMarkersOnTriangles) {
  const std::vector<int> faces = {0, 17, 40, 71, 97};
  const Eigen::Vector3d weights(0.2, 0.5, 0.3);
  PointTracks tracks = tracks_;
  tracks.times = Eigen::Vector2d(0, 1);
  tracks.positions.resize(15, 2);
  for (std::size_t m = 0; m < faces.size(); ++m) {
    const Eigen::Vector3d place = capture_.mesh.rest_positions(Eigen::all, capture_.mesh.faces.col(faces[m])) * weights;
    tracks.positions.middleRows<3>(3 * static_cast<Eigen::Index>(m)).colwise() = place + Eigen::Vector3d(0, 0, 0.01);
  }
  options_.handle_nodes.clear();
  options_.map = PointMapKind::kMarkers;
  MotionTensors motion = ImportMotion(tracks, options_);
  EXPECT_EQ(motion.face_index, faces);
  EXPECT_TRUE(motion.barycentric.isApprox(weights.replicate(1, 5), 1e-6)) << motion.barycentric;
  options_.handle_nodes = {0, 7};
  ExpectError([&] { ImportMotion(tracks, options_); }, kBadData, {"no point is measured at the handle 0"});
}

TEST_F(ImportTest, ReadsMapsOfPoints) {
  options_.handle_nodes.clear();
  options_.scene_path = folder_.Write("scene.json", kFromRest);  // a few points do not say where the cloth is
  options_.map = PointMapKind::kFile;
  const auto read = [&](const std::string& text) {
    options_.map_path = folder_.Write("map.csv", text);
    return ImportMotion(tracks_, options_);
  };
  MotionTensors motion = read("id,node\n5,60\r\n2,3\n");
  EXPECT_EQ(motion.node_index, (std::vector<int>{3, 60}));
  EXPECT_EQ(motion.positions.bottomRows(3), tracks_.positions.middleRows(15, 3));
  EXPECT_EQ(read("\"id\", node\n\"5\",\"60\"\n 2, 3\n").positions, motion.positions);
  motion = read("id,face,b0,b1,b2\n9,4,0.25,0.5,0.25\n");
  EXPECT_EQ(motion.face_index, std::vector<int>{4});
  EXPECT_EQ(motion.barycentric, Eigen::Vector3d(0.25, 0.5, 0.25));
  for (const auto& [text, fragment] : {std::pair{"", "header"},
                                       {"id,vertex\n", ":1"},
                                       {"id,node\n", "at least one row"},
                                       {"id,node\n1\n", ":2"},
                                       {"id,node\n\"1,1\n", ":2: expected quoted cells"},
                                       {"id,node\n64,1\n", ":2"},
                                       {"id,node\n1,64\n", "0 to 63"},
                                       {"id,node,face,b0,b1,b2\n1,1,1,1,0,0\n", ":1: expected a column 'node' or"},
                                       {"id,node\n1,1\n1,2\n", ":3"},
                                       {"id,face,b0,b1,b2\n1,2,0.5,0.5,0.5\n", "sum to 1"},
                                       {"id,face,b0,b1,b2\n1,98,1,0,0\n", "0 to 97"},
                                       {"id,face,b0,b1,b2\n1,2,1,nan,0\n", "finite"}}) {
    ExpectError([&, csv = text] { read(csv); }, kBadData, {"map.csv", fragment});
  }
  for (int p = 0; p < 64; ++p) tracks_.labels.push_back("m" + std::to_string(p));
  tracks_.labels[7] = "left, 7";
  EXPECT_EQ(read("id,node\n\"left, 7\",1\n").positions, tracks_.positions.middleRows(21, 3));
  ExpectError([&] { read("id,node\n7,1\n"); }, kBadData, {"map.csv:2", "label"});
}

TEST_F(ImportTest, TakesMeshAndHandlesFromAScene) {
  folder_.Write("path.csv", "time,x0,y0,z0\n0,1,2,3\n2,3,2,3\n");
  folder_.Write("ball.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
  options_.scene_path = folder_.Write("scene.json", R"({
    "clothid_scene": 1, "mesh": {"grid": {"nodes": [8, 8], "size": [0.28, 0.28]}},
    "handles": {"nodes": [7], "path": "path.csv"}, "obstacles": [{"type": "mesh", "obj": "ball.obj"}]})");
  options_.mesh.reset();
  options_.handle_nodes.clear();
  const MotionTensors motion = ImportMotion(tracks_, options_);
  EXPECT_TRUE(motion.mesh.rest_positions.isApprox(capture_.mesh.rest_positions, 1e-14));
  EXPECT_EQ(motion.handle_index, std::vector<int>{7});
  EXPECT_EQ(motion.handle_times, Eigen::Vector2d(0, 2));
  EXPECT_EQ(motion.handle_positions.row(0), Eigen::RowVector2d(1, 3));
  const nlohmann::json scene = nlohmann::json::parse(motion.scene_text);
  EXPECT_EQ(scene["handles"], nlohmann::json::array({7}));
  EXPECT_EQ(scene["obstacles"][0]["vertices"].size(), 4U);
  EXPECT_EQ(motion.scene_text.find(".obj"), std::string::npos);
  folder_.Write("path.csv", "time,x0,y0,z0\n100,1,2,3\n102,3,2,3\n");
  ExpectError([&] { ImportMotion(tracks_, options_); }, kBadData,
              {"scene.json: the path of its handles: is known from 100.000000 s to 102.000000 s", "one clock"});
}

TEST_F(ImportTest, RefusesWhatDoesNotFit) {
  ImportOptions options = options_;
  options.scene_path.clear();
  ExpectError([&] { ImportMotion(tracks_, options); }, kUsage, {"capture.csv", "scene"});
  options = options_;
  options.mesh.reset();
  ExpectError([&] { ImportMotion(tracks_, options); }, kUsage, {"scene.json", "mesh"});
  options = options_;
  options.handle_nodes = {0, 64};
  ExpectError([&] { ImportMotion(tracks_, options); }, kUsage, {"0 to 63"});
  options.handle_nodes = {0, 6};
  ExpectError([&] { ImportMotion(tracks_, options); }, kBadData, {"scene.json:1", "handles", "0, 6"});
  options = options_;
  options.mesh = MakePointGrid({8, 7}, {0.3, 0.3}, false);
  ExpectError([&] { ImportMotion(tracks_, options); }, kBadData, {"64 points", "56 nodes"});
  options = options_;
  options.sigma = -1.0;
  ExpectError([&] { ImportMotion(tracks_, options); }, kUsage, {"sigma"});
  options = options_;
  options.edit.first_frame = 60;
  ExpectError([&] { ImportMotion(tracks_, options); }, kUsage, {"60 frames"});
  options.edit.first_frame = 59;
  ExpectError([&] { ImportMotion(tracks_, options); }, kBadData, {"two frames"});
  options = options_;
  options.scene_path = folder_.Write("start.json", R"({"clothid_scene": 1, "initial": {"positions": "start.npy"}})");
  EXPECT_THROW(ImportMotion(tracks_, options), Error);
}

TEST_F(ImportTest, ConvertsARecording) {
  ImportOptions options;
  options.edit.scale = 2.0;
  options.edit.transform.translation() = Eigen::Vector3d(1, 0, 0);
  options.edit.first_frame = 10;
  options.edit.start_at = 0.0;
  const MotionTensors motion = ConvertMotion(capture_, "capture.bin", options);
  EXPECT_EQ(motion.times[0], 0.0);
  EXPECT_EQ(motion.positions.cols(), 50);
  EXPECT_EQ(motion.positions(0, 0), 2.0 * capture_.positions(0, 10) + 1.0);
  EXPECT_EQ(motion.handle_positions(3, 0), 2.0 * capture_.handle_positions(3, 10) + 1.0);
  EXPECT_EQ(motion.scene_text, capture_.scene_text);
  EXPECT_EQ(motion.sigma, capture_.sigma);
  options = {};
  capture_.scene_text = kFromRest;
  options.mesh = capture_.mesh;
  options.map = PointMapKind::kFile;
  options.map_path = folder_.Write("map.csv", "id,node\n3,3\n");
  EXPECT_EQ(ConvertMotion(capture_, "capture.bin", options).positions, capture_.positions.middleRows(9, 3));
}

TEST_F(ImportTest, MarksPointsThatAreNotMaterial) {
  ImportOptions options;
  options.surface.as_surface = true;
  EXPECT_EQ(ConvertMotion(capture_, "capture.bin", options).point_kind, std::vector<int>(64, 1));
  options.surface.borders = true;
  const std::vector<int> kinds = ConvertMotion(capture_, "capture.bin", options).point_kind;
  EXPECT_EQ(std::count(kinds.begin(), kinds.end(), 2), 28);
  EXPECT_EQ(kinds[9], 1);
  options.surface.corners = true;
  MotionTensors marked = ConvertMotion(capture_, "capture.bin", options);
  for (const int corner : {0, 7, 56, 63}) EXPECT_EQ(marked.point_kind[corner], 0);
  EXPECT_EQ(std::count(marked.point_kind.begin(), marked.point_kind.end(), 2), 24);
  // They stay, but where the points become others.
  EXPECT_EQ(ConvertMotion(marked, "marked.bin", {}).point_kind, marked.point_kind);
  options = {};
  options.mesh = marked.mesh;
  EXPECT_TRUE(ConvertMotion(marked, "marked.bin", options).point_kind.empty());
  options_.surface.as_surface = true;
  EXPECT_EQ(ImportMotion(tracks_, options_).point_kind, std::vector<int>(64, 1));
}

TEST_F(ImportTest, MarksMarkersOnBorders) {
  MotionTensors markers = capture_;
  const Eigen::Vector3i corners = markers.mesh.faces.col(0);  // two of them on the first row
  markers.positions.conservativeResize(9, Eigen::NoChange);
  markers.sigma.resize(0);
  markers.face_index = {0, 0, 0};
  markers.barycentric = Eigen::Matrix3Xd::Zero(3, 3);
  for (int k = 0, p = 1; k < 3; ++k) {
    const bool is_on_row = corners[k] < kCaptureColumns;
    if (is_on_row) markers.barycentric(k, 0) = 0.5;
    if (is_on_row && p == 1) markers.barycentric(k, p++) = 1.0;
  }
  markers.barycentric.col(2).setConstant(1.0 / 3.0);
  const std::vector<int> expected = {2, 2, 1};
  EXPECT_EQ(MarkSurfacePoints(markers, {true, true, false}, "markers.bin"), expected);
  markers.barycentric.leftCols(2) = markers.barycentric.rightCols(2).eval();
  markers.barycentric.setConstant(1.0 / 3.0);
  ExpectError(
      [&] {
        MarkSurfacePoints(markers, {true, true, false}, "markers.bin");
      },
      kBadData, {"markers.bin: no point is on a border"});
  ExpectError(
      [&] {
        MarkSurfacePoints(markers, {true, false, true}, "markers.bin");
      },
      kBadData, {"markers.bin: no point is at a corner"});
  ExpectError([&] { MarkSurfacePoints(markers, {false, true, false}, "markers.bin"); }, kUsage, {"as_surface"});
}

// A path with times of its own keeps all of them where frames are left out.
TEST_F(ImportTest, HandlesKeepTheirOwnTimes) {
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

TEST_F(ImportTest, HandsOutTracks) {
  const PointTracks tracks = ToTracks(capture_, "capture.bin");
  EXPECT_EQ(tracks.positions, capture_.positions);
  EXPECT_EQ(tracks.faces, capture_.mesh.faces);
  capture_.node_index.assign(64, 0);
  EXPECT_EQ(ToTracks(capture_, "capture.bin").faces.cols(), 0);
}

TEST(MakePointGrid, PutsNodesInTheOrderOfThePoints) {
  const Mesh along_x = MakePointGrid({3, 2}, {0.2, 0.1}, false), along_y = MakePointGrid({3, 2}, {0.2, 0.1}, true);
  for (const Mesh* mesh : {&along_x, &along_y}) {
    ValidateMesh(*mesh, "grid");
    EXPECT_NEAR(TriangleAreas(*mesh).sum(), 0.02, 1e-15);
    for (int face = 0; face < mesh->num_faces(); ++face) {
      const Eigen::Vector3d origin = mesh->rest_positions.col(mesh->faces(0, face));
      const Eigen::Vector3d normal = (mesh->rest_positions.col(mesh->faces(1, face)) - origin)
                                         .cross(mesh->rest_positions.col(mesh->faces(2, face)) - origin);
      EXPECT_GT(normal.z(), 0.0);
    }
  }
  EXPECT_TRUE(along_x.rest_positions.col(1).isApprox(Eigen::Vector3d(0.1, 0, 0)));
  EXPECT_TRUE(along_y.rest_positions.col(1).isApprox(Eigen::Vector3d(0, 0.1, 0)));
  EXPECT_TRUE(along_y.rest_positions.col(2).isApprox(Eigen::Vector3d(0.1, 0, 0)));
}

}  // namespace
}  // namespace clothid::import_motion_test
