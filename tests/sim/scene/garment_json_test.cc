// Scenes of cloth whose rest shape is a UV map, and of seams and buttons.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "sim/scene/scene_json.h"
#include "tests/expect_error.h"
#include "tests/sim/garments.h"
#include "tests/sim/plain_scenes.h"
#include "tests/temporary_folder.h"

namespace clothid::garment_json_test {
namespace {

using Json = nlohmann::json;

// The two halves of a square, in a map of 0.5 m per unit.
class GarmentJsonTest : public ::testing::Test {
 protected:
  GarmentJsonTest()
      : cut_(Cut(WithUvRest(MakeGrid(SquareGrid(5, 0.4))), GridLine(5, 5, true, 2),
                 [](const Eigen::Vector3d& x) { return x.x() > 0.2; })) {
    Mesh file = cut_.mesh;
    file.corner_rest *= 2.0;
    WriteObj(ObjText(file));
    mesh_ = {{"obj", "cloth.obj"}, {"rest", "uv"}, {"uv_scale", 0.5}};
    seam_ = {{"a", cut_.seam}, {"b", cut_.beyond}};
  }

  void WriteObj(const std::string& text) { folder_.Write("cloth.obj", text); }

  std::string Text() const {
    return Json{{"clothid_scene", 2}, {"duration", 0.1}, {"mesh", mesh_}, {"materials", materials_}}.dump(1);
  }
  Scene Parse(const SceneDefaults& defaults = {}) const {
    return ParseScene(Text(), "scene.json", folder_.path(), defaults);
  }
  void ExpectBad(std::initializer_list<const char*> fragments) const {
    ExpectError([&] { Parse(); }, ErrorKind::kBadData, fragments);
  }

