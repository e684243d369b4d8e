// A cloth that swings, as a capture would hold it, for tests of what is read from and said about recordings.
#ifndef CLOTHID_TESTS_DATASETS_IMPORTING_MADE_UP_CAPTURE_H_
#define CLOTHID_TESTS_DATASETS_IMPORTING_MADE_UP_CAPTURE_H_

#include <Eigen/Core>
#include <cmath>
#include <random>
#include <string>

#include "datasets/motion/motion_file.h"

namespace clothid {

inline constexpr int kCaptureColumns = 8, kCaptureRows = 8, kCaptureFrames = 60;
inline constexpr double kCaptureSpacing = 0.04;  // m
inline constexpr double kCaptureNoise = 0.001;   // m
inline constexpr double kCaptureRate = 30.0;     // Hz

// Node (i, j) at a time: the cloth hangs from its row j = 0 at z = 1 m, which goes to and fro along x, and swings along
// y. It touches nothing.
inline Eigen::Vector3d CapturedPlace(int i, int j, double time) {
  constexpr double kFrequency = 6.0;  // rad/s
  const double share = static_cast<double>(j) / (kCaptureRows - 1);
  return {kCaptureSpacing * i + 0.08 * std::sin(kFrequency * time), 0.04 * share * std::cos(kFrequency * time),
          1.0 - kCaptureSpacing * j};
}

// Handles are the upper corners, their paths free of noise.
inline MotionTensors MadeUpCapture(const Eigen::VectorXd& times) {
  MotionTensors tensors;
  GridOptions grid;
  grid.nodes = {kCaptureColumns, kCaptureRows};
  grid.size = {kCaptureSpacing * (kCaptureColumns - 1), kCaptureSpacing * (kCaptureRows - 1)};
  tensors.mesh = MakeGrid(grid);
  tensors.single_precision = false;
  tensors.times = times;
  tensors.positions.resize(3 * tensors.mesh.num_nodes(), times.size());
  tensors.handle_index = {0, kCaptureColumns - 1};
  tensors.handle_positions.resize(6, times.size());
  std::mt19937_64 generator(1);
  std::normal_distribution<double> noise(0.0, kCaptureNoise);
  for (Eigen::Index frame = 0; frame < times.size(); ++frame) {
    for (int j = 0; j < kCaptureRows; ++j) {
      for (int i = 0; i < kCaptureColumns; ++i) {
        const Eigen::Vector3d error(noise(generator), noise(generator), noise(generator));
        tensors.positions.col(frame).segment<3>(3 * (i + kCaptureColumns * j)) =
            CapturedPlace(i, j, times[frame]) + error;
      }
    }
    tensors.handle_positions.col(frame) << CapturedPlace(0, 0, times[frame]),
        CapturedPlace(kCaptureColumns - 1, 0, times[frame]);
  }
  tensors.sigma = Eigen::VectorXd::Constant(tensors.mesh.num_nodes(), kCaptureNoise);
  tensors.scene_text = R"({"clothid_scene": 1, "time_step": 0.005, "handles": [0, 7]})";
  return tensors;
}

inline MotionTensors MadeUpCapture() {
  return MadeUpCapture(Eigen::VectorXd::LinSpaced(kCaptureFrames, 0.0, (kCaptureFrames - 1) / kCaptureRate));
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_DATASETS_IMPORTING_MADE_UP_CAPTURE_H_
