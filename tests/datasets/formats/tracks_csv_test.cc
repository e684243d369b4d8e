// Tables with a row per time and point.
#include "datasets/formats/tracks_csv.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "tests/expect_error.h"
#include "tests/temporary_folder.h"

namespace clothid::tracks_csv_test {
namespace {

using Labels = std::vector<std::string>;

class TracksCsvTest : public testing::Test {
 protected:
  PointTracks Read(const std::string& text) const { return ReadTracksCsv(folder_.Write("tracks.csv", text)); }
  void ExpectRefused(const std::string& text, std::initializer_list<const char*> fragments) const {
    ExpectError([&] { Read(text); }, ErrorKind::kBadData, fragments);
  }

  TemporaryFolder folder_;
};

TEST_F(TracksCsvTest, ReadsColumnsByName) {
  const PointTracks tracks = Read("x,quality,id,t,z,y\r\n1,good,a,0.5,3,2\r\n4,,\"b, \"\"B\"\"\",0.5,6,5\r\n");
  EXPECT_EQ(tracks.times, Eigen::VectorXd::Constant(1, 0.5));
  EXPECT_EQ(tracks.labels, (Labels{"a", "b, \"B\""}));
  EXPECT_EQ(tracks.positions.col(0), (Eigen::VectorXd(6) << 1, 2, 3, 4, 5, 6).finished());
  EXPECT_EQ(tracks.faces.cols(), 0);
}

TEST_F(TracksCsvTest, SortsTimesAndIds) {
  const PointTracks numbers = Read("\xef\xbb\xbft,id,x,y,z\n2,10,5,0,0\n2,9,4,0,0\n\n1,10,2,0,0\n1,0,1,0,0\n");
  EXPECT_EQ(numbers.times, Eigen::Vector2d(1, 2));
  EXPECT_EQ(numbers.labels, (Labels{"0", "9", "10"}));
  EXPECT_EQ(numbers.positions(0, 0), 1.0);
  EXPECT_EQ(numbers.positions(6, 0), 2.0);
  EXPECT_TRUE(std::isnan(numbers.positions(3, 0)));
  EXPECT_EQ(numbers.positions(3, 1), 4.0);
  EXPECT_EQ(Read("t,id,x,y,z\n0,1,0,0,0\n0,0,0,0,0\n").labels, Labels{});
  EXPECT_EQ(Read("t,id,x,y,z\n0,b,0,0,0\n0,a,0,0,0\n").labels, (Labels{"a", "b"}));
  EXPECT_EQ(Read("t,id,x,y,z\n0,p10,0,0,0\n0,p9,0,0,0\n").labels, (Labels{"p9", "p10"}));
  EXPECT_EQ(Read("t,id,x,y,z\n0,01,0,0,0\n0,0,0,0,0\n").labels, (Labels{"0", "01"}));
}

// Else all nodes after it would be other nodes.
TEST_F(TracksCsvTest, APointThatIsMissingAtFirstKeepsItsPlace) {
  const PointTracks tracks = Read("t,id,x,y,z\n0,n1,1,0,0\n0,n3,3,0,0\n1,n1,1,0,0\n1,n2,2,0,0\n1,n3,3,0,0\n");
  EXPECT_EQ(tracks.labels, (Labels{"n1", "n2", "n3"}));
  EXPECT_EQ(tracks.positions(0, 0), 1.0);
  EXPECT_TRUE(std::isnan(tracks.positions(3, 0)));
  EXPECT_EQ(tracks.positions(6, 0), 3.0);
  EXPECT_EQ(tracks.positions(3, 1), 2.0);
}

TEST_F(TracksCsvTest, TakesEmptyCellsAndNanForMissing) {
  const PointTracks tracks = Read("t,id,x,y,z\n0,0,,nan, NaN \n0,1,1,,3\n");
  EXPECT_TRUE(tracks.positions.col(0).head(3).array().isNaN().all());
  EXPECT_EQ(tracks.positions(3, 0), 1.0);
  EXPECT_TRUE(std::isnan(tracks.positions(4, 0)));
}

// As C3D files tell it.
TEST_F(TracksCsvTest, TakesANegativeResidualForMissing) {
  const PointTracks tracks = Read(
      "t,id,x,y,z,residual\n0,0,0,0,0,-1\n0,1,1,2,3,0.4\n1,0,4,5,6,0\n1,1,7,8,9, -0.5 \n2,0,1,1,1,\n2,1,2,2,2,?\n");
  EXPECT_TRUE(tracks.positions.col(0).head(3).array().isNaN().all());
  EXPECT_TRUE(tracks.positions.col(1).tail(3).array().isNaN().all());
  EXPECT_EQ(tracks.positions.array().isNaN().count(), 6);
  EXPECT_EQ(tracks.positions(3, 0), 1.0);
  EXPECT_EQ(tracks.positions(0, 1), 4.0);
  EXPECT_TRUE(Read("t;id;x;y;z;residual\n0,5;0;0;0;0;-0,5\n0,5;1;1;2;3;0,5\n").positions.col(0).head(3).hasNaN());
}

TEST_F(TracksCsvTest, WritesMissingPointsAsAbsentRows) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  PointTracks tracks;
  tracks.name = "test";
  tracks.times = Eigen::Vector3d(0.0, 0.1, 0.25);
  tracks.labels = {"a", "b,c"};
  tracks.positions.resize(6, 3);
  tracks.positions.col(0) << kNan, kNan, kNan, 0.1, 1.0 / 3.0, -2e-300;
  tracks.positions.col(1) << kNan, kNan, kNan, kNan, kNan, kNan;
  tracks.positions.col(2) << 1, kNan, 3, kNan, kNan, kNan;
  const std::string text = TracksCsvText(tracks);
  EXPECT_EQ(text,
            "t,id,x,y,z\n"
            "0,a,,,\n"
            "0,\"b,c\",0.1,0.3333333333333333,-2e-300\n"
            "0.1,a,,,\n"
            "0.25,a,1,,3\n");
  const PointTracks again = Read(text);
  EXPECT_EQ(again.times, tracks.times);
  EXPECT_EQ(again.labels, tracks.labels);
  EXPECT_TRUE((again.positions.array() == tracks.positions.array() ||
               (again.positions.array().isNaN() && tracks.positions.array().isNaN()))
                  .all());
}

TEST_F(TracksCsvTest, NamesLineAndColumnOfBadCells) {
  ExpectRefused("", {"tracks.csv: expected the header"});
  ExpectRefused("t,id,x,y\n", {"tracks.csv:1: column 'z'", "once in the header"});
  ExpectRefused("t,id,x,y,z,z\n", {"tracks.csv:1: column 'z'"});
  ExpectRefused("time,id,x,y,z\n0,0,0,0,0\n", {"tracks.csv:1: column 't'", "found 'time,id,x,y,z'"});
  ExpectRefused("t,id,x,y,z\n", {"tracks.csv: holds no point"});
  ExpectRefused("t,id,x,y,z\n0,0,1,2\n", {"tracks.csv:2: expected 5 cells", "found 4"});
  ExpectRefused("t,id,x,y,z\n0,0,1,2,3,4\n", {"tracks.csv:2: expected 5 cells", "found 6"});
  ExpectRefused("t,id,x,y,z\n0,0,1,2,3\n0,1,1,two,3\n", {"tracks.csv:3: column 'y'", "'two'"});
  ExpectRefused("t,id,x,y,z\n0,0,1,2,inf\n", {"tracks.csv:2: column 'z'", "'inf'"});
  ExpectRefused("t,id,x,y,z\nnan,0,1,2,3\n", {"tracks.csv:2: column 't'", "'nan'"});
  ExpectRefused("t,id,x,y,z\n0,\"a\"b,1,2,3\n", {"tracks.csv:2: expected quoted cells to end"});
  ExpectRefused("t,id,x,y,z\n0,\"a,1,2,3\n", {"tracks.csv:2: expected quoted cells to end"});
  ExpectRefused("t,id,x,y,z\n0,,1,2,3\n", {"tracks.csv:2: column 'id'", "found nothing"});
  ExpectRefused("t,id,x,y,z\n0,0,1,2,3\n0,0,1,2,3\n", {"tracks.csv:3: column 'id'", "'0' has two rows"});
  ExpectRefused("t,id,x,y,z\n0,0,1,2,3\n1,0,1,2,3\n0,1,1,2,3\n", {"tracks.csv:4: column 't'", "line 2"});
  ExpectError([&] { ReadTracksCsv(folder_.File("absent.csv")); }, ErrorKind::kIo, {"absent.csv: cannot be read"});
}

TEST_F(TracksCsvTest, RefusesToWriteWhatItCouldNotReadBack) {
  PointTracks tracks;
  tracks.name = "test";
  tracks.positions = Eigen::MatrixXd::Zero(6, 1);
  const auto expect = [&](std::initializer_list<const char*> fragments) {
    ExpectError([&] { TracksCsvText(tracks); }, ErrorKind::kUsage, fragments);
  };
  expect({"test: has no times"});
  tracks.times = Eigen::VectorXd::Zero(1);
  EXPECT_NO_THROW(TracksCsvText(tracks));
  tracks.labels = {"a", "a"};
  expect({"test: two points are called 'a'"});
  tracks.labels = {"a", "b\n"};
  expect({"test: label 'b?' holds control characters"});
  tracks.labels = {"a", ""};
  expect({"test: a point has an empty label"});
}

}  // namespace
}  // namespace clothid::tracks_csv_test
