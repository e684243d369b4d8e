// Motion capture's TRC files as other programs write them.
#include "datasets/formats/trc_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "tests/expect_error.h"
#include "tests/temporary_folder.h"

namespace clothid::trc_file_test {
namespace {

using Labels = std::vector<std::string>;

constexpr char kNames[] =
    "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\n";

// As a capture system writes it: two markers in mm at 60 Hz, trailing tabs, carriage returns, times to three decimals.
std::string Capture(const std::string& values = "60.00\t60.00\t3\t2\tmm\t60.00\t1\t3",
                    const std::string& labels = "Frame#\tTime\tLeft Hand\t\t\tcorner\t\t\t",
                    const std::string& rows =
                        "1\t0.000\t100.5\t-200\t3e2\t1\t2\t3\t\r\n"
                        "2\t0.017\t\t\t\t4\t5\t6\t\r\n"
                        "3\t0.033\t101\t-201\t301\t7\t\t9\t\r\n") {
  return "PathFileType\t4\t(X/Y/Z)\tC:\\capture\\trial 1.trc\r\n" + std::string(kNames) + values + "\r\n" + labels +
         "\r\n\t\tX1\tY1\tZ1\tX2\tY2\tZ2\t\r\n\r\n" + rows;
}

class TrcFileTest : public testing::Test {
 protected:
  PointTracks Read(const std::string& text) const { return ReadTrc(folder_.Write("trial.trc", text)); }
  void ExpectRefused(const std::string& text, std::initializer_list<const char*> fragments) const {
    ExpectError([&] { Read(text); }, ErrorKind::kBadData, fragments);
  }

