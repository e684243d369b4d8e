// The mesh of twice the density: its triangles, nodes, handles and start.
#include "sim/scene/refinement.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sim/scene/attached_handles.h"
#include "tests/expect_error.h"
#include "tests/sim/garments.h"
#include "tests/sim/shipped_scenes.h"

namespace clothid::refinement_test {
namespace {

Mesh SmallGrid() {
  GridOptions options;
  options.nodes = {4, 3};
  options.size = {0.6, 0.2};
  return MakeGrid(options);
}

Scene SmallScene() {
  Scene scene;
  scene.mesh = SmallGrid();
  scene.initial_positions = scene.mesh.rest_positions.reshaped();
  scene.initial_velocities = Eigen::VectorXd::LinSpaced(scene.initial_positions.size(), -1.0, 1.0);
  return scene;
}

Eigen::Vector3d NodeOf(const Eigen::VectorXd& values, int node) { return values.segment<3>(3 * node); }

TEST(RefineMeshTest, QuartersEveryTriangle) {
  const Mesh coarse = SmallGrid();
  const RefinedMesh refined = RefineMesh(coarse);
  EXPECT_NO_THROW(ValidateMesh(refined.mesh, "refined")) << "neighbours run along their edge in opposite directions";
  ASSERT_EQ(refined.mesh.num_faces(), 4 * coarse.num_faces());
  const Eigen::VectorXd areas = TriangleAreas(coarse), quarters = TriangleAreas(refined.mesh);
  for (int f = 0; f < coarse.num_faces(); ++f) {
    for (int k = 0; k < 4; ++k) EXPECT_NEAR(quarters[4 * f + k], 0.25 * areas[f], 1e-17) << f << " " << k;
  }
  EXPECT_NEAR(NodeAreas(refined.mesh).sum(), areas.sum(), 1e-15);
}

TEST(RefineMeshTest, KeepsNodesAndPutsTheOthersHalfwayBetweenThem) {
  const Mesh coarse = SmallGrid();
  const RefinedMesh refined = RefineMesh(coarse);
  EXPECT_EQ(refined.num_coarse_nodes(), coarse.num_nodes());
  // Euler: V - E + F = 1 of a disc.
  EXPECT_EQ(static_cast<int>(refined.edges.size()), coarse.num_nodes() + coarse.num_faces() - 1);
  EXPECT_EQ(refined.mesh.num_nodes(), 7 * 5) << "as a grid of twice the density";
  EXPECT_EQ(refined.mesh.rest_positions.leftCols(coarse.num_nodes()), coarse.rest_positions);
  for (const auto& [a, b] : refined.edges) {
    const int middle = refined.Midpoint(b, a);
    EXPECT_EQ(middle, refined.Midpoint(a, b));
    ASSERT_GE(middle, coarse.num_nodes());
    const Eigen::Vector3d expected = 0.5 * (coarse.rest_positions.col(a) + coarse.rest_positions.col(b));
    EXPECT_LT((refined.mesh.rest_positions.col(middle) - expected).norm(), 1e-16);
  }
  EXPECT_EQ(refined.Midpoint(0, 11), -1) << "no edge joins opposite corners";
}

TEST(RefineMeshTest, WorksOnMeshesThatAreNoGrids) {
  // A tetrahedron without its base, as from an OBJ file.
  Mesh mesh;
  mesh.rest_positions.resize(3, 4);
  mesh.rest_positions << 0.0, 1.0, 0.0, 0.0,  //
      0.0, 0.0, 1.0, 0.0,                     //
      0.0, 0.0, 0.0, 1.0;
  mesh.faces.resize(3, 3);
  mesh.faces << 3, 3, 3,  //
      0, 1, 2,            //
      1, 2, 0;
  const RefinedMesh refined = RefineMesh(mesh);
  EXPECT_NO_THROW(ValidateMesh(refined.mesh, "refined"));
  EXPECT_EQ(refined.mesh.num_nodes(), 4 + 6);
  EXPECT_NEAR(ClothSize(refined.mesh), ClothSize(mesh), 1e-15);
}

// A sheet with a rest place per corner is refined as the sheet is; a fold becomes two.
TEST(RefineMeshTest, HalvesTheMapToo) {
  GridOptions grid;
  grid.nodes = {4, 3};
  Mesh mesh = WithUvRest(MakeGrid(grid));
  mesh.folds = {{1, 5}};
  const RefinedMesh refined = RefineMesh(mesh);
  const Mesh expected = WithUvRest(refined.mesh);
  EXPECT_LT((refined.mesh.corner_rest - expected.corner_rest).norm(), 1e-15);
  EXPECT_NO_THROW(ValidateMesh(refined.mesh, "refined"));
  const int middle = refined.Midpoint(1, 5);
  EXPECT_EQ(refined.mesh.folds, (std::vector<std::array<int, 2>>{{1, middle}, {5, middle}}));
}

TEST(RefineSceneTest, RefusesLinks) {
  Scene scene = SmallScene();
  scene.mesh.links = {{0, {5, 5}, 0.0, 10.0, 0.0}};
  ExpectError([&] { ExpectRefinable(scene, "a.bin"); }, ErrorKind::kUsage, {"a.bin", "no seams that close"});
}

TEST(RefineSceneTest, StartsOnTheSameSurface) {
  const Scene coarse = SmallScene();
  const RefinedMesh refined = RefineMesh(coarse.mesh);
  const Scene scene = RefineScene(coarse, refined);
  EXPECT_NO_THROW(ValidateScene(scene, "refined"));
  EXPECT_LT((scene.initial_positions - scene.mesh.rest_positions.reshaped()).norm(), 1e-15) << "rest stays rest";
  const auto [a, b] = refined.edges[5];
  const Eigen::Vector3d expected = 0.5 * (NodeOf(coarse.initial_velocities, a) + NodeOf(coarse.initial_velocities, b));
  EXPECT_LT((NodeOf(scene.initial_velocities, refined.Midpoint(a, b)) - expected).norm(), 1e-16);
}

TEST(RefineSceneTest, HoldsWhatIsBetweenHandles) {
  Scene coarse = SmallScene();
  coarse.handles.nodes = {2, 0, 1, 11};  // three along an edge of the cloth in an order of their own, and a corner
  Eigen::VectorXd times(3);
  times << 0.0, 0.1, 0.3;
  Eigen::MatrixXd positions = Eigen::MatrixXd::Random(12, 3);
  coarse.handles.path = HandlePath(times, positions);
  const RefinedMesh refined = RefineMesh(coarse.mesh);
  const Handles handles = RefineScene(coarse, refined).handles;
  ASSERT_EQ(handles.nodes, (std::vector<int>{2, 0, 1, 11, refined.Midpoint(0, 1), refined.Midpoint(1, 2)}));
  // The path between the knots, too.
  const Eigen::VectorXd before = coarse.handles.path.At(0.17), after = handles.path.At(0.17);
  EXPECT_EQ(after.head(12), before);
  EXPECT_LT((NodeOf(after, 4) - 0.5 * (NodeOf(before, 1) + NodeOf(before, 2))).norm(), 1e-15);
  EXPECT_LT((NodeOf(after, 5) - 0.5 * (NodeOf(before, 2) + NodeOf(before, 0))).norm(), 1e-15);
}

TEST(RefineSceneTest, RefusesForcesPerNode) {
  Scene scene = SmallScene();
  EXPECT_NO_THROW(ExpectRefinable(scene, "a.bin"));
  scene.node_force.z() = 1e-3;
  ExpectError([&] { ExpectRefinable(scene, "a.bin"); }, ErrorKind::kUsage, {"a.bin", "'node_force'", "finer mesh"});
}

TEST(RefineSceneTest, HalvesOfAClampedEdgeHaveItsSlope) {
  Scene scene = ShippedScene("drape", 4);
  ClampHandles({{scene.handles.nodes, Eigen::Vector3d(0.1, 0.2, 1.0)}}, &scene);
  const Scene refined = RefineScene(scene, RefineMesh(scene.mesh));
  ValidateScene(refined, "refined");
  ASSERT_EQ(refined.handles.clamped.size(), 6u);
  for (std::size_t i = 0; i < 6; ++i) {
    const ClampedEdge& edge = refined.handles.clamped[i];
    const Eigen::Vector3i corners = refined.mesh.faces.col(edge.face);
    for (const int node : edge.nodes) EXPECT_TRUE((corners.array() == node).any()) << i;
    EXPECT_EQ(refined.handles.slopes.At(0.0).segment<3>(3 * static_cast<Eigen::Index>(i)),
              scene.handles.slopes.At(0.0).segment<3>(3 * static_cast<Eigen::Index>(i / 2)));
  }
}

}  // namespace
}  // namespace clothid::refinement_test
