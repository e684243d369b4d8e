#include "datasets/synthetic/capture.h"

#include "datasets/synthetic/synthetic.h"

namespace clothid {

Capture TakeCapture(const GridScene& grid_scene, const FineTruth& truth, const Sensor& sensor, std::uint64_t seed) {
  SeenMotion motion;
  motion.start = truth.start_time();
  motion.end = truth.end_time();
  motion.grid = grid_scene.nodes;
  motion.points_at = [&truth](double time) { return truth.PointsAt(time); };
  Capture capture;
  capture.points = SeePoints(sensor, motion, seed);
  const HandlePath& path = grid_scene.scene.handles.path;
  if (path.num_handles() > 0) capture.handles = SeeHandles(sensor, path, motion.start, motion.end, seed);
  if (!sensor.force_sensor) return capture;
  const Eigen::VectorXd steps = FrameSteps(sensor.force_sensor->rate, truth.scene.time_step, truth.rollout.num_steps());
  capture.forces = ReadForceSensor(*sensor.force_sensor, truth.rollout, truth.scene, steps, seed);
  capture.forces.times.array() += sensor.force_clock_offset;
  return capture;
}

}  // namespace clothid
