#include "datasets/synthetic/sensor.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim/base/error.h"
#include "tests/expect_error.h"

namespace clothid::sensor_test {
namespace {

// Four by three points that all move with 1 m/s along x.
class SensorTest : public testing::Test {
 protected:
  SensorTest() {
    motion_.start = 0.5;
    motion_.end = 10.5;
    motion_.grid = {4, 3};
    motion_.points_at = [](double time) {
      Eigen::Matrix3Xd points(3, 12);
      for (int i = 0; i < 12; ++i) points.col(i) << time + i % 4, i / 4, 2.0;
      return Eigen::VectorXd(points.reshaped());
    };
  }

  static Eigen::Array<bool, 1, Eigen::Dynamic> Unseen(const PointTracks& tracks) {
    return tracks.positions.reshaped(3, tracks.positions.size() / 3).colwise().sum().array().isNaN();
  }

  SeenMotion motion_;
};

TEST_F(SensorTest, ReadsForcesWhereItSaysSo) {
  EXPECT_FALSE(ParseSensor(R"({"clothid_sensor": 1})", "sensor.json").force_sensor);
  const Sensor sensor = ParseSensor(
      R"({"clothid_sensor": 1, "forces": {"rate": 100, "noise": 0.02, "bias": [1, 2, 3], "clock_offset": 0.5}})",
      "sensor.json");
  ASSERT_TRUE(sensor.force_sensor);
  EXPECT_EQ(sensor.force_sensor->rate, 100.0);
  EXPECT_EQ(sensor.force_sensor->sigma, 0.02);
  EXPECT_EQ(sensor.force_sensor->bias, Eigen::Vector3d(1.0, 2.0, 3.0));
  EXPECT_EQ(sensor.force_clock_offset, 0.5);
}

TEST_F(SensorTest, AFaultlessOneSeesThePointsAtItsRate) {
  const PointTracks tracks = SeePoints({}, motion_, 1);
  ASSERT_EQ(tracks.num_points(), 12);
  ASSERT_NEAR(tracks.num_frames(), 101, 1);
  for (int frame = 0; frame < tracks.num_frames(); ++frame) {
    EXPECT_NEAR(tracks.times[frame], 0.5 + 0.1 * frame, 1e-12);
    EXPECT_EQ(tracks.positions.col(frame), motion_.points_at(tracks.times[frame]));
  }
}

TEST_F(SensorTest, HasAFrameOfReferenceAndAClockOfItsOwn) {
  Sensor sensor;
  sensor.pose = Eigen::Translation3d(1.0, 2.0, 3.0) * Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 2) / 3.0);
  sensor.clock_offset = 100.0;
  const PointTracks seen = SeePoints(sensor, motion_, 1), exact = SeePoints({}, motion_, 1);
  EXPECT_LE((seen.times.array() - 100.0 - exact.times.array()).abs().maxCoeff(), 1e-12);
  const Eigen::Matrix3Xd in_camera = seen.positions.reshaped(3, seen.positions.size() / 3);
  const Eigen::Matrix3Xd back = sensor.pose * in_camera;
  EXPECT_LE((back.reshaped() - exact.positions.reshaped()).cwiseAbs().maxCoeff(), 1e-12);
}

TEST_F(SensorTest, FramesComeAtIrregularTimesWithGaps) {
  Sensor sensor;
  sensor.interval = {0.08, 0.125};
  sensor.gaps = {{4.0, 0.8}};
  const Eigen::VectorXd times = SeePoints(sensor, motion_, 3).times;
  const Eigen::VectorXd intervals = times.tail(times.size() - 1) - times.head(times.size() - 1);
  EXPECT_EQ(times[0], motion_.start);
  EXPECT_GE(intervals.minCoeff(), 0.08);
  EXPECT_GE(intervals.maxCoeff(), 0.8);
  EXPECT_LE(intervals.maxCoeff(), 0.8 + 0.25);
  EXPECT_EQ((intervals.array() > 0.125).count(), 1);
  EXPECT_GT((intervals.array() - intervals[0]).abs().maxCoeff(), 0.01);
  EXPECT_NE(SeePoints(sensor, motion_, 4).times[1], times[1]);
}

