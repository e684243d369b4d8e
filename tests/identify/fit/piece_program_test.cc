// Pieces of a cloth from the command line to the files: an OBJ file with groups, its recording, fit, landscape, export.
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "sim/mesh/mesh.h"
#include "sim/scene/material_field.h"
#include "tests/tools/small_drape.h"
#include "tests/tools/tool_test.h"

namespace clothid::piece_program_test {
namespace {

using Json = nlohmann::ordered_json;

// The mesh of `SmallDrape` with 6 x 6 nodes; its first half is a sleeve.
std::string ObjWithGroups() {
  GridOptions grid;
  grid.nodes = {6, 6};
  grid.size = {0.5, 0.5};
  grid.origin = Eigen::Vector3d(-0.25, 0.0, 0.0);
  grid.axes = {Eigen::Vector3d::UnitX(), Eigen::Vector3d(0.0, 0.906307787036650, -0.422618261740699)};
  const Mesh mesh = MakeGrid(grid);
  std::ostringstream text;
  text.precision(17);
  for (int i = 0; i < mesh.num_nodes(); ++i) text << "v " << mesh.rest_positions.col(i).transpose() << "\n";
  for (int f = 0; f < mesh.num_faces(); ++f) {
    if (f == 0) text << "g sleeve\n";
    if (2 * f == mesh.num_faces()) text << "g body\n";
    text << "f " << (mesh.faces.col(f).array() + 1).transpose() << "\n";
  }
  return text.str();
}

class PieceProgramTest : public ToolTest {
 protected:
  PieceProgramTest() {
    WriteBytes(folder() / "cloth.obj", ObjWithGroups());
    scene_ = Json::parse(SmallDrape(6));
    scene_["mesh"] = {{"obj", "cloth.obj"}};
    scene_["pieces"] = {{"sleeve", {{"k_stretch", 150}}}, {"body", Json::object()}};
    scene_["parameters"] = {{"k_stretch.body", {{"prior", {{"median", 80}, {"factor", 3}}}}}};
    WriteScene(scene_);
  }

  Json scene_;
};

TEST_F(PieceProgramTest, GoFromTheMeshToTheResult) {
  ExpectSuccess("simulate --scene scene.json --set k_stretch.body=60 --noise 0.0005 --output cloth.bin");
  std::filesystem::remove(folder() / "cloth.obj");  // a recording stands on its own
  const ToolResult info = Run("motion info cloth.bin");
  EXPECT_NE(info.out.find("\n  k_stretch.sleeve 150 N/m\n"), std::string::npos) << info.out;
  const ToolResult fit =
      Run("identify --target cloth.bin --fit k_stretch.sleeve,k_stretch.body --upper k_stretch.sleeve=5000 "
          "--prior k_stretch.sleeve=140:2 --export mujoco,newton --output result");
  EXPECT_EQ(fit.exit_code, 0) << fit.err << fit.out;
  for (const char* row : {"\nk_stretch.sleeve 1", "\nk_stretch.body ", "k_stretch.body 80, factor 3"}) {
    EXPECT_NE(fit.out.find(row), std::string::npos) << row << fit.out;
  }
  const Json parameters = Json::parse(ReadBytes(folder() / "result" / "result.json"))["parameters"];
  for (const auto& [name, truth] :
       std::map<std::string, double>{{"k_stretch.sleeve", 150.0}, {"k_stretch.body", 60.0}}) {
    EXPECT_LE(parameters[name]["lower95"].get<double>(), truth) << name;
    EXPECT_GE(parameters[name]["upper95"].get<double>(), truth) << name;
  }
  EXPECT_EQ(parameters["k_stretch.sleeve"]["prior"]["median"], 140.0);
  EXPECT_EQ(parameters["k_stretch.body"]["prior"]["factor"], 3.0);
  EXPECT_NE(ReadBytes(folder() / "result" / "export_newton.py").find("pieces: the means of their constants"),
            std::string::npos);
  ExpectSuccess("motion check result/predicted.bin");

  const ToolResult scan =
      Run("landscape --target cloth.bin --x k_stretch.sleeve=100:200:3 --y k_stretch.body=40:80:3 "
          "--set k_stretch.sleeve=150,k_stretch.body=60 --output map");
  EXPECT_EQ(scan.exit_code, 0) << scan.err;
  const Json axes = Json::parse(ReadBytes(folder() / "map" / "plan.json"))["axes"];
  EXPECT_EQ(axes["x"]["parameter"], "k_stretch.sleeve");
  EXPECT_EQ(axes["y"]["parameter"], "k_stretch.body");
}

TEST_F(PieceProgramTest, WrongNamesAreOneLineEach) {
  ExpectSuccess("simulate --scene scene.json --output cloth.bin");
  ExpectRefused("identify --target cloth.bin --fit k_stretch.cuff --output r", 1, "unknown parameter 'k_stretch.cuff'");
  ExpectRefused("identify --target cloth.bin --fit k_warp.sleeve --output r", 1, "the scene has no such term");
  ExpectRefused("identify --target cloth.bin --fit k_stretch,k_stretch.sleeve --output r", 1,
                "'k_stretch' sets that of every piece");
  ExpectRefused("identify --target cloth.bin --fit k_stretch --field k_stretch:2x2 --output r", 1,
                "--field: 'k_stretch' differs between the pieces");
  WriteBytes(folder() / "field.npy", FieldValuesNpy(Eigen::MatrixXd::Constant(2, 2, 50.0)));
  ExpectRefused("simulate --scene scene.json --set_field k_stretch=field.npy --output x.bin", 1,
                "--set_field: 'k_stretch' differs between the pieces");
  ExpectRefused("simulate --scene scene.json --set k_stretch.cuff=3 --output x.bin", 1, "k_stretch.cuff");
  ExpectRefused("landscape --target cloth.bin --x k_stretch=100:200:3 --y k_stretch.body=40:80:3 --output m", 1,
                "include each other");
  scene_["pieces"]["cuff"] = Json::object();
  WriteScene(scene_, "cuff.json");
  ExpectRefused("simulate --scene cuff.json --output x.bin", 2,
                "key 'pieces.cuff': the mesh has no such group; expected one of body, sleeve");
}

}  // namespace
}  // namespace clothid::piece_program_test
