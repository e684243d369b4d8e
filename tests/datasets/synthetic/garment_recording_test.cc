// Recordings of cloth that is sewn of the pieces of a UV map need no file to be simulated again.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "datasets/importing/import_motion.h"
#include "datasets/motion/motion_file.h"
#include "datasets/synthetic/synthetic.h"
#include "sim/rollout/simulator.h"
#include "sim/scene/scene_json.h"
#include "tests/expect_error.h"
#include "tests/sim/garments.h"
#include "tests/sim/plain_scenes.h"
#include "tests/temporary_folder.h"

namespace clothid::garment_recording_test {
namespace {

using Json = nlohmann::json;

// A sleeve of a panel whose border rings are half closed, drawn and buttoned.
class GarmentRecordingTest : public ::testing::Test {
 protected:
  GarmentRecordingTest() {
    const CutMesh panel = SleevePanel(9, 4, 0.4, 0.15);
    obj_ = folder_.Write("cloth.obj", ObjText(panel.mesh));
    Json json = {{"clothid_scene", 2}, {"time_step", 0.01}, {"duration", 0.1}, {"handles", {0, 4}}};
    json["materials"] = {{"membrane", "orthotropic"}, {"k_bend", 1e-5}, {"k_warp", 60}, {"k_weft", 30}, {"k_shear", 9},
                         {"warp_direction", "uv"}};
    json["mesh"] = {{"obj", "cloth.obj"}, {"rest", "uv"}};
    json["mesh"]["seams"].push_back({{"a", panel.seam}, {"b", panel.beyond}, {"fold", true}});
    json["mesh"]["seams"].push_back({{"a", {0, 1, 2}}, {"b", {8, 7, 6}}, {"closes", 0.05}});
    json["mesh"]["buttons"].push_back({27, 31});
    text_ = json.dump();
  }

  Scene scene() const { return ParseScene(text_, "scene.json", folder_.path()); }

  TemporaryFolder folder_;
  std::string obj_, text_;
};

void ExpectSameMesh(const Mesh& mesh, const Mesh& other) {
  EXPECT_EQ(mesh.rest_positions, other.rest_positions);
  EXPECT_EQ(mesh.faces, other.faces);
  EXPECT_EQ(mesh.corner_rest, other.corner_rest);
  EXPECT_EQ(mesh.folds, other.folds);
  ASSERT_EQ(mesh.links.size(), other.links.size());
  for (std::size_t i = 0; i < mesh.links.size(); ++i) {
    const SeamLink &a = mesh.links[i], &b = other.links[i];
    EXPECT_EQ(a.node, b.node);
    EXPECT_EQ(a.edge, b.edge);
    EXPECT_EQ(a.share, b.share);
    EXPECT_EQ(a.stiffness, b.stiffness);
    EXPECT_EQ(a.closing_time, b.closing_time);
  }
}

TEST_F(GarmentRecordingTest, SimulatesToTheSameBits) {
  const Scene original = scene();
  ASSERT_EQ(original.mesh.folds.size(), 3u);
  ASSERT_EQ(original.mesh.links.size(), 3u);
  Simulator simulator(original);
  const Rollout rollout = Simulate(original.nominal_parameters(), original.num_steps(), &simulator);
  ASSERT_TRUE(rollout.ok());
  const std::string path = folder_.File("motion.bin");
  WriteMotion(RecordRollout(rollout, original, text_, {}), path);
  ReadMotionOptions with_scene;
  with_scene.scene_path = folder_.Write("scene.json", text_);
  ExpectSameMesh(ReadMotion(path, with_scene).scene.mesh, original.mesh);
  std::filesystem::remove(obj_);
  const RecordedMotion motion = ReadMotion(path);
  EXPECT_EQ(motion.scene_text.find("cloth.obj"), std::string::npos);
  ExpectSameMesh(motion.scene.mesh, original.mesh);
  Simulator again(motion.scene);
  const Rollout recorded = Simulate(motion.scene.nominal_parameters(), motion.scene.num_steps(), &again);
  ASSERT_EQ(recorded.num_steps(), rollout.num_steps());
  for (int step = 0; step <= rollout.num_steps(); ++step) {
    EXPECT_EQ(recorded.positions(step), rollout.positions(step)) << step;
  }
}

// Positions that came from elsewhere get the mesh of the scene, or one with its triangles gets its rest shape.
TEST_F(GarmentRecordingTest, IsMadeOfImportedPositions) {
  const Scene original = scene();
  PointTracks tracks;
  tracks.name = "points";
  tracks.times = Eigen::Vector2d(0.0, 0.1);
  tracks.positions = original.initial_positions.replicate(1, 2);
  ImportOptions options;
  options.scene_path = folder_.Write("scene.json", text_);
  ExpectSameMesh(ImportMotion(tracks, options).mesh, original.mesh);
  options.mesh = original.mesh;
  options.mesh->corner_rest.resize(2, 0);
  options.mesh->folds.clear();
  options.mesh->links.clear();
  ExpectSameMesh(ImportMotion(tracks, options).mesh, original.mesh);
}

TEST_F(GarmentRecordingTest, ReadsNoPlaceOfAnotherMesh) {
  const Scene original = scene();
  MotionTensors tensors;
  tensors.mesh = original.mesh;
  tensors.times = Eigen::Vector2d(0.0, 0.1);
  tensors.positions = original.initial_positions.replicate(1, 2);
  tensors.scene_text = R"({"clothid_scene": 2})";
  tensors.mesh.corner_rest.conservativeResize(2, 6);
  ExpectError([&] { WriteMotion(tensors, folder_.File("bad.bin")); }, ErrorKind::kBadData,
              {"bad.bin", "expected a place in the UV map for each of the"});
  tensors.mesh.corner_rest = original.mesh.corner_rest;
  tensors.mesh.links[0].edge[1] = 99;
  ExpectError([&] { WriteMotion(tensors, folder_.File("bad.bin")); }, ErrorKind::kBadData,
              {"bad.bin", "link 0 of a seam: expected two other nodes"});
  tensors.mesh.links.clear();
  tensors.mesh.folds[0] = {0, 20};
  ExpectError([&] { WriteMotion(tensors, folder_.File("bad.bin")); }, ErrorKind::kBadData,
              {"bad.bin", "fold 0-20 is no edge of two triangles"});
}

}  // namespace
}  // namespace clothid::garment_recording_test