TEST_F(SensorTest, NoiseHasTheDeviationsOfTheCamerasAxes) {
  Sensor sensor;
  sensor.noise = {0.04, 0.02, 0.01};
  const PointTracks seen = SeePoints(sensor, motion_, 1), exact = SeePoints({}, motion_, 1);
  const Eigen::Array3Xd noise = (seen.positions - exact.positions).reshaped(3, seen.positions.size() / 3).array();
  const double num_values = static_cast<double>(noise.cols());
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(std::sqrt(noise.row(axis).square().mean()), sensor.noise[axis],
                4.0 * sensor.noise[axis] / std::sqrt(2.0 * num_values));
  }
}

TEST_F(SensorTest, OutliersAndDropsSpareTheFirstFrame) {
  Sensor sensor;
  sensor.drop_fraction = 0.2;
  sensor.outlier_fraction = 0.1;
  sensor.outlier_distance = 0.5;
  const PointTracks seen = SeePoints(sensor, motion_, 5), exact = SeePoints({}, motion_, 5);
  const auto unseen = Unseen(seen);
  const double num_points = static_cast<double>(unseen.size());
  EXPECT_NEAR(static_cast<double>(unseen.count()) / num_points, 0.2, 4.0 * std::sqrt(0.16 / num_points));
  int num_outliers = 0;
  for (int i = 0; i < unseen.size(); ++i) {
    const double distance = (seen.positions.reshaped() - exact.positions.reshaped()).segment<3>(3 * i).norm();
    if (!unseen[i] && distance > 0.0) ++num_outliers;
  }
  const double num_seen = num_points - static_cast<double>(unseen.count());
  EXPECT_NEAR(num_outliers / num_seen, 0.1, 4.0 * std::sqrt(0.09 / num_seen));
  EXPECT_EQ(seen.positions.col(0), exact.positions.col(0));
}

TEST_F(SensorTest, OneFaultDoesNotChangeAnother) {
  Sensor noise;
  noise.noise.setConstant(0.01);
  Sensor all = noise;
  all.drop_fraction = 0.3;
  all.num_flipped_frames = 0;
  const PointTracks first = SeePoints(noise, motion_, 2), second = SeePoints(all, motion_, 2);
  const auto unseen = Unseen(second);
  for (int i = 0; i < unseen.size(); ++i) {
    if (unseen[i]) continue;
    EXPECT_EQ(first.positions.reshaped().segment<3>(3 * i), second.positions.reshaped().segment<3>(3 * i)) << i;
  }
}

TEST_F(SensorTest, FlippedFramesHaveTheirRowsInReverse) {
  Sensor sensor;
  sensor.num_flipped_frames = 7;
  const PointTracks seen = SeePoints(sensor, motion_, 1), exact = SeePoints({}, motion_, 1);
  int num_flipped = 0;
  for (int frame = 0; frame < seen.num_frames(); ++frame) {
    if (seen.positions.col(frame) == exact.positions.col(frame)) continue;
    ++num_flipped;
    for (int j = 0; j < 3; ++j) {
      EXPECT_EQ(seen.positions.col(frame).segment(12 * j, 12), exact.positions.col(frame).segment(12 * (2 - j), 12));
    }
  }
  EXPECT_EQ(num_flipped, 7);
  EXPECT_EQ(seen.positions.col(0), exact.positions.col(0));
}

TEST_F(SensorTest, TheGripperTellsItsPathOnItsOwnClock) {
  Sensor sensor;
  sensor.gripper_rate = 20.0;
  sensor.gripper_clock_offset = -3.0;
  const Eigen::VectorXd knots = Eigen::VectorXd::LinSpaced(11, 0.0, 1.0);
  Eigen::MatrixXd positions(3, 11);
  for (int i = 0; i < 11; ++i) positions.col(i) << knots[i], 0.0, 1.0;
  const HandlePath path(knots, positions);
  const PointTracks tracks = SeeHandles(sensor, path, 0.0, 1.0, 1);
  EXPECT_LT(tracks.times[0], -3.0);
  EXPECT_GT(tracks.times[tracks.times.size() - 1], -2.0);
  for (int i = 0; i < tracks.num_frames(); ++i) {
    EXPECT_LE((tracks.positions.col(i) - path.At(tracks.times[i] + 3.0)).norm(), 1e-12);
  }
  sensor.gripper_noise = 1e-3;
  EXPECT_NE(SeeHandles(sensor, path, 0.0, 1.0, 1).positions, tracks.positions);
}