  TemporaryFolder folder_;
};

TEST_F(TrcFileTest, ReadsACaptureInMillimetres) {
  const PointTracks tracks = Read(Capture());
  EXPECT_EQ(tracks.labels, (Labels{"Left Hand", "corner"}));
  EXPECT_EQ(tracks.times, Eigen::Vector3d(0.0, 0.017, 0.033));
  EXPECT_EQ(tracks.positions.col(0), (Eigen::VectorXd(6) << 0.1005, -0.2, 0.3, 0.001, 0.002, 0.003).finished());
  EXPECT_TRUE(tracks.positions.col(1).head(3).array().isNaN().all());
  EXPECT_EQ(tracks.positions(5, 1), 0.006);
  EXPECT_TRUE(std::isnan(tracks.positions(4, 2)));
}

TEST_F(TrcFileTest, ReadsOtherUnitsAndLayouts) {
  EXPECT_EQ(Read(Capture("60 60 3 2 m 60 1 3")).positions(3, 0), 1.0);
  EXPECT_EQ(Read(Capture("60 60 3 2 Centimeters 60 1 3")).positions(3, 0), 0.01);
  // Padded with blanks, a frame that starts at 0, no empty line, no tab at the ends.
  const PointTracks tracks = Read("PathFileType  4\t(X/Y/Z) out/\n" + std::string(kNames) +
                                  "   30.0\t\t   30.0\t\t      2\t\t      1\t\t mm\t   30.0\t      1\t      2\n"
                                  "Frame#\tTime\twrist\n\t\tX1\tY1\tZ1\n0\t1.0\t1\t2\t3\n1\t1.0333333\t4\t5\t6");
  EXPECT_EQ(tracks.labels, Labels{"wrist"});
  EXPECT_EQ(tracks.positions(2, 1), 0.006);
}

TEST_F(TrcFileTest, ReportsWhatDisagreesByLine) {
  const auto rows = [](const std::string& text) {
    return Capture("60 60 3 2 mm 60 1 3", "Frame#\tTime\ta\t\t\tb", text);
  };
  ExpectRefused(Capture("60 60 4 2 mm 60 1 4"), {"trial.trc:10: expected a row", "NumFrames of line 3 is 4, found 3"});
  ExpectRefused(Capture("60 60 2 2 mm 60 1 2"), {"trial.trc:9: expected no further row"});
  ExpectRefused(Capture("60 60 3 3 mm 60 1 3"), {"trial.trc:4: found 2 labels, expected 3"});
  ExpectRefused(Capture("120 120 3 2 mm 120 1 3"), {"trial.trc:3: DataRate is 120", "make it 60.6"});
  ExpectRefused(rows("1\t0\t1\t2\t3\t4\t5\t6\n2\t0.017\t1\t2\t3\t4\t5\n"),
                {"trial.trc:8: expected 8 cells", "found 7"});
  ExpectRefused(rows("1\t0\t1\t2\t3\t4\t5\t6\t7\n"), {"trial.trc:7: expected 8 cells", "found 9"});
  ExpectRefused(rows("1\t0\t1\t2\tthree\t4\t5\t6\n"), {"trial.trc:7: Z of 'a'", "'three'"});
  ExpectRefused(rows("1\t0\t1\t2\t3\t4\tinf\t6\n"), {"trial.trc:7: Y of 'b'", "'inf'"});
  ExpectRefused(rows("1\tlate\t1\t2\t3\t4\t5\t6\n"), {"trial.trc:7: expected the time, found 'late'"});
  ExpectRefused(rows("1\t0\t1\t2\t3\t4\t5\t6\n2\t0\t1\t2\t3\t4\t5\t6\n"), {"trial.trc:8: expected times to increase"});
  ExpectRefused(rows("2\t0\t1\t2\t3\t4\t5\t6\n1\t1\t1\t2\t3\t4\t5\t6\n"), {"trial.trc:8: expected frame numbers"});
}

TEST_F(TrcFileTest, ReadsDecimalCommasAndQuotesAndNamesTabsThatAreGone) {
  const auto rows = [](const std::string& text) {
    return Capture("60,0 60 2 2 mm 60 1 2", "Frame#\tTime\ta\t\t\tb", text);
  };
  const PointTracks tracks = Read(rows("1\t0,000\t1,5\t2\t3\t4\t5\t\"6\"\n2\t0,017\t1\t2\t3\t4\tnan\t6\n"));
  EXPECT_EQ(tracks.times[1], 0.017);
  EXPECT_EQ(tracks.positions(0, 0), 0.0015);
  EXPECT_EQ(tracks.positions(5, 0), 0.006);
  ExpectRefused(rows("1\t0,000\t1,5\t2\t3\t4\t5\t6\n2\t0,017\t1.5\t2\t3\t4\t5\t6\n"),
                {"trial.trc:8: X of 'a'", "'1.5'; the numbers before it have ','"});
  ExpectRefused(rows("1 0 1 2 3 4 5 6\n"), {"trial.trc:7: expected 8 cells", "found 1; did an editor turn its tabs"});
  ExpectRefused(Capture("60 60 3 2 mm", "Frame# Time a b"), {"trial.trc:4: found 1 labels", "turn its tabs"});
}

TEST_F(TrcFileTest, RefusesBadHeaders) {
  ExpectRefused("", {"trial.trc:1: expected PathFileType"});
  ExpectRefused("t,id,x,y,z\n", {"trial.trc:1: is not a TRC file"});
  ExpectRefused("PathFileType\t3\t(X/Y/Z)\n", {"trial.trc:1: expected 'PathFileType 4"});
  ExpectRefused("PathFileType\t4\t(X/Y/Z)\tx\n", {"trial.trc:2: expected DataRate"});
  ExpectRefused("PathFileType\t4\t(X/Y/Z)\tx\nDataRate\n60\n", {"trial.trc:2: expected NumFrames"});
  ExpectRefused(Capture("60 60 3 2"), {"trial.trc:3: the value of Units is missing"});
  ExpectRefused(Capture("0 60 3 2 mm"), {"trial.trc:3: expected DataRate > 0"});
  ExpectRefused(Capture("nan 60 3 2 mm"), {"trial.trc:3: expected DataRate > 0"});
  ExpectRefused(Capture("60 60 inf 2 mm"), {"trial.trc:3: expected NumFrames", "'inf'"});
  ExpectRefused(Capture("60 60 3 0 mm"), {"trial.trc:3: expected NumMarkers"});
  ExpectRefused(Capture("60 60 3 99999999999 mm"), {"trial.trc:3: expected NumMarkers"});
  ExpectRefused(Capture("60 60 3 2 ft"), {"trial.trc:3: expected Units m, cm or mm, found 'ft'"});
  ExpectRefused(Capture("60 60 9999999 2 mm"), {"trial.trc:3: the rows end before NumFrames"});
  ExpectRefused(Capture("60 60 3 2 mm", "Time\tFrame#"), {"trial.trc:4: expected Frame#"});
}

TEST_F(TrcFileTest, ReadsBackExactlyWhatItWrites) {
  PointTracks tracks;
  tracks.name = "test";
  tracks.times = Eigen::Vector3d(0.1, 0.1 + 1.0 / 3.0, 7.0);
  tracks.positions = Eigen::MatrixXd::Random(6, 3) / 3.0;
  tracks.positions(4, 1) = std::numeric_limits<double>::quiet_NaN();
  tracks.positions.col(2).setConstant(std::numeric_limits<double>::quiet_NaN());
  const PointTracks again = Read(TrcText(tracks));
  EXPECT_EQ(again.times, tracks.times);
  EXPECT_EQ(again.labels, (Labels{"point_0", "point_1"}));
  EXPECT_EQ(again.positions.col(0), tracks.positions.col(0));
  EXPECT_TRUE(std::isnan(again.positions(4, 1)));
  EXPECT_EQ(again.positions(5, 1), tracks.positions(5, 1));
  EXPECT_TRUE(again.positions.col(2).array().isNaN().all());
  tracks.labels = {"Left Hand", "7"};
  EXPECT_EQ(Read(TrcText(tracks)).labels, tracks.labels);
}

TEST_F(TrcFileTest, RefusesToWriteWhatItCouldNotReadBack) {
  PointTracks tracks;
  tracks.name = "test";
  tracks.positions = Eigen::MatrixXd::Zero(3, 1);
  const auto expect = [&](std::initializer_list<const char*> fragments) {
    ExpectError([&] { TrcText(tracks); }, ErrorKind::kUsage, fragments);
  };
  expect({"test: has no times"});
  tracks.times = Eigen::VectorXd::Zero(1);
  EXPECT_EQ(Read(TrcText(tracks)).num_frames(), 1);
  tracks.labels = {"a\tb"};
  expect({"test: label 'a?b' holds control characters"});
  tracks.labels = {" a"};
  expect({"test: label ' a' has blanks at its ends"});
}

}  // namespace
}  // namespace clothid::trc_file_test
