#include "sim/mesh/mesh.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "tests/expect_error.h"

namespace clothid::mesh_test {
namespace {

constexpr ErrorKind kBadData = ErrorKind::kBadData;

GridOptions SmallGrid() {
  GridOptions options;
  options.nodes = {4, 3};
  options.size = {0.6, 0.2};
  return options;
}

void ExpectInvalid(const Mesh& mesh, std::initializer_list<const char*> fragments) {
  ExpectError([&] { ValidateMesh(mesh, "cloth.obj"); }, kBadData, fragments);
}

TEST(MakeGrid, PlacesNodesAlongNormalisedAxes) {
  GridOptions options = SmallGrid();
  options.origin = {1.0, 2.0, 3.0};
  options.axes = {Eigen::Vector3d(0.0, 5.0, 0.0), Eigen::Vector3d(0.0, 0.0, -2.0)};
  const Mesh mesh = MakeGrid(options);
  ASSERT_EQ(mesh.num_nodes(), 12);
  ASSERT_EQ(mesh.num_faces(), 12);
  EXPECT_LT((mesh.rest_positions.col(1 + 4 * 2) - Eigen::Vector3d(1.0, 2.2, 2.8)).norm(), 1e-15);
  EXPECT_LT((mesh.rest_positions.col(3) - Eigen::Vector3d(1.0, 2.6, 3.0)).norm(), 1e-15);
}

TEST(MakeGrid, IsValidAndFacesOneSide) {
  const Mesh mesh = MakeGrid(SmallGrid());
  EXPECT_NO_THROW(ValidateMesh(mesh, "grid"));
  for (int f = 0; f < mesh.num_faces(); ++f) {
    const Eigen::Vector3d a = mesh.rest_positions.col(mesh.faces(0, f));
    const Eigen::Vector3d b = mesh.rest_positions.col(mesh.faces(1, f));
    const Eigen::Vector3d c = mesh.rest_positions.col(mesh.faces(2, f));
    EXPECT_GT((b - a).cross(c - a).z(), 0.0) << f;
  }
}

TEST(MakeGrid, AlternatesDiagonals) {
  GridOptions options;
  options.nodes = {3, 3};
  const Mesh mesh = MakeGrid(options);
  // On 3 x 3 nodes every diagonal of the checkerboard meets the middle node.
  EXPECT_EQ((mesh.faces.array() == 4).count(), 8);
}

TEST(Areas, AddUp) {
  const Mesh mesh = MakeGrid(SmallGrid());
  EXPECT_NEAR(TriangleAreas(mesh).sum(), 0.12, 1e-15);
  EXPECT_NEAR(NodeAreas(mesh).sum(), 0.12, 1e-15);
  EXPECT_NEAR(TriangleAreas(mesh)[5], 0.01, 1e-15);
  EXPECT_NEAR(ClothSize(mesh), std::sqrt(0.12), 1e-15);
}

TEST(Areas, GiveANodeAThirdOfItsTriangles) {
  Mesh mesh;
  mesh.rest_positions.resize(3, 3);
  mesh.rest_positions << 0.0, 3.0, 0.0, 0.0, 0.0, 4.0, 0.0, 0.0, 0.0;
  mesh.faces.resize(3, 1);
  mesh.faces << 0, 1, 2;
  EXPECT_LT((NodeAreas(mesh) - Eigen::Vector3d::Constant(2.0)).norm(), 1e-15);
}

TEST(ValidateMesh, NamesAnInvertedTriangle) {
  Mesh mesh = MakeGrid(SmallGrid());
  std::swap(mesh.faces(0, 7), mesh.faces(1, 7));
  ExpectInvalid(mesh, {"cloth.obj: triangle", "is inverted relative to triangle", "in the same direction"});
}

TEST(ValidateMesh, NamesAnEdgeOfThreeTriangles) {
  Mesh mesh = MakeGrid(SmallGrid());
  mesh.rest_positions.conservativeResize(3, 13);
  mesh.rest_positions.col(12) = Eigen::Vector3d(0.0, 0.0, 1.0);
  mesh.faces.conservativeResize(3, 13);
  const Eigen::Vector3i neighbour = mesh.faces.col(0);
  mesh.faces.col(12) = Eigen::Vector3i(neighbour[2], neighbour[0], 12);
  ExpectInvalid(mesh, {"edge 0-5 belongs to more than two triangles (0, 1, 12)"});
}

TEST(ValidateMesh, NamesATriangleWithoutArea) {
  Mesh mesh = MakeGrid(SmallGrid());
  mesh.rest_positions.col(11) = 0.5 * (mesh.rest_positions.col(6) + mesh.rest_positions.col(10));
  mesh.faces.col(11) = Eigen::Vector3i(6, 11, 10);
  ExpectInvalid(mesh, {"triangle 11 has no area"});
}

TEST(ValidateMesh, NamesIndicesOutOfRangeAndRepeated) {
  Mesh mesh = MakeGrid(SmallGrid());
  mesh.faces(1, 3) = 12;
  ExpectInvalid(mesh, {"triangle 3 refers to node 12; expected 0 to 11"});
  mesh.faces(1, 3) = -1;
  ExpectInvalid(mesh, {"triangle 3 refers to node -1"});
  mesh.faces(1, 3) = mesh.faces(0, 3);
  ExpectInvalid(mesh, {"triangle 3 has the same node at two corners"});
}

TEST(ValidateMesh, NamesALooseNodeAndAWildOne) {
  Mesh mesh = MakeGrid(SmallGrid());
  mesh.rest_positions.conservativeResize(3, 13);
  mesh.rest_positions.col(12).setOnes();
  ExpectInvalid(mesh, {"node 12 belongs to no triangle"});
  mesh.rest_positions(1, 12) = std::numeric_limits<double>::quiet_NaN();
  ExpectInvalid(mesh, {"the rest position of node 12 is not finite"});
  ExpectInvalid(Mesh(), {"the mesh has no triangle"});
}

}  // namespace
}  // namespace clothid::mesh_test
