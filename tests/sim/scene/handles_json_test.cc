// The handles of a scene text: groups, what takes them along, and clamps.
#include "sim/scene/handles_json.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <string>
#include <vector>

#include "sim/scene/scene_json.h"
#include "tests/expect_error.h"
#include "tests/temporary_folder.h"

namespace clothid::handles_json_test {
namespace {

// Rows along x from y = 0: 0 1 2, 3 4 5, 6 7 8.
std::string SceneWith(const std::string& handles, const std::string& more = "") {
  return "{\"clothid_scene\": 2, \"duration\": 0.1, \"time_step\": 0.01, "
         "\"mesh\": {\"grid\": {\"nodes\": [3, 3], \"size\": [0.2, 0.2]}}" +
         more + ",\n\"handles\": " + handles + "}";
}

constexpr char kArm[] =
    ", \"obstacles\": [{\"name\": \"arm\", \"type\": \"sphere\", \"center\": [0, 0, 9], \"radius\": 0.1, "
    "\"path\": [[0, 0, 0, 0, 0, 0, 0, 1], [0.1, 0, 0, 0, 0.1, 0, 0, 0.995]]}]";

TEST(HandlesJsonTest, GroupsHaveTheirOwnWays) {
  TemporaryFolder folder;
  folder.Write("path.csv", "time,x0,y0,z0\n0,0.2,0.2,0\n0.1,0.3,0.2,0\n");
  folder.Write("poses.csv", "time,x,y,z,qx,qy,qz,qw\n0,0,0,0,0,0,0,1\n0.1,0,0,0.1,0,0,0,1\n");
  const std::string path = folder.Write(
      "scene.json", SceneWith("[{\"nodes\": [0, 1], \"clamp\": true, \"poses\": \"poses.csv\"}, {\"nodes\": [6]},"
                              " {\"nodes\": [8], \"path\": \"path.csv\"}]"));
  const Scene scene = ReadScene(path);
  EXPECT_EQ(scene.handles.nodes, (std::vector<int>{0, 1, 6, 8}));
  const Eigen::VectorXd end = scene.handles.path.At(0.1), start = scene.handles.path.At(0.0);
  EXPECT_NEAR(end[2] - start[2], 0.1, 1e-12);  // 0 goes up
  EXPECT_EQ(end.segment<3>(6), start.segment<3>(6));
  EXPECT_NEAR(end[9], 0.3, 1e-12);
  ASSERT_EQ(scene.handles.clamped.size(), 1u);
  EXPECT_EQ(scene.handles.clamped[0].nodes, (std::array<int, 2>{0, 1}));
  EXPECT_LE((scene.handles.slopes.At(0.05) - Eigen::Vector3d::UnitY()).norm(), 1e-12);
  EXPECT_EQ(FilesOfScene(path).size(), 3u);
}

TEST(HandlesJsonTest, AClampTurnsWithTheObstacleThatTakesItAlong) {
  const Scene scene =
      ParseScene(SceneWith("{\"nodes\": [0, 1, 2], \"attach\": \"arm\", \"clamp\": true}", kArm), "s", "");
  ASSERT_EQ(scene.handles.clamped.size(), 2u);
  const double angle = 2.0 * std::atan2(0.1, 0.995);
  EXPECT_LE((scene.handles.slopes.At(0.1).head<3>() - Eigen::Vector3d(0.0, std::cos(angle), std::sin(angle))).norm(),
            1e-9);
}

TEST(HandlesJsonTest, AClampMayHaveADirection) {
  const Scene scene = ParseScene(SceneWith("{\"nodes\": [0, 1, 2], \"clamp\": [3, 0, 2]}"), "s", "");
  EXPECT_LE((scene.handles.slopes.At(0.0).head<3>() - Eigen::Vector3d::UnitZ()).norm(), 1e-12);
  EXPECT_EQ(scene.handles.slopes.times().size(), 1);
}

TEST(HandlesJsonTest, SaysWhatIsWrong) {
  const auto expect = [](const std::string& handles, std::initializer_list<const char*> fragments) {
    ExpectError([&] { ParseScene(SceneWith(handles, kArm), "scene.json", ""); }, ErrorKind::kBadData, fragments);
  };
  expect("[{\"nodes\": [0, 1]}, {\"nodes\": [1, 2]}]",
         {"scene.json:2: key 'handles[1].nodes[0]': node 1 is listed twice"});
  expect("[{\"nodes\": [0]}, 3]", {"key 'handles[1]': expected"});
  expect("[3, {\"nodes\": [0]}]", {"key 'handles[1]': expected an integer"});
  expect("{\"nodes\": [0, 1], \"attach\": \"arm\", \"poses\": \"p.csv\"}",
         {"key 'handles': expected one of \"path\", \"poses\" and \"attach\""});
  expect("{\"nodes\": [0, 1], \"attach\": \"leg\"}",
         {"key 'handles.attach': expected the name of an obstacle that has a path"});
  expect("{\"nodes\": [0], \"clamp\": true}", {"key 'handles.clamp': expected two nodes or more that an edge"});
  expect("{\"nodes\": [0, 8], \"clamp\": true}", {"key 'handles.clamp': expected two nodes or more that an edge"});
  expect("{\"nodes\": [0, 1], \"clamp\": [2, 0, 0]}",
         {"key 'handles.clamp': expected a direction that leaves the row"});
  expect("{\"nodes\": [0, 1], \"clamp\": [0, 0, 0]}", {"key 'handles.clamp': expected true, or the direction"});
  expect("{\"nodes\": [0, 1], \"clamp\": 1}", {"key 'handles.clamp': expected true, or the direction"});
  expect("{\"nodes\": [0, 1], \"clamp\": [0, 1]}", {"key 'handles.clamp'"});
  expect("{\"nodes\": [0, 1], \"poses\": [[0, 0, 0, 0, 0, 0, 0, 0]]}", {"key 'handles.poses'"});
}

}  // namespace
}  // namespace clothid::handles_json_test
