// A scene on another grid is the same cloth: same place, same handles, same motion at the start.
#include "datasets/synthetic/regrid.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/expect_error.h"
#include "tests/temporary_folder.h"

namespace clothid::regrid_test {
namespace {

class RegridTest : public testing::Test {
 protected:
  // 5 x 3 nodes on 0.4 m x 0.2 m, with `changes` merged in.
  GridScene Read(const std::string& changes = "{}") const {
    nlohmann::json scene = nlohmann::json::parse(R"({
      "clothid_scene": 1, "duration": 0.1, "time_step": 0.01,
      "mesh": {"grid": {"nodes": [5, 3], "size": [0.4, 0.2], "origin": [1, 2, 3], "axes": [[0, 1, 0], [1, 0, 1]]}},
      "initial": {"velocity": [0.1, 0.2, 0.3]},
      "handles": [0, 1, 2, 3, 4]})");
    scene.merge_patch(nlohmann::json::parse(changes));
    return ReadGridScene(folder_.Write("scene.json", scene.dump()));
  }

  const TemporaryFolder& folder() const { return folder_; }

 private:
  TemporaryFolder folder_;
};

TEST_F(RegridTest, TwiceTheDensityContainsTheNodes) {
  const GridScene coarse = Read();
  EXPECT_EQ(coarse.nodes, (std::array<int, 2>{5, 3}));
  const Scene fine = Regrid(coarse, {9, 5});
  ASSERT_EQ(fine.mesh.num_nodes(), 45);
  for (int i = 0; i < 5; ++i) {
    for (int j = 0; j < 3; ++j) {
      EXPECT_LT(
          (fine.mesh.rest_positions.col(2 * i + 9 * 2 * j) - coarse.scene.mesh.rest_positions.col(i + 5 * j)).norm(),
          1e-14);
    }
  }
  EXPECT_LT((fine.initial_positions - fine.mesh.rest_positions.reshaped()).norm(), 1e-13);
  for (int node = 0; node < 45; ++node) {
    EXPECT_LT((fine.initial_velocities.segment<3>(3 * node) - Eigen::Vector3d(0.1, 0.2, 0.3)).norm(), 1e-14);
  }
}

TEST_F(RegridTest, NodesBetweenHandlesAreHandles) {
  EXPECT_EQ(Regrid(Read(), {9, 5}).handles.nodes, (std::vector<int>{0, 1, 2, 3, 4, 5, 6, 7, 8}));
  EXPECT_EQ(Regrid(Read(), {3, 2}).handles.nodes, (std::vector<int>{0, 1, 2}));
  // Apart from each other: nothing between them is held.
  EXPECT_EQ(Regrid(Read(R"({"handles": [0, 4]})"), {9, 5}).handles.nodes, (std::vector<int>{0, 8}));
  // Along the second axis: nodes 0 and 5, and what lies between.
  EXPECT_EQ(Regrid(Read(R"({"handles": [5, 0]})"), {9, 5}).handles.nodes, (std::vector<int>{0, 9, 18}));
}

TEST_F(RegridTest, HandlesKeepTheirPath) {
  folder().Write("path.csv",
                 "time,x0,y0,z0,x1,y1,z1\n"
                 "0,1,2,3,1,2.1,3\n"
                 "0.1,1,2,5,1,2.1,9\n");
  const GridScene coarse = Read(R"({"handles": {"nodes": [0, 1], "path": "path.csv"}})");
  const Scene fine = Regrid(coarse, {9, 5});
  EXPECT_EQ(fine.handles.nodes, (std::vector<int>{0, 1, 2}));
  const Eigen::VectorXd end = fine.handles.path.At(0.1);
  EXPECT_NEAR(end[2], 5.0, 1e-12);
  EXPECT_NEAR(end[5], 7.0, 1e-12);
  EXPECT_NEAR(end[8], 9.0, 1e-12);
  EXPECT_NEAR(end[4], 2.05, 1e-12);
}

TEST_F(RegridTest, PointsStayWhereTheyAre) {
  const GridScene grid = Read();
  const Scene other = Regrid(grid, {8, 4});  // has no node in common but the corners
  const std::vector<ObservedPoint> points = PlaceOnMesh(other.mesh, grid.scene.mesh.rest_positions);
  const Eigen::VectorXd placed = Interpolate(points, other.mesh.rest_positions.reshaped());
  EXPECT_LT((placed - grid.scene.mesh.rest_positions.reshaped()).norm(), 1e-13);
  EXPECT_EQ(points[0].num_nodes, 1);
  EXPECT_EQ(points[0].nodes[0], 0);
  EXPECT_EQ(points[1].num_nodes, 3);
}

TEST_F(RegridTest, RefusesWhatIsNotTheSameCloth) {
  ExpectError(
      [&] {
        Regrid(Read(R"({"handles": [1]})"), {3, 2});
      },
      ErrorKind::kUsage, {"--nodes", "3 x 2", "handle 1"});
  ExpectError([&] { Read(R"({"node_force": [0, 0, 0.1]})"); }, ErrorKind::kBadData, {"scene.json", "node_force"});
  ExpectError([&] { Read(R"({"pieces": {"a": {"triangles": [0]}}})"); }, ErrorKind::kBadData, {"'pieces'", "none"});
  folder().Write("cloth.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  ExpectError([&] { Read(R"({"mesh": {"grid": null, "obj": "cloth.obj"}, "handles": [0]})"); }, ErrorKind::kBadData,
              {"scene.json", "'mesh'", "grid"});
}

}  // namespace
}  // namespace clothid::regrid_test
