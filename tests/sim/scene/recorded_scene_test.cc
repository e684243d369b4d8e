// Scenes inside recordings, which bring mesh, start, clock and handles.
#include <gtest/gtest.h>

#include "sim/scene/scene_json.h"
#include "tests/expect_error.h"

namespace clothid::recorded_scene_test {
namespace {

SceneDefaults Recording() {
  SceneDefaults defaults;
  GridOptions grid;
  grid.nodes = {3, 3};
  defaults.has_mesh = true;
  defaults.mesh = MakeGrid(grid);
  defaults.initial_positions = defaults.mesh.rest_positions.reshaped().array() + 1.0;
  defaults.start_time = 5.0;
  defaults.duration = 0.5;
  defaults.handles.nodes = {0, 6};
  defaults.handles.path = HandlePath(Eigen::Vector2d(5.0, 5.5), Eigen::MatrixXd::Constant(6, 2, 3.0));
  return defaults;
}

TEST(ParseScene, TakesWhatARecordingBrings) {
  const SceneDefaults defaults = Recording();
  const Scene scene = ParseScene("{\"clothid_scene\": 1, \"handles\": [6, 0]}", "motion.bin: scene", "", defaults);
  EXPECT_EQ(scene.start_time, 5.0);
  EXPECT_EQ(scene.duration, 0.5);
  EXPECT_EQ(scene.handles.nodes, (std::vector<int>{0, 6}));
  EXPECT_EQ(scene.initial_positions.segment<3>(0), Eigen::Vector3d::Constant(3.0));
  EXPECT_EQ(scene.initial_positions.segment<3>(3), defaults.initial_positions.segment<3>(3));
}

TEST(ParseScene, StartOfTheTextWinsOverTheRecording) {
  const SceneDefaults defaults = Recording();
  const Scene scene =
      ParseScene(R"({"clothid_scene": 1, "duration": 7, "initial": {"positions": "rest"}})", "s", "", defaults);
  EXPECT_EQ(scene.duration, 0.5);
  EXPECT_EQ(scene.initial_positions.segment<3>(3), defaults.mesh.rest_positions.col(1));
}

TEST(ParseScene, NamesWhatContradictsTheRecording) {
  SceneDefaults defaults = Recording();
  const auto expect = [&](const std::string& members, std::initializer_list<const char*> fragments) {
    const std::string text = "{\"clothid_scene\": 1" + members + "}";
    ExpectError([&] { ParseScene(text, "motion.bin: scene", "", defaults); }, ErrorKind::kBadData, fragments);
  };
  expect(", \"handles\": [0, 7]", {"motion.bin: scene:1: key 'handles': expected the handles of the recording: 0, 6"});
  expect(", \"mesh\": {\"grid\": {\"nodes\": [3, 4], \"size\": [1, 1]}}",
         {"key 'mesh.grid'", "9 nodes of the recording, found 12"});
  defaults.initial_positions.resize(0);
  expect("", {"key 'initial.positions': is missing", "too few points"});
}

}  // namespace
}  // namespace clothid::recorded_scene_test
