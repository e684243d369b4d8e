#include "sim/mesh/sewing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tests/expect_error.h"
#include "tests/sim/garments.h"

namespace clothid::sewing_test {
namespace {

constexpr int kColumns = 5, kRows = 4;

GridOptions Grid() {
  GridOptions grid;
  grid.nodes = {kColumns, kRows};
  grid.size = {0.4, 0.3};
  return grid;
}

CutMesh CutGrid() {
  return Cut(WithUvRest(MakeGrid(Grid())), GridLine(kColumns, kRows, true, 2),
             [](const Eigen::Vector3d& middle) { return middle.x() > 0.2; });
}

void ExpectProblem(Mesh mesh, const std::vector<Seam>& seams, std::initializer_list<const char*> fragments) {
  ExpectError([&] { Sewn(mesh, seams); }, ErrorKind::kBadData, fragments);
}

TEST(SewingTest, JoinsWhatWasCut) {
  const CutMesh cut = CutGrid();
  const Mesh whole = WithUvRest(MakeGrid(Grid())), sewn = Sewn(cut.mesh, {SeamOf(cut)});
  EXPECT_EQ(sewn.faces, whole.faces);
  EXPECT_EQ(sewn.rest_positions, whole.rest_positions);
  EXPECT_EQ(sewn.corner_rest, whole.corner_rest);
  EXPECT_TRUE(sewn.links.empty() && sewn.folds.empty());
}

TEST(SewingTest, NodesOfBGoAndOthersCountDown) {
  CutMesh cut = CutGrid();
  Seam seam = SeamOf(cut);
  std::swap(seam.a, seam.b);
  seam.is_fold = true;
  const Mesh sewn = Sewn(cut.mesh, {seam});
  ASSERT_EQ(sewn.num_nodes(), kColumns * kRows);
  EXPECT_EQ(sewn.rest_positions.col(2), cut.mesh.rest_positions.col(3));  // node 2 was of b
  EXPECT_EQ(sewn.faces.maxCoeff(), kColumns * kRows - 1);
  ASSERT_EQ(sewn.folds.size(), 3u);
  for (const auto& [low, high] : sewn.folds) {
    EXPECT_EQ(high, low + 1);
    EXPECT_GE(low, kColumns * kRows - kRows);
  }
}

TEST(SewingTest, MakesASleeveOfAPanel) {
  const CutMesh panel = SleevePanel(9, 4, 0.4, 0.15);
  const Mesh sleeve = Sewn(panel.mesh, {SeamOf(panel)});
  EXPECT_EQ(sleeve.num_nodes(), 8 * 4);
  EXPECT_NEAR(TriangleAreas(sleeve).sum(), 0.4 * 0.15, 1e-15);
  const Eigen::VectorXd areas = NodeAreas(sleeve);
  for (int row = 0; row < 4; ++row)
    EXPECT_NEAR(areas[8 * row] + areas[8 * row + 1], areas[8 * row + 2] + areas[8 * row + 3], 1e-15);
}

// Front and back of a tube are joined at one side; the other seam then is of the tube's whole border.
TEST(SewingTest, GoesOnOverASeam) {
  const CutMesh cut = CutGrid();
  std::vector<int> lower = {0, 1, 2, cut.beyond[0], 3, 4}, upper;
  for (const int node : lower) upper.push_back(node < kColumns ? node + 3 * kColumns : cut.beyond[3]);
  Seam tube;
  tube.a = lower;
  tube.b = upper;
  const Mesh sewn = Sewn(cut.mesh, {SeamOf(cut), tube});
  EXPECT_EQ(sewn.num_nodes(), kColumns * (kRows - 1));
}

// Two sleeves, ring to ring: closed chains over the seams of both.
TEST(SewingTest, JoinsRings) {
  const CutMesh panel = SleevePanel(9, 4, 0.4, 0.15);
  CutMesh upper = panel;
  upper.mesh.rest_positions.row(2).array() += 0.15;
  Seam side = SeamOf(panel), upper_side = side, ring;
  for (int& node : upper_side.a) node += 36;
  for (int& node : upper_side.b) node += 36;
  for (int i = 0; i < 9; ++i) {
    ring.a.push_back(27 + i);
    ring.b.push_back(36 + i);
  }
  const Mesh both = Together(panel.mesh, upper.mesh);
  const Mesh joined = Sewn(both, {side, upper_side, ring});
  EXPECT_EQ(joined.num_nodes(), 2 * 32 - 8);
  const Eigen::VectorXd areas = NodeAreas(joined);
  for (int i = 0; i < 8; i += 2) {  // of a pair around the ring, with as much on either side
    EXPECT_NEAR(areas[24 + i] + areas[25 + i], 2.0 * 0.05 * 0.05, 1e-15);
  }
  ring.is_drawn = true;
  const Mesh drawn = Sewn(both, {side, upper_side, ring});
  double stiffness = 0.0;
  for (const SeamLink& link : drawn.links) stiffness += link.stiffness;
  EXPECT_NEAR(stiffness, kSeamStiffness * 0.4, 1e-9);
}

// Four nodes against nine: the nodes between are drawn to the points at their shares of the length.
TEST(SewingTest, DrawsOtherNumbersToPointsOnEdges) {
  GridOptions fine = Grid();
  fine.nodes = {3, 9};
  const Mesh mesh = WithUvRest(MakeGrid(Grid())), other = WithUvRest(MakeGrid(fine));
  const int first = mesh.num_nodes();
  const Mesh both = Together(mesh, other);
  Seam seam;
  seam.a = GridLine(kColumns, kRows, true, 4);
  for (const int node : GridLine(3, 9, true, 0)) seam.b.push_back(first + node);
  const Mesh sewn = Sewn(both, {seam});
  ASSERT_EQ(sewn.links.size(), 9u);
  double stiffness = 0.0;
  for (std::size_t i = 0; i < 9; ++i) {
    const SeamLink& link = sewn.links[i];
    EXPECT_EQ(link.node, seam.b[i]);
    EXPECT_EQ(link.closing_time, 0.0);
    const double y =
        (1.0 - link.share) * sewn.rest_positions(1, link.edge[0]) + link.share * sewn.rest_positions(1, link.edge[1]);
    EXPECT_NEAR(y, sewn.rest_positions(1, link.node), 1e-15);
    stiffness += link.stiffness;
  }
  EXPECT_NEAR(stiffness, kSeamStiffness * 0.3, 1e-9);
  std::swap(seam.a, seam.b);
  const Mesh swapped = Sewn(both, {seam});
  for (std::size_t i = 0; i < 9; ++i) EXPECT_EQ(swapped.links[i].node, sewn.links[i].node);
}

TEST(SewingTest, DrawsNodeToNodeOverATime) {
  const CutMesh cut = CutGrid();
  Seam seam = SeamOf(cut);
  seam.is_drawn = true;
  seam.closing_time = 0.25;
  seam.stiffness = 500.0;
  const Mesh sewn = Sewn(cut.mesh, {seam});
  EXPECT_EQ(sewn.num_nodes(), cut.mesh.num_nodes());
  ASSERT_EQ(sewn.links.size(), 4u);
  for (int i = 0; i < 4; ++i) {
    const SeamLink& link = sewn.links[i];
    EXPECT_EQ(link.node, cut.beyond[i]);
    EXPECT_EQ(link.edge[0], cut.seam[i]);
    EXPECT_EQ(link.edge[1], cut.seam[i]);
    EXPECT_EQ(link.closing_time, 0.25);
    EXPECT_NEAR(link.stiffness, 500.0 * (i == 0 || i == 3 ? 0.05 : 0.1), 1e-12);
  }
}

TEST(SewingTest, RefusesWhatIsNoSeam) {
  const CutMesh cut = CutGrid();
  const Seam good = SeamOf(cut);
  Seam seam = good;
  seam.a[1] = 6;
  ExpectProblem(cut.mesh, {seam}, {"node 6 of a is not on the border of the mesh"});
  seam = good;
  seam.a = {2, 12};
  seam.b = {cut.beyond[0], cut.beyond[2]};
  ExpectProblem(cut.mesh, {seam}, {"nodes 2 and 12 of a are no edge of the border of the mesh"});
  seam.a = {2, 99};
  ExpectProblem(cut.mesh, {seam}, {"node 99 of a: expected 0 to 23"});
  seam.a = {2};
  ExpectProblem(cut.mesh, {seam}, {"expected at least two nodes in a"});
  seam.a = {2, 7, 2};
  ExpectProblem(cut.mesh, {seam}, {"node 2 is twice in a"});
  seam.a = {2, 2, 7};
  ExpectProblem(cut.mesh, {seam}, {"node 2 is twice in a"});
  seam.a = good.a;
  seam.b = good.a;
  ExpectProblem(cut.mesh, {seam}, {"nodes 2 and 7 are in a and in b"});
}

TEST(SewingTest, RefusesAnEdgeInTwoSeams) {
  const CutMesh cut = CutGrid();
  const Seam good = SeamOf(cut);
  Seam third = good;
  third.b = GridLine(kColumns, kRows, true, 4);
  std::reverse(third.b.begin(), third.b.end());
  ExpectProblem(cut.mesh, {good, third}, {"nodes 2 and 7 of a are sewn already", "two triangles at most"});
  Seam drawn = good;
  drawn.is_drawn = true;
  ExpectProblem(cut.mesh, {drawn, third}, {"nodes 2 and 7 of a are sewn already"});
}

TEST(SewingTest, RefusesSidesOfDifferentLengthsUnlessEased) {
  CutMesh cut = CutGrid();
  for (const int f : cut.faces) cut.mesh.corner_rest.middleCols<3>(3 * f).row(1) *= 1.1;
  Seam seam = SeamOf(cut);
  ExpectProblem(cut.mesh, {seam}, {"a is 0.3 m long at rest and b 0.33 m", "within 5 %", "\"ease\": true"});
  seam.is_eased = true;
  EXPECT_EQ(Sewn(cut.mesh, {seam}).num_nodes(), kColumns * kRows);
}

TEST(SewingTest, RefusesToJoinWithoutARestPlacePerCorner) {
  CutMesh cut = CutGrid();
  cut.mesh.corner_rest.resize(2, 0);
  ExpectProblem(cut.mesh, {SeamOf(cut)}, {"expected \"rest\": \"uv\" of the mesh, or \"closes\""});
}

// The piece beyond runs the other way along the seam: one of both is inside out.
TEST(SewingTest, RefusesAPieceThatIsInsideOut) {
  CutMesh cut = CutGrid();
  for (const int f : cut.faces) {
    std::swap(cut.mesh.faces(0, f), cut.mesh.faces(1, f));
    cut.mesh.corner_rest.col(3 * f).swap(cut.mesh.corner_rest.col(3 * f + 1));
  }
  ExpectProblem(cut.mesh, {SeamOf(cut)}, {"sewn: triangle", "is inverted relative to triangle"});
}

// Two sides of a corner: its two triangles fall together, beside others.
TEST(SewingTest, NamesThePlaceOfAnEdgeOfMoreTriangles) {
  Seam seam;
  seam.a = {0, 1};
  seam.b = {0, 5};
  ExpectProblem(WithUvRest(MakeGrid(Grid())), {seam},
                {"sewn: edge 1-5 belongs to more than two triangles (0, 1, ", ") at (0.1, 0.05, 0) m"});
}

TEST(SewingTest, HoldsButtons) {
  Mesh mesh = MakeGrid(Grid());
  Sewing sewing(&mesh);
  sewing.AddButton(6, 13);
  ExpectError([&] { sewing.AddButton(6, 6); }, ErrorKind::kBadData, {"nodes 6 and 6 are the same"});
  ExpectError([&] { sewing.AddButton(6, 20); }, ErrorKind::kBadData, {"node 20: expected 0 to 19"});
  sewing.Finish();
  ASSERT_EQ(mesh.links.size(), 1u);
  EXPECT_EQ(mesh.links[0].node, 6);
  EXPECT_EQ(mesh.links[0].edge[0], 13);
  EXPECT_EQ(mesh.links[0].stiffness, kButtonStiffness);
}

}  // namespace
}  // namespace clothid::sewing_test
