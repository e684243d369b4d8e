#include "sim/mesh/obj_file.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <initializer_list>

#include "tests/expect_error.h"
#include "tests/temporary_folder.h"

namespace clothid::obj_file_test {
namespace {

constexpr ErrorKind kBadData = ErrorKind::kBadData;

TEST(ReadObj, ReadsVerticesAndFansOfPolygons) {
  const TemporaryFolder folder;
  const std::string path = folder.Write("cloth.obj",
                                        "# a comment\r\nmtllib x.mtl\r\nv 0 0 0\r\nv +1 0 0 1.0\r\nv 1 1 0\n"
                                        "vt 0 0\nv\t0 1 1e-1\nf 1/1/1 2//2 3 4/1\nv 2 0 0\nf -1 -3 2\n");
  const Mesh mesh = ReadObj(path);
  ASSERT_EQ(mesh.num_nodes(), 5);
  EXPECT_EQ(mesh.rest_positions.col(3), Eigen::Vector3d(0.0, 1.0, 0.1));
  ASSERT_EQ(mesh.num_faces(), 3);
  EXPECT_EQ(mesh.faces.col(0), Eigen::Vector3i(0, 1, 2));
  EXPECT_EQ(mesh.faces.col(1), Eigen::Vector3i(0, 2, 3));
  EXPECT_EQ(mesh.faces.col(2), Eigen::Vector3i(4, 2, 1));
}

// An L whose fan about its first corner would turn a triangle over and be larger than it. Frames of a surface are cut
// as the surface is, however they are folded.
TEST(ReadObj, CutsPolygonsThatAreNotConvex) {
  const TemporaryFolder folder;
  const std::string faces = "f 3 4 5 6 1 2\n";
  const std::string path =
      folder.Write("l.obj", "v 0 0 0\nv .2 0 0\nv .2 .1 0\nv .1 .1 0\nv .1 .2 0\nv 0 .2 0\n" + faces);
  const Mesh mesh = ReadObj(path);
  ASSERT_EQ(mesh.num_faces(), 4);
  double area = 0.0;
  for (int face = 0; face < 4; ++face) {
    const Eigen::Vector3d a = mesh.rest_positions.col(mesh.faces(0, face));
    const Eigen::Vector3d b = mesh.rest_positions.col(mesh.faces(1, face)) - a;
    const Eigen::Vector3d cross = b.cross(Eigen::Vector3d(mesh.rest_positions.col(mesh.faces(2, face)) - a));
    EXPECT_GT(cross.z(), 0.0);
    area += 0.5 * cross.z();
  }
  EXPECT_NEAR(area, 0.03, 1e-15);
  const std::string frame =
      folder.Write("frame.obj", "v 0 0 0\nv .2 0 .1\nv .1 0 .2\nv .1 .1 0\nv .1 -.2 0\nv 0 -.2 .1\n" + faces);
  EXPECT_EQ(ReadObjLike(frame, mesh.faces).faces, mesh.faces);
  ExpectError([&] { ReadObj(folder.Write("bow.obj", "v 0 0 0\nv 1 1 0\nv 1 0 0\nv 0 1 0\n\nf 1 2 3 4\n")); }, kBadData,
              {"bow.obj:6: ", "polygon of 4 corners", "crosses or touches itself"});
}

TEST(ReadObj, ReadsCommentsAndLinesThatGoOn) {
  const TemporaryFolder folder;
  const std::string path = folder.Write("cloth.obj",
                                        "# C:\\models\\\nv 0 0 0 # one\nv 1 \\\n0 0\nv 1 1 0#three\nv 0 1 0\n"
                                        "g front#1 \\\nback\nf 1 2 \\ \r\n 3 \\\n 4 # all\nf 1 2 3 # 4\n");
  FaceGroups groups;
  const Mesh mesh = ReadObjWithGroups(path, &groups);
  ASSERT_EQ(mesh.num_nodes(), 4);
  EXPECT_EQ(mesh.rest_positions.col(1), Eigen::Vector3d(1.0, 0.0, 0.0));
  ASSERT_EQ(mesh.num_faces(), 3);
  EXPECT_EQ(mesh.faces.col(2), Eigen::Vector3i(0, 1, 2));
  EXPECT_EQ(groups.count("front#1") + groups.count("back"), 2U);
  const std::string torn = folder.Write("torn.obj", "v 0 0 \\\n0\n\nf 1 \\\n1 2\nv 0 0\n");
  ExpectError([&] { ReadObj(torn); }, kBadData, {"torn.obj:4: face corner '2'"});
  const std::string same = folder.Write("same.obj", "v 0 0 \\\n0\nv 1 0 0\nv 0 1 0\nf 1 \\\n2 3\nf 1 \\\n1 2\n");
  ExpectError([&] { ValidateObjMesh(ReadObj(same), same); }, kBadData, {"same.obj:7: triangle 1 has the same node"});
  EXPECT_EQ(ReadObj(folder.Write("end.obj", "v 0 0 0\\")).num_nodes(), 1);
}

TEST(ReadObj, NamesFileAndLine) {
  const TemporaryFolder folder;
  const auto expect = [&](const std::string& content, std::initializer_list<const char*> fragments) {
    const std::string path = folder.Write("cloth.obj", content);
    ExpectError([&] { ReadObj(path); }, kBadData, fragments);
  };
  expect("v 0 0 0\nv 1 x 0\n", {"cloth.obj:2: ", "'x'"});
  expect("v 0 0\n", {"cloth.obj:1: ", "three finite numbers"});
  expect("v 0 0 1e999\n", {"cloth.obj:1: ", "three finite numbers"});
  expect("v 0 nan 0\n", {"cloth.obj:1: ", "three finite numbers"});
  expect("v 0 0 0\n\nf 1 1 2\n", {"cloth.obj:3: ", "face corner '2'"});
  expect("v 0 0 0\nf 0 1 1\n", {"cloth.obj:2: ", "face corner '0'"});
  expect("v 0 0 0\nf 1 1 -2\n", {"cloth.obj:2: ", "face corner '-2'"});
  expect("v 0 0 0\nf 1 1\n", {"cloth.obj:2: ", "at least three corners"});
  expect("v 0 0 0\nf 1 1 99999999999999999999\n", {"cloth.obj:2: ", "face corner"});
}

TEST(ReadObj, ReportsAFileThatIsNotThere) {
  const TemporaryFolder folder;
  ExpectError([&] { ReadObj(folder.File("none.obj")); }, ErrorKind::kIo, {"none.obj", "No such file"});
  ExpectError([&] { ReadObj(folder.path()); }, ErrorKind::kIo, {"cannot be read"});
}

// A square of two triangles whose texture coordinates are (u, v) = (y + 5, -2 x); the second one on an island of its
// own. Then u grows along y, however v runs.
TEST(ReadObjWithUv, FindsTheDirectionOfU) {
  const TemporaryFolder folder;
  const std::string path = folder.Write("cloth.obj",
                                        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 5 0\nvt 5 -2 0\nvt 6 -2\nvt 6 0\n"
                                        "f 1/1 2/2/7 3/3\nvt 0 9\nvt 1 7\nvt 1 9\nf 1/-3 3/-2 4/-1\n");
  Eigen::Matrix3Xd along_u;
  const Mesh mesh = ReadObjWithUv(path, &along_u);
  EXPECT_EQ(mesh.faces, ReadObj(path).faces);
  EXPECT_EQ(along_u, Eigen::Vector3d::UnitY().replicate(1, 2));
}

// The fan of a square that is sheared in the map: where v is constant the cloth runs along (1, 0.5), and that is dX/du,
// not the gradient of u. In a mirror it is the same.
TEST(ReadObjWithUv, FollowsLinesOfConstantV) {
  const TemporaryFolder folder;
  for (const char* last : {"vt 0 1\n", "vt 0 -1\n"}) {
    const double sign = last[5] == '-' ? -1.0 : 1.0;
    const auto coordinates = [&](double x, double y) {  // u = x, v = (y - x/2) sign
      return "vt " + std::to_string(x) + " " + std::to_string(sign * (y - 0.5 * x)) + "\n";
    };
    const std::string path =
        folder.Write("cloth.obj", "v 0 0 2\nv 1 0 2\nv 1 1 2\nv 0 1 2\n" + coordinates(0, 0) + coordinates(1, 0) +
                                      coordinates(1, 1) + coordinates(0, 1) + "f 1/1 2/2 3/3 4/4\n");
    Eigen::Matrix3Xd along_u;
    ReadObjWithUv(path, &along_u);
    ASSERT_EQ(along_u.cols(), 2);
    const Eigen::Vector3d expected = Eigen::Vector3d(1.0, 0.5, 0.0).normalized();
    EXPECT_LT((along_u.colwise() - expected).norm(), 1e-15) << sign;
  }
}

TEST(ReadObjWithUv, NamesFileLineAndTriangle) {
  const TemporaryFolder folder;
  const auto expect = [&](const std::string& content, std::initializer_list<const char*> fragments) {
    const std::string path = folder.Write("cloth.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n" + content);
    Eigen::Matrix3Xd along_u;
    EXPECT_NO_THROW(ReadObj(path)) << content;
    ExpectError([&] { ReadObjWithUv(path, &along_u); }, kBadData, fragments);
  };
  expect("vt 0 x\n", {"cloth.obj:5: ", "two finite numbers after 'vt', found 'x'"});
  expect("vt 0\n", {"cloth.obj:5: ", "two finite numbers after 'vt', found ''"});
  expect("f 1 2 3\n", {"cloth.obj:5: face corner '1' of triangle 0 has no texture coordinates"});
  expect("vt 0 0\nvt 1 0\nvt 1 1\nf 1/1 2/2 3/3\nf 1/1 3/3/1 4//1\n",
         {"cloth.obj:9: face corner '4//1' of triangle 1 has no texture coordinates, which the warp is to follow"});
  expect("vt 0 0\nf 1/1 2/2 3/1\n", {"cloth.obj:6: face corner '2/2' of triangle 0 has none of the 1 texture"});
  expect("vt 0 0\nf 1/1 2/-2 3/1\n", {"cloth.obj:6: face corner '2/-2'"});
  expect("vt 0 0\nvt 1 1\nvt 1 0\nvt 2 2\nf 1/1 2/3 3/2\nf 1/1 3/2 4/4\n",
         {"cloth.obj:10: triangle 1 has no direction of u", "lie on a line"});
}

}  // namespace
}  // namespace clothid::obj_file_test
