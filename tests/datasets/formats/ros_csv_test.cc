#include "datasets/formats/ros_csv.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "datasets/importing/transform_file.h"
#include "tests/expect_error.h"
#include "tests/temporary_folder.h"

namespace clothid::ros_csv_test {
namespace {

constexpr ErrorKind kBadData = ErrorKind::kBadData;

constexpr char kGridHeader[] =
    "%time,field.header.seq,field.header.stamp,field.header.frame_id,field.size,field.x0,field.x1,field.x2,field.x3,"
    "field.y0,field.y1,field.y2,field.y3,field.z0,field.z1,field.z2,field.z3\n";
constexpr char kFirstRow[] = "1000000500,7,1000000000,camera,2,0,1,2,3,10,11,12,13,20,21,22,23\n";
constexpr char kSecondRow[] = "1100000500,8,1250000000,camera,2,0.5,nan,2,3,10,11,-inf,13,20,21,22,-2.5e-1\n";

constexpr char kPoseHeader[] =
    "%time,field.position.x,field.position.y,field.position.z,field.orientation.x,field.orientation.y,"
    "field.orientation.z,field.orientation.w\n";

class RosCsvTest : public testing::Test {
 protected:
  std::string Write(const std::string& text) const { return folder_.Write("ros.csv", text); }

  void ExpectBadGrid(const std::string& text, std::initializer_list<const char*> fragments) const {
    const std::string path = Write(text);
    ExpectError([&] { ReadRosGrid(path); }, kBadData, fragments);
  }

  void ExpectBadPoses(const std::string& text, std::initializer_list<const char*> fragments) const {
    const std::string path = Write(text);
    ExpectError([&] { ReadRosPoses(path); }, kBadData, fragments);
  }

