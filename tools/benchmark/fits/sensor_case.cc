#include "tools/benchmark/fits/sensor_case.h"

#include <algorithm>
#include <numeric>
#include <random>

#include "datasets/checking/motion_check.h"
#include "datasets/importing/import_motion.h"
#include "datasets/synthetic/capture.h"
#include "sim/base/error.h"
#include "sim/base/json_document.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

constexpr double kOutlierFraction = 0.05;
constexpr int kNodesPerMarker = 20;

Sensor SensorOf(const SensorCase& sensor_case, const std::string& setting) {
  Sensor sensor = sensor_case.sensor;
  if (setting == "clean") {
    sensor.interval.fill(0.5 * (sensor.interval[0] + sensor.interval[1]));
    sensor.gaps.clear();
    sensor.drop_fraction = sensor.outlier_fraction = sensor.gripper_noise = 0.0;
  }
  if (setting == "clean" || setting == "markers") sensor.num_flipped_frames = 0;
  if (setting == "huber" || setting == "outliers") sensor.outlier_fraction = kOutlierFraction;
  return sensor;
}

// The recording of all nodes. Its clock starts with the scene's, and the path of the gripper, whose clock the user has
// set by the camera's, comes with it.
MotionTensors Import(const SensorCase& sensor_case, const Sensor& sensor, const Capture& capture,
                     const std::vector<int>& skipped_frames) {
  const Handles& handles = sensor_case.grid_scene.scene.handles;
  ImportOptions options;
  options.scene_path = sensor_case.grid_scene.path;
  options.edit.transform = sensor.pose;
  options.edit.start_at = sensor_case.truth.start_time();
  options.edit.skipped_frames = skipped_frames;
  MotionTensors tensors = ImportMotion(capture.points, options);
  if (capture.handles.num_frames() == 0) return tensors;
  const double read_off = sensor.gripper_clock_offset - sensor.clock_offset - kClockError;
  const double shift = *options.edit.start_at - capture.points.times[0];
  const Eigen::VectorXd times = (capture.handles.times.array() - read_off) + shift;
  KeepHandlePaths({handles.nodes, HandlePath(times, capture.handles.positions)}, &tensors);
  return tensors;
}

// The frames that `motion check` calls turned or mirrored.
std::vector<int> ReorderedFrames(const MotionTensors& tensors) {
  ReadMotionOptions options;
  options.smooth_handles = false;
  for (const Finding& finding : CheckMotion(InterpretMotion(tensors, "recording", options))) {
    if (finding.what == "order of points") return finding.frames;
  }
  return {};
}

void KeepMarkers(std::uint64_t seed, MotionTensors* tensors) {
  std::vector<int> nodes(static_cast<std::size_t>(tensors->mesh.num_nodes()));
  std::iota(nodes.begin(), nodes.end(), 0);
  std::vector<int> markers;
  std::mt19937_64 generator(seed);
  const std::size_t count = (nodes.size() + kNodesPerMarker - 1) / kNodesPerMarker;
  std::sample(nodes.begin(), nodes.end(), std::back_inserter(markers), count, generator);
  Eigen::MatrixXd positions(3 * static_cast<Eigen::Index>(count), tensors->times.size());
  for (std::size_t i = 0; i < count; ++i) {
    positions.middleRows<3>(3 * static_cast<Eigen::Index>(i)) = tensors->positions.middleRows<3>(3 * markers[i]);
  }
  tensors->node_index = markers;
  tensors->positions = positions;
}

}  // namespace

SensorCase ReadSensorCase(const std::string& scene_path, const std::string& sensor_path,
                          const std::vector<TrueParameter>& truth) {
  SensorCase sensor_case;
  sensor_case.sensor = ParseSensor(ReadFile(sensor_path, kMaxJsonBytes), sensor_path);
  sensor_case.grid_scene = ReadGridScene(scene_path);
  sensor_case.truth = SimulateFineTruth(sensor_case.grid_scene, truth);
  return sensor_case;
}

RecordedMotion RecordSensorCase(const SensorCase& sensor_case, const std::string& setting, std::uint64_t seed) {
  const Sensor sensor = SensorOf(sensor_case, setting);
  const Capture capture = TakeCapture(sensor_case.grid_scene, sensor_case.truth, sensor, seed);
  MotionTensors tensors = Import(sensor_case, sensor, capture, {});
  const std::vector<int> reordered = ReorderedFrames(tensors);
  if (!reordered.empty()) tensors = Import(sensor_case, sensor, capture, reordered);
  if (setting == "markers") KeepMarkers(seed, &tensors);
  ReadMotionOptions options;
  options.sigma_source = SigmaSource::kEstimated;
  // Where the scene says nothing of its start, a few points do not show it; their trend does.
  if (setting == "markers") options.start = StartSource::kSmoothed;
  return InterpretMotion(std::move(tensors), setting + ", seed " + std::to_string(seed), options);
}

RobustLoss LossOfSetting(const std::string& setting) {
  return setting == "huber" ? RobustLoss{RobustLoss::Kind::kHuber, 2.0} : RobustLoss{};
}

}  // namespace clothid
