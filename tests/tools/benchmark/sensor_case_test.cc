// Recordings of `benchmark coverage --sensor`: each setting has the faults that it says, and no others.
#include "tools/benchmark/fits/sensor_case.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/tools/small_drape.h"
#include "tests/tools/tool_test.h"

namespace clothid::sensor_case_test {
namespace {

constexpr int kNodes = 8;

class SensorCaseTest : public ToolTest {
 protected:
  SensorCaseTest() {
    WriteBytes(folder() / "scene.json", SmallDrape(kNodes));
    WriteBytes(folder() / "sensor.json", R"({"clothid_sensor": 1, "clock_offset": 5, "interval": [0.01, 0.03],
      "pose": {"rotation": [0, 0, 0.6, 0.8], "translation": [1, 2, 3]}, "gaps": [{"after": 0.2, "length": 0.1}],
      "noise": [1e-3, 1e-3, 1e-3], "drop_fraction": 0.02, "flipped_frames": 1})");
    sensor_case_ = ReadSensorCase((folder() / "scene.json").string(), (folder() / "sensor.json").string(),
                                  {{"k_stretch", 70.0, false}});
  }

  // How far the points that are seen are from where they truly were at the recorded times, m.
  Eigen::MatrixXd Errors(const RecordedMotion& motion) const {
    Eigen::MatrixXd errors(motion.num_points(), motion.num_frames());
    for (int frame = 0; frame < motion.num_frames(); ++frame) {
      const Eigen::VectorXd truth = sensor_case_.truth.PointsAt(motion.times[frame]);
      for (int p = 0; p < motion.num_points(); ++p) {
        errors(p, frame) =
            (motion.positions.col(frame).segment<3>(3 * p) - truth.segment<3>(3 * motion.points[p].nodes[0])).norm();
      }
    }
    return errors;
  }

  SensorCase sensor_case_;
};

TEST_F(SensorCaseTest, CleanHasNoiseAlone) {
  const RecordedMotion motion = RecordSensorCase(sensor_case_, "clean", 1);
  ASSERT_GE(motion.num_frames(), 20);  // of 0.4 s at the mean interval
  EXPECT_LT((motion.times - Eigen::VectorXd::LinSpaced(motion.num_frames(), 0.0, 0.02 * (motion.num_frames() - 1)))
                .cwiseAbs()
                .maxCoeff(),
            1e-9);
  EXPECT_EQ(motion.sigma_source, SigmaSource::kEstimated);
  EXPECT_LT(Errors(motion).maxCoeff(), 0.006);
  EXPECT_TRUE(motion.positions == RecordSensorCase(sensor_case_, "clean", 1).positions);
  EXPECT_FALSE(motion.positions == RecordSensorCase(sensor_case_, "clean", 2).positions);
}

TEST_F(SensorCaseTest, FaultsAreThoseOfTheSensor) {
  const RecordedMotion motion = RecordSensorCase(sensor_case_, "faults", 1);
  const Eigen::MatrixXd errors = Errors(motion);
  EXPECT_GT(errors.array().isNaN().count(), 0);
  EXPECT_LT(errors.array().isNaN().select(0.0, errors).maxCoeff(), 0.006);  // the flipped frame was left out
  double longest = 0.0;
  for (int frame = 1; frame < motion.num_frames(); ++frame) {
    longest = std::max(longest, motion.times[frame] - motion.times[frame - 1]);
  }
  EXPECT_GE(longest, 0.1);
}

TEST_F(SensorCaseTest, OnePointInTwentyIsFarOff) {
  for (const char* setting : {"huber", "outliers"}) {
    const Eigen::MatrixXd errors = Errors(RecordSensorCase(sensor_case_, setting, 1));
    EXPECT_NEAR(static_cast<double>((errors.array() > 0.02).count()) / static_cast<double>(errors.size()), 0.05, 0.025);
  }
  EXPECT_TRUE(LossOfSetting("huber").is_robust());
  EXPECT_FALSE(LossOfSetting("outliers").is_robust());
}

TEST_F(SensorCaseTest, MarkersAreOneNodeInTwenty) {
  const RecordedMotion motion = RecordSensorCase(sensor_case_, "markers", 1);
  ASSERT_EQ(motion.num_points(), 4);
  const Eigen::MatrixXd errors = Errors(motion);
  EXPECT_LT(errors.array().isNaN().select(0.0, errors).maxCoeff(), 0.006);
}

}  // namespace
}  // namespace clothid::sensor_case_test
