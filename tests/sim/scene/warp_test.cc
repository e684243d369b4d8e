// The warp by the UV map of a mesh and by a direction per triangle.
#include "sim/scene/warp.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iomanip>
#include <sstream>
#include <string>

#include "sim/rollout/rollout.h"
#include "sim/rollout/simulator.h"
#include "sim/scene/refinement.h"
#include "sim/scene/scene_json.h"
#include "tests/expect_error.h"
#include "tests/npy_bytes.h"
#include "tests/temporary_folder.h"

namespace clothid::warp_test {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kAngle = 35.0;  // degrees
constexpr char kGrid[] = R"({"grid": {"nodes": [5, 4], "size": [0.2, 0.15]}})";
constexpr char kObj[] = R"({"obj": "cloth.obj"})";

// A woven sheet held by one edge, in which warp and weft differ as much as shear does from both.
std::string Text(const std::string& mesh, const std::string& warp) {
  return R"({"clothid_scene": 2, "time_step": 0.01, "duration": 0.1, "handles": [0, 1, 2, 3, 4], "mesh": )" + mesh +
         R"(,
"materials": {"membrane": "orthotropic", "k_warp": 200, "k_weft": 50, "k_shear": 10, )" +
         warp + R"( "bend_warp": 2e-4, "bend_weft": 5e-5, "bend_twist": 3e-5}})";
}

std::string Angle(double degrees) { return "\"warp_angle\": " + std::to_string(degrees) + ","; }
std::string Direction(const std::string& json) { return "\"warp_direction\": " + json + ","; }

class WarpOfTheMeshTest : public ::testing::Test {
 protected:
  Scene Read(const std::string& mesh, const std::string& warp) const {
    return ParseScene(Text(mesh, warp), "scene.json", folder_.path());
  }

  // The grid as a file whose UV map is turned by `degrees`, with u along the warp.
  void WriteObj(double degrees) const {
    const Mesh mesh = Read(kGrid, "").mesh;
    const double c = std::cos(degrees * kPi / 180.0), s = std::sin(degrees * kPi / 180.0);
    std::ostringstream obj;
    obj << std::setprecision(17);
    for (const auto& x : mesh.rest_positions.colwise()) {
      obj << "v " << x.transpose() << "\nvt " << 3.0 * (c * x[0] + s * x[1]) + 1.0 << " " << 3.0 * (c * x[1] - s * x[0])
          << "\n";
    }
    for (const auto& face : mesh.faces.colwise()) {
      obj << "f";
      for (const int node : face) obj << " " << node + 1 << "/" << node + 1;
      obj << "\n";
    }
    folder_.Write("cloth.obj", obj.str());
  }

  void ExpectBad(const std::string& mesh, const std::string& warp, const std::string& fragment) const {
    ExpectError([&] { Read(mesh, warp); }, ErrorKind::kBadData, {"scene.json", fragment.c_str()});
  }