  TemporaryFolder folder_;
};

TEST_F(RosCsvTest, ReadsAGrid) {
  const PointTracks tracks = ReadRosGrid(Write(std::string(kGridHeader) + kFirstRow + kSecondRow));
  ASSERT_EQ(tracks.num_points(), 4);
  ASSERT_EQ(tracks.num_frames(), 2);
  EXPECT_EQ(tracks.times, Eigen::Vector2d(1.0, 1.25));  // the stamps, not the time of printing
  Eigen::VectorXd first(12);
  first << 0, 10, 20, 1, 11, 21, 2, 12, 22, 3, 13, 23;
  EXPECT_EQ(tracks.positions.col(0), first);
  EXPECT_EQ(tracks.positions.col(1).head<3>(), Eigen::Vector3d(0.5, 10, 20));
  EXPECT_EQ(tracks.positions.col(1).array().isNaN().count(), 6);  // two points: a missing coordinate takes all three
  EXPECT_EQ(tracks.positions(11, 1), -0.25);
}

TEST_F(RosCsvTest, TakesThePrintedTimeWithoutAStamp) {
  const PointTracks tracks =
      ReadRosGrid(Write("%time,field.size,field.x0,field.y0,field.z0\n"
                        "1500000000,1,1,2,3\r\n\n1750000000,1,4,5,6"));
  EXPECT_EQ(tracks.times, Eigen::Vector2d(1.5, 1.75));
  EXPECT_EQ(tracks.positions.col(1), Eigen::Vector3d(4, 5, 6));
}

TEST_F(RosCsvTest, RefusesGridsThatAreNone) {
  ExpectError([&] { ReadRosGrid(folder_.File("absent.csv")); }, ErrorKind::kIo, {"absent.csv"});
  ExpectBadGrid("", {"ros.csv: expected the header '%time"});
  ExpectBadGrid("t,id,x,y,z\n", {"ros.csv:1", "%time"});
  ExpectBadGrid(kGridHeader, {"at least one row"});
  ExpectBadGrid("%time,field.x0,field.y0,field.z0\n1,1,2,3\n", {"'field.size'"});
  ExpectBadGrid("%time,field.size,field.y0,field.x0,field.z0\n", {"'field.y0' behind 'field.x0'"});
  ExpectBadGrid("%time,field.size,field.x0,field.y0\n", {"column 5", "'field.z0'"});
  ExpectBadGrid("%time,field.size,field.x0,field.x2,field.y0,field.y1,field.z0,field.z1\n", {"'field.x1'"});
}

TEST_F(RosCsvTest, RefusesBadRowsByLineAndColumn) {
  const std::string good = std::string(kGridHeader) + kFirstRow;
  ExpectBadGrid(good + "1,2,3\n", {"ros.csv:3", "17 cells", "found 3"});
  ExpectBadGrid(good + kFirstRow, {"ros.csv:3", "time after"});
  ExpectBadGrid(good + "1,8,soon,camera,2,0,1,2,3,10,11,12,13,20,21,22,23\n", {":3", "field.header.stamp", "soon"});
  ExpectBadGrid(good + "1,8,-5,camera,2,0,1,2,3,10,11,12,13,20,21,22,23\n", {":3", "ns", "-5"});
  ExpectBadGrid(good + "1,8,2000000000,camera,3,0,1,2,3,10,11,12,13,20,21,22,23\n", {":3", "field.size", "found 3"});
  ExpectBadGrid(good + "1,8,2000000000,camera,2,0,1,2,3,10,1l,12,13,20,21,22,23\n", {":3", "field.y1", "1l"});
  ExpectBadGrid(good + "1,8,2000000000,camera,99999999999,0,1,2,3,10,11,12,13,20,21,22,23\n", {":3", "field.size"});
}

TEST_F(RosCsvTest, ReadsPoses) {
  const PoseTrack poses = ReadRosPoses(
      Write(std::string(kPoseHeader) + "1000000000,1,2,3,0,0,0,1\n" + "2000000000,4,5,6,0.7071,0,0,0.7071\n"));
  EXPECT_EQ(poses.times, Eigen::Vector2d(1.0, 2.0));
  EXPECT_EQ(poses.positions.col(1), Eigen::Vector3d(4, 5, 6));
  EXPECT_NEAR(poses.rotations(0, 1), std::sqrt(0.5), 1e-15);
  EXPECT_NEAR(poses.rotations(3, 1), std::sqrt(0.5), 1e-15);
}

TEST_F(RosCsvTest, RefusesBadPoses) {
  const std::string header = kPoseHeader;
  ExpectBadPoses(header, {"at least one row"});
  ExpectBadPoses(kGridHeader, {"position.x"});
  ExpectBadPoses("%time,a.position.x,b.position.x\n", {"two"});
  ExpectBadPoses(header + "1,1,2,3,0,0,0,2\n", {":2", "unit length"});
  ExpectBadPoses(header + "1,1,nan,3,0,0,0,1\n", {":2", "position.y", "finite"});
}

TEST_F(RosCsvTest, TakesTheLastPoseForATransform) {
  const Eigen::Isometry3d transform = ReadTransform(
      Write(std::string(kPoseHeader) + "1000000000,9,9,9,0,0,0,1\n2000000000,1,2,3,0,0,0.70710678118654752,"
                                       "0.70710678118654752\n"));
  EXPECT_TRUE((transform * Eigen::Vector3d(1, 0, 0)).isApprox(Eigen::Vector3d(1, 3, 3), 1e-14));
}

TEST_F(RosCsvTest, ReadsTransformsFromJson) {
  const auto read = [&](const std::string& text) { return ReadTransform(folder_.Write("transform.json", text)); };
  const Eigen::Vector3d place(1, 2, 3), turned(-2, 1, 3);
  EXPECT_EQ(read(R"({"matrix": [[0,-1,0,4],[1,0,0,5],[0,0,1,6],[0,0,0,1]]})") * place,
            turned + Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(read(R"({"matrix": [0,-1,0,4, 1,0,0,5, 0,0,1,6, 0,0,0,1]})") * place, turned + Eigen::Vector3d(4, 5, 6));
  EXPECT_TRUE((read(R"({"rotation": [0, 0, 0.7071068, 0.7071068]})") * place).isApprox(turned, 1e-12));
  EXPECT_EQ(read(R"({"translation": [1, 1, 1]})") * place, Eigen::Vector3d(2, 3, 4));
  EXPECT_TRUE(read(R"({"matrix": [0,-1.0004,0,4, 1,0,0,5, 0,0,1,6, 0,0,0,1]})").linear().isUnitary(1e-14));
}

TEST_F(RosCsvTest, RefusesTransformsThatAreNotRigid) {
  const auto expect_bad = [&](const std::string& text, std::initializer_list<const char*> fragments) {
    const std::string path = folder_.Write("transform.json", text);
    ExpectError([&] { ReadTransform(path); }, kBadData, fragments);
  };
  expect_bad("{}", {"transform.json:1", "either"});
  expect_bad(R"({"matrix": [1, 2, 3]})", {"matrix", "four rows"});
  expect_bad(R"({"matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0]]})", {"matrix[3]", "4 numbers"});
  expect_bad(R"({"matrix": [2,0,0,0, 0,2,0,0, 0,0,2,0, 0,0,0,1]})", {"scales"});
  expect_bad(R"({"matrix": [-1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]})", {"mirrors"});
  expect_bad(R"({"matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 1,0,0,1]})", {"last row"});
  expect_bad(R"({"rotation": [0, 0, 0, 0]})", {"unit length"});
  expect_bad(R"({"rotation": [0, 0, 0, 1], "matrix": []})", {"either"});
}

}  // namespace
}  // namespace clothid::ros_csv_test
