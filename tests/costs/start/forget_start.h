// Recordings whose scene does not know how they start, made from those that do.
#ifndef CLOTHID_TESTS_COSTS_START_FORGET_START_H_
#define CLOTHID_TESTS_COSTS_START_FORGET_START_H_

#include <Eigen/Core>

#include "datasets/motion/frame_trend.h"
#include "datasets/motion/handle_measurements.h"
#include "datasets/motion/recorded_motion.h"
#include "datasets/motion/start_state.h"

namespace clothid {

// As `ReadMotion` does for a recording without `initial`: the start and the handles, which stand still, from what was
// measured. The recording must know its sigma.
inline RecordedMotion ForgetStart(StartSource source, RecordedMotion motion) {
  motion.start_source = source;
  const FrameTrend trend = FitFrameTrend(motion.times, motion.positions, motion.sigma);
  motion.scene.initial_positions = motion.positions.col(0);
  motion.handle_measurements = MeasureStandingHandles(motion.sigma, &motion);
  motion.scene.initial_positions = SmoothStartPositions(motion.scene, motion.points, trend);
  if (source == StartSource::kMoving) {
    motion.scene.initial_velocities = SmoothStartVelocities(motion.scene, motion.points, trend);
  }
  return motion;
}

}  // namespace clothid

#endif  // CLOTHID_TESTS_COSTS_START_FORGET_START_H_
