// What nodes or places on triangles points are.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "tests/datasets/importing/import_fixture.h"
#include "tests/expect_error.h"

namespace clothid::point_map_test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr ErrorKind kBadData = ErrorKind::kBadData;

constexpr char kFromRest[] = R"({"clothid_scene": 1, "initial": {"positions": "rest"}})";

class PointMapTest : public ImportFixture {};

// The points in another order, a little off and turned.
TEST_F(PointMapTest, FindsTheNearestNodes) {
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

TEST_F(PointMapTest, PlacesMarkersOnTriangles) {
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

TEST_F(PointMapTest, ReadsMapsOfPoints) {
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

}  // namespace
}  // namespace clothid::point_map_test