  TemporaryFolder folder_;
  CutMesh cut_;
  Json mesh_, seam_, materials_ = Json::object();
};

TEST_F(GarmentJsonTest, TakesTheMapAsTheRestShape) {
  const Scene scene = Parse();
  EXPECT_EQ(scene.mesh.corner_rest, cut_.mesh.corner_rest);
  EXPECT_EQ(scene.mesh.rest_positions, cut_.mesh.rest_positions);
  EXPECT_EQ(scene.initial_positions, cut_.mesh.rest_positions.reshaped());
  mesh_["uv_scale"] = 0.75;
  EXPECT_EQ(Parse().mesh.corner_rest, 1.5 * cut_.mesh.corner_rest);
}

TEST_F(GarmentJsonTest, JoinsDrawsAndButtons) {
  mesh_["seams"] = {seam_};
  EXPECT_EQ(Parse().mesh.num_nodes(), 25);
  EXPECT_TRUE(Parse().mesh.folds.empty());
  mesh_["seams"][0]["fold"] = true;
  EXPECT_EQ(Parse().mesh.folds.size(), 4u);
  mesh_["seams"][0] = seam_;
  mesh_["seams"][0]["closes"] = 0.3;
  mesh_["seams"][0]["stiffness"] = 2000;
  mesh_["buttons"] = {{0, 20}};
  const Mesh drawn = Parse().mesh;
  EXPECT_EQ(drawn.num_nodes(), 30);
  ASSERT_EQ(drawn.links.size(), 6u);
  EXPECT_EQ(drawn.links[0].closing_time, 0.3);
  EXPECT_NEAR(drawn.links[1].stiffness, 2000 * 0.1, 1e-12);
  EXPECT_EQ(drawn.links[5].edge[0], 20);
  mesh_["seams"][0].erase("closes");
  ExpectBad({"mesh.seams[0].stiffness", "expected \"closes\" beside it"});
}

// Drawn seams need no map.
TEST_F(GarmentJsonTest, DrawsAGrid) {
  mesh_ = {{"grid", {{"nodes", {4, 3}}, {"size", {0.3, 0.2}}}},
           {"seams", {{{"a", {0, 4, 8}}, {"b", {3, 7, 11}}, {"closes", 1}}}}};
  EXPECT_EQ(Parse().mesh.links.size(), 3u);
  mesh_["seams"][0].erase("closes");
  ExpectBad({"key 'mesh.seams[0]': expected \"rest\": \"uv\" of the mesh, or \"closes\""});
  mesh_.erase("seams");
  mesh_["rest"] = "uv";
  ExpectBad({"key 'mesh.rest': expected a mesh from an OBJ file beside it"});
}

TEST_F(GarmentJsonTest, TheWarpIsAlongU) {
  for (const int f : cut_.faces) {  // the piece beyond is a quarter turn further in the map
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector2d place = 2.0 * cut_.mesh.corner_rest.col(3 * f + k);
      cut_.mesh.corner_rest.col(3 * f + k) << 5.0 - 0.5 * place.y(), 0.5 * place.x();
    }
  }
  WriteObj(ObjText(cut_.mesh));
  mesh_["uv_scale"] = 1;
  materials_ = {{"membrane", "orthotropic"}, {"k_warp", 100}, {"k_weft", 50}, {"k_shear", 10}};
  const Scene scene = Parse();
  EXPECT_EQ(WarpDirections(scene.warp, scene.mesh), Eigen::Vector3d::UnitX().replicate(1, scene.mesh.num_faces()));
  materials_["warp_direction"] = "uv";
  EXPECT_EQ(WarpDirections(Parse().warp, scene.mesh), WarpDirections(scene.warp, scene.mesh));
  EXPECT_EQ(Parse().warp.directions.cols(), 0);
}

// A recording brings its mesh: with the places of corners, or without, if the file has its triangles.
TEST_F(GarmentJsonTest, TakesTheMeshOfARecording) {
  mesh_["seams"] = {seam_};
  SceneDefaults defaults;
  defaults.has_mesh = true;
  defaults.duration = 0.1;
  defaults.mesh = Parse().mesh;
  defaults.mesh.rest_positions.row(2).setConstant(0.1);
  defaults.initial_positions = defaults.mesh.rest_positions.reshaped();
  const Mesh with = Parse(defaults).mesh;
  EXPECT_EQ(with.corner_rest, defaults.mesh.corner_rest);
  EXPECT_EQ(with.rest_positions, defaults.mesh.rest_positions);
  defaults.mesh.corner_rest.resize(2, 0);
  EXPECT_EQ(Parse(defaults).mesh.corner_rest, with.corner_rest);
  EXPECT_EQ(Parse(defaults).mesh.rest_positions, with.rest_positions);
  defaults.mesh = MakeGrid(SquareGrid(5, 0.3));
  defaults.mesh.faces.col(0).swap(defaults.mesh.faces.col(1));
  ExpectError([&] { Parse(defaults); }, ErrorKind::kBadData, {"mesh.obj", "expected the triangles of the recording"});
}

TEST_F(GarmentJsonTest, NamesKeyOrLineOfWhatIsBad) {
  mesh_["rest"] = "flat";
  ExpectBad({"scene.json:", "key 'mesh.rest': expected \"uv\""});
  mesh_.erase("rest");
  ExpectBad({"key 'mesh.uv_scale': expected \"rest\": \"uv\" beside it"});
  mesh_ = {{"obj", "cloth.obj"}, {"rest", "uv"}, {"uv_scale", 0}};
  ExpectBad({"key 'mesh.uv_scale': expected a number > 0"});
  mesh_.erase("uv_scale");
  WriteObj("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  ExpectBad(
      {"cloth.obj:4: face corner '1' of triangle 0 has no texture coordinates, which are to be its shape at rest"});
  WriteObj("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 1\nvt 2 2\nf 1/1 2/2 3/3\n");
  ExpectBad(
      {"cloth.obj:7: triangle 0 has no area in the UV map, its shape at rest: its texture coordinates lie on a line"});
  WriteObj("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0.9 0.2\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n");
  ExpectBad(
      {"cloth.obj:", ": triangle 0 and triangle 1 lie on each other in the UV map, which is folded along their edge 0-2"});
  WriteObj(
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 2 2\nvt 3.2 2\nvt 2 3.2\nf 1/1 2/2 3/3\nf 1/4 "
      "3/5 4/6\n");
  ExpectBad({"cloth.obj: edge 0-2 is 1.41421 m long on one side in the UV map and 1.2 m on the other, in triangle 1"});
  mesh_["ease"] = true;
  EXPECT_NO_THROW(Parse());
}

TEST_F(GarmentJsonTest, NamesTheSeamThatIsBad) {
  mesh_ = {{"obj", "cloth.obj"}, {"rest", "uv"}, {"uv_scale", 0.05}};
  ExpectBad({"key 'mesh.obj': expected a UV map as large as the surface, which is 10 times its size",
             "is \"uv_scale\": 0.5"});
  mesh_["uv_scale"] = 0.5;
  mesh_["seams"] = {{{"a", {0, 1, 6}}, {"b", {4, 3, 2}}}};
  ExpectBad({"scene.json:", "key 'mesh.seams[0]': node 6 of a is not on the border of the mesh"});
  mesh_["seams"] = {seam_, seam_};
  ExpectBad({"key 'mesh.seams[1]': nodes 2 and 7 of a are sewn already"});
  mesh_["seams"] = {{{"a", {2, 7, 12}}, {"b", {25, 26}}}};
  ExpectBad({"key 'mesh.seams[0]': a is 0.2 m long at rest and b 0.1 m"});
  mesh_["seams"] = {{{"a", {2}}}};
  ExpectBad({"key 'mesh.seams[0].b': is missing", "a list of nodes along the border"});
  mesh_.erase("seams");
  mesh_["buttons"] = {{0, 0}};
  ExpectBad({"key 'mesh.buttons[0]': nodes 0 and 0 are the same"});
}

// What needs one place at rest of a node says so.
TEST_F(GarmentJsonTest, HasNoField) {
  Json json = Json::parse(Text());
  json["fields"] = {{"k_stretch", {{60, 80}}}};
  ExpectError([&] { ParseScene(json.dump(), "scene.json", folder_.path()); }, ErrorKind::kBadData,
              {"expected a cloth without \"rest\": \"uv\""});
}

}  // namespace
}  // namespace clothid::garment_json_test