TEST_F(SensorTest, ReadsEveryKey) {
  const Sensor sensor = ParseSensor(R"({
    "clothid_sensor": 1, "pose": {"rotation": [1, 0, 0, 0], "translation": [1, 2, 3]}, "clock_offset": 5,
    "interval": [0.08, 0.12], "gaps": [{"after": 1, "length": 0.8}], "noise": [0.004, 0.003, 0.001],
    "drop_fraction": 0.002, "outlier_fraction": 0.05, "outlier_distance": 0.2, "flipped_frames": 3,
    "gripper": {"rate": 50, "noise": 2e-4, "clock_offset": 7}})",
                                    "sensor.json");
  EXPECT_LE((sensor.pose * Eigen::Vector3d(1, 1, 1) - Eigen::Vector3d(2, 1, 2)).norm(), 1e-15);
  EXPECT_EQ(sensor.clock_offset, 5.0);
  EXPECT_EQ(sensor.interval, (std::array<double, 2>{0.08, 0.12}));
  ASSERT_EQ(sensor.gaps.size(), 1u);
  EXPECT_EQ(sensor.gaps[0].length, 0.8);
  EXPECT_EQ(sensor.noise, Eigen::Vector3d(0.004, 0.003, 0.001));
  EXPECT_EQ(sensor.drop_fraction, 0.002);
  EXPECT_EQ(sensor.outlier_fraction, 0.05);
  EXPECT_EQ(sensor.outlier_distance, 0.2);
  EXPECT_EQ(sensor.num_flipped_frames, 3);
  EXPECT_EQ(sensor.gripper_rate, 50.0);
  EXPECT_EQ(sensor.gripper_noise, 2e-4);
  EXPECT_EQ(sensor.gripper_clock_offset, 7.0);
}

TEST_F(SensorTest, NamesWhatItCannotRead) {
  const auto parse = [](const std::string& members) {
    return [members] { ParseSensor("{\"clothid_sensor\": 1,\n" + members + "}", "sensor.json"); };
  };
  ExpectError(parse("\"nose\": 1"), ErrorKind::kBadData, {"sensor.json:2", "nose"});
  ExpectError(parse("\"noise\": [0, -1, 0]"), ErrorKind::kBadData, {"sensor.json:2", "noise", ">= 0"});
  ExpectError(parse("\"interval\": [0.1, 0.05]"), ErrorKind::kBadData, {"interval", "in this order"});
  ExpectError(parse("\"interval\": [1e-9, 0.05]"), ErrorKind::kBadData, {"interval", "1e-5"});
  ExpectError(parse("\"drop_fraction\": 1"), ErrorKind::kBadData, {"drop_fraction", "[0, 1)"});
  ExpectError(parse("\"pose\": {\"rotation\": [1, 1, 0, 0]}"), ErrorKind::kBadData, {"pose.rotation", "length 1"});
  ExpectError(parse("\"gaps\": [{\"after\": 1}]"), ErrorKind::kBadData, {"gaps[0]", "length"});
  ExpectError(parse("\"gripper\": {\"rate\": 0}"), ErrorKind::kBadData, {"gripper.rate"});
  ExpectError(parse("\"forces\": {\"noise\": 1}"), ErrorKind::kBadData, {"forces", "rate"});
  ExpectError(parse("\"forces\": {\"rate\": 10, \"bias\": 1}"), ErrorKind::kBadData, {"forces.bias"});
  ExpectError([] { ParseSensor("{}", "sensor.json"); }, ErrorKind::kBadData, {"clothid_sensor"});
}

TEST_F(SensorTest, RefusesASensorThatSeesTooLittle) {
  Sensor slow;
  slow.interval = {20.0, 20.0};
  ExpectError([&] { SeePoints(slow, motion_, 1); }, ErrorKind::kUsage, {"less than two frames"});
  Sensor flipping;
  flipping.num_flipped_frames = 1000;
  ExpectError([&] { SeePoints(flipping, motion_, 1); }, ErrorKind::kUsage, {"flips 1000 frames"});
}

}  // namespace
}  // namespace clothid::sensor_test
