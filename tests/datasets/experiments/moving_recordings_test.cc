// The recordings of cloth on bodies that move and of cloth that meets itself: with the truth that datasets/README.md
// states the scene predicts them to within their noise, and far less well with its nominal values.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "datasets/motion/motion_file.h"
#include "datasets/synthetic/true_parameters.h"
#include "sim/base/text_file.h"
#include "sim/rollout/rollout.h"
#include "sim/rollout/simulator.h"
#include "sim/scene/scene_json.h"

namespace clothid::moving_recordings_test {
namespace {

const std::string kDatasets = std::string(CLOTHID_SOURCE_DIR) + "/datasets/";
struct Recording {
  const char *name, *scene, *truth;
  std::map<std::string, double> values;
  double model_error;    // m, at most: root mean square of a coordinate that the scene's own steps miss
  double noise = 0.002;  // m
};

const Recording kRecordings[] = {
    {"pull", "pull", "mu.table=0.4,k_stretch=25", {{"mu.table", 0.4}, {"k_stretch", 25.0}}, 1.4e-3},
    {"sleeve", "garment/sleeve", "mu=0.3,k_stretch=25", {{"mu", 0.3}, {"k_stretch", 25.0}}, 2e-4},
    {"shirt", "garment/worn_shirt", "mu=0.3,k_stretch=150", {{"mu", 0.3}, {"k_stretch", 150.0}}, 6e-4},
    {"slide", "folding/slide", "mu.self=0.2,k_stretch=40", {{"mu.self", 0.2}, {"k_stretch", 40.0}}, 2e-4, 0.001},
    {"shake", "folding/shake", "mu.self=0.2,k_stretch=40", {{"mu.self", 0.2}, {"k_stretch", 40.0}}, 4e-4, 0.001},
};

// Root mean square of a coordinate over all frames, m, by which a rollout with these parameters misses the recording
// beyond its noise. Frames lie a whole number of steps apart.
double Misses(const RecordedMotion& motion, double noise, const std::map<std::string, double>& values) {
  Scene scene = motion.scene;
  const Parameters parameters = SetTrueParameters(values, "--set", motion.name, &scene);
  Simulator simulator(scene);
  const Rollout rollout = Simulate(parameters, scene.num_steps(), &simulator);
  EXPECT_TRUE(rollout.ok());
  double sum = 0.0;
  for (int i = 0; i < motion.num_frames() && rollout.ok(); ++i) {
    const int step = static_cast<int>(std::lround(motion.times[i] / scene.time_step));
    EXPECT_NEAR(step * scene.time_step, motion.times[i], 1e-9);
    sum += (motion.positions.col(i) - rollout.positions(step)).squaredNorm();
  }
  return std::sqrt(std::max(sum / static_cast<double>(motion.positions.size()) - noise * noise, 0.0));
}

class MovingRecordingTest : public testing::TestWithParam<Recording> {};

TEST_P(MovingRecordingTest, IsPredictedByItsTruth) {
  const Recording& recording = GetParam();
  ReadMotionOptions with_start;  // the recording of the shirt has none
  with_start.scene_path = kDatasets + recording.scene + ".scene.json";
  const RecordedMotion motion = ReadMotion(kDatasets + recording.name + ".motion.bin", with_start);
  EXPECT_NE(ReadText(kDatasets + "README.md", 1 << 20).find(recording.truth), std::string::npos);
  const double missed = Misses(motion, recording.noise, recording.values);
  EXPECT_LE(missed, recording.model_error);
  EXPECT_GE(Misses(motion, recording.noise, {}), 2.0 * missed);
}

TEST_P(MovingRecordingTest, MovesFarBeyondItsNoise) {
  const RecordedMotion motion = ReadMotion(kDatasets + GetParam().name + std::string(".motion.bin"));
  const Eigen::MatrixXd way = motion.positions.colwise() - motion.positions.col(0);
  EXPECT_GE(std::sqrt(way.squaredNorm() / static_cast<double>(way.size())), 7.0 * GetParam().noise);
}

INSTANTIATE_TEST_SUITE_P(Datasets, MovingRecordingTest, testing::ValuesIn(kRecordings),
                         [](const auto& param) { return std::string(param.param.name); });

}  // namespace
}  // namespace clothid::moving_recordings_test
