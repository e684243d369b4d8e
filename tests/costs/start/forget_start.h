// Recordings whose scene does not know how they start, made from those that do.
#ifndef CLOTHID_TESTS_COSTS_START_FORGET_START_H_
#define CLOTHID_TESTS_COSTS_START_FORGET_START_H_

#include <Eigen/Core>
#include <random>

#include "datasets/motion/frame_trend.h"
#include "datasets/motion/handle_measurements.h"
#include "datasets/motion/recorded_motion.h"
#include "datasets/motion/start_state.h"
#include "sim/path/handle_path.h"

namespace clothid {

// The start of a recording whose handles are known, from its first frames.
inline void SmoothStart(StartSource source, RecordedMotion* motion) {
  motion->start_source = source;
  const FrameTrend trend = FitFrameTrend(motion->times, motion->positions, motion->sigma);
  motion->scene.initial_positions = motion->positions.col(0);
  motion->scene.initial_positions = SmoothStartPositions(motion->scene, motion->points, trend);
  if (source == StartSource::kMoving) {
    motion->scene.initial_velocities = SmoothStartVelocities(motion->scene, motion->points, trend);
  }
}

// As `ReadMotion` does for a recording without `initial`: the start and the handles, which stand still, from what was
// measured. The recording must know its sigma.
inline RecordedMotion ForgetStart(StartSource source, RecordedMotion motion) {
  motion.handle_measurements = MeasureStandingHandles(motion.sigma, &motion);
  SmoothStart(source, &motion);
  return motion;
}

// The same of handles that move: their path is what a sensor of its own measured of it, with noise of `handle_sigma` m,
// when the frames were taken; 0: it stays exact.
inline RecordedMotion ForgetMovingStart(StartSource source, double handle_sigma, unsigned seed, RecordedMotion motion) {
  if (handle_sigma > 0.0) {
    Handles& handles = motion.scene.handles;
    std::mt19937_64 generator(seed);
    std::normal_distribution<double> normal(0.0, handle_sigma);
    Eigen::MatrixXd measured(3 * handles.path.num_handles(), motion.num_frames());
    for (int i = 0; i < motion.num_frames(); ++i) measured.col(i) = handles.path.At(motion.times[i]);
    for (double& coordinate : measured.reshaped()) coordinate += normal(generator);
    handles.path = HandlePath(motion.times, SmoothPath(motion.times, measured));
    motion.handle_measurements = MeasureHandlePath(motion.times, measured, motion.scene);
  }
  SmoothStart(source, &motion);
  return motion;
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_COSTS_START_FORGET_START_H_
