#include "datasets/importing/import_motion.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>

#include "tests/datasets/importing/import_fixture.h"
#include "tests/expect_error.h"

namespace clothid::import_motion_test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr ErrorKind kBadData = ErrorKind::kBadData, kUsage = ErrorKind::kUsage;

constexpr char kFromRest[] = R"({"clothid_scene": 1, "initial": {"positions": "rest"}})";

class ImportTest : public ImportFixture {};

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