  const TemporaryFolder folder_;
};

Eigen::VectorXd EndOf(const Scene& scene) {
  Simulator simulator(scene);
  const Rollout rollout = Simulate(scene.nominal_parameters(), scene.num_steps(), &simulator);
  EXPECT_TRUE(rollout.ok());
  return rollout.positions(rollout.num_steps());
}

TEST_F(WarpOfTheMeshTest, ATurnedUvMapIsATurnedWarp) {
  WriteObj(kAngle);
  const Scene by_map = Read(kObj, Direction("\"uv\"")), by_angle = Read(kGrid, Angle(kAngle));
  const Eigen::Matrix3Xd expected = WarpDirections(by_angle.warp, by_angle.mesh);
  EXPECT_LT((WarpDirections(by_map.warp, by_map.mesh) - expected).norm(), 1e-13);
  const Eigen::VectorXd end = EndOf(by_angle);
  EXPECT_LT((EndOf(by_map) - end).norm(), 1e-9);
  EXPECT_GT((EndOf(Read(kGrid, "")) - end).norm(), 1e-3) << "the angle matters";
  // An angle turns it further.
  const Scene further = Read(kObj, Direction("\"uv\"") + Angle(10.0)), both = Read(kGrid, Angle(kAngle + 10.0));
  EXPECT_LT((WarpDirections(further.warp, further.mesh) - WarpDirections(both.warp, both.mesh)).norm(), 1e-13);
}

TEST_F(WarpOfTheMeshTest, EveryTriangleMayHaveItsOwn) {
  const Mesh mesh = Read(kGrid, "").mesh;
  Eigen::Matrix3Xd directions(3, mesh.num_faces());
  std::string list;
  for (int face = 0; face < mesh.num_faces(); ++face) {
    directions.col(face) << std::cos(0.1 * face), std::sin(0.1 * face),
        0.3;  // the part across the cloth is not counted
    std::ostringstream item;
    item << std::setprecision(17) << (face == 0 ? "[" : ", [") << directions(0, face) << ", " << directions(1, face)
         << ", 0.3]";
    list += item.str();
  }
  folder_.Write("warp.npy", NpyBytes(directions));
  const Scene by_list = Read(kGrid, Direction("[" + list + "]")), by_file = Read(kGrid, Direction("\"warp.npy\""));
  EXPECT_EQ(by_list.warp.directions, directions);
  EXPECT_EQ(by_file.warp.directions, directions);
  const Eigen::Matrix3Xd warp = WarpDirections(by_list.warp, mesh);
  EXPECT_NEAR(warp(1, 7), std::sin(0.7), 1e-15);
  // On the finer mesh four triangles have the direction of the one that they were.
  const Scene fine = RefineScene(by_list, RefineMesh(mesh));
  EXPECT_NO_THROW(ValidateScene(fine, "fine"));
  const Eigen::Matrix3Xd fine_warp = WarpDirections(fine.warp, fine.mesh);
  ASSERT_EQ(fine_warp.cols(), 4 * warp.cols());
  for (int face = 0; face < fine.mesh.num_faces(); ++face) {
    EXPECT_LT((fine_warp.col(face) - warp.col(face / 4)).norm(), 1e-14) << face;
  }
  EXPECT_EQ(RefineScene(Read(kGrid, ""), RefineMesh(mesh)).warp.directions.cols(), 0);
}

TEST_F(WarpOfTheMeshTest, NamesWhatIsWrong) {
  WriteObj(kAngle);
  const std::string key = "key 'materials.warp_direction': expected ";
  ExpectBad(kGrid, Direction("\"uv\""), key + "a mesh from an OBJ file beside it, whose UV map it is to follow");
  ExpectBad(kGrid, Direction("[[1, 0, 0], [0, 1, 0]]"),
            key + "one direction, or one for each of the 24 triangles, found 2");
  ExpectBad(kGrid, Direction("[[1, 0, 0], [0, 1]]"), "'materials.warp_direction[1]': expected an array of three");
  ExpectBad(kGrid, Direction("[]"), key + "an array of three numbers");
  Eigen::Matrix3Xd directions = Eigen::Vector3d::UnitX().replicate(1, 24);
  directions.col(17).setZero();
  folder_.Write("warp.npy", NpyBytes(directions));
  ExpectBad(kGrid, Direction("\"warp.npy\""), key + "a direction, not zero, for triangle 17");
  directions.col(17) = Eigen::Vector3d::UnitZ();
  folder_.Write("warp.npy", NpyBytes(directions));
  ExpectBad(kGrid, Direction("\"warp.npy\""), key + "a direction along the cloth; triangle 17 is perpendicular to it");
  folder_.Write("warp.npy", NpyBytes(Eigen::Matrix3Xd(directions.leftCols(20))));
  ExpectBad(kGrid, Direction("\"warp.npy\""), "warp.npy to hold an array of shape (24, 3)");
  ExpectError([&] { Read(kGrid, Direction("\"none.npy\"")); }, ErrorKind::kIo, {"none.npy"});
  folder_.Write("cloth.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\nv 2 0 0\nf 1 2 3\nf 2 4 3\nf 2 6 5 4\n");
  EXPECT_NO_THROW(Read(kObj, ""));
  ExpectError([&] { Read(kObj, Direction("\"uv\"")); }, ErrorKind::kBadData, {"cloth.obj:7: ", "triangle 0"});
}

TEST_F(WarpOfTheMeshTest, ASceneNamesItsFile) {
  const std::string path = folder_.Write("scene.json", Text(kGrid, Direction("\"warp.npy\"")));
  EXPECT_EQ(FilesOfScene(path), (std::vector<std::string>{path, folder_.File("warp.npy")}));
  folder_.Write("scene.json", Text(kObj, Direction("\"uv\"")));
  EXPECT_EQ(FilesOfScene(path), (std::vector<std::string>{path, folder_.File("cloth.obj")}));
}

// A recording brings its own mesh; the UV map of a scene beside it is that of the same triangles.
TEST_F(WarpOfTheMeshTest, OfARecordedMeshNeedsTheSameTriangles) {
  WriteObj(kAngle);
  SceneDefaults defaults;
  defaults.has_mesh = true;
  defaults.mesh = Read(kGrid, "").mesh;
  defaults.initial_positions = defaults.mesh.rest_positions.reshaped();
  defaults.duration = 0.1;
  const auto read = [&] { return ParseScene(Text(kObj, Direction("\"uv\"")), "scene.json", folder_.path(), defaults); };
  EXPECT_EQ(read().warp.directions.cols(), 24);
  defaults.mesh.faces.col(3).swap(defaults.mesh.faces.col(4));
  ExpectError(read, ErrorKind::kBadData, {"key 'mesh.obj': expected the triangles of the recording", "cloth.obj"});
}

}  // namespace
}  // namespace clothid::warp_test
