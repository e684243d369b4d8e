#include "datasets/importing/obstacle_tracks.h"

#include <algorithm>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "datasets/formats/ros_csv.h"
#include "datasets/importing/path_times.h"
#include "datasets/motion/scene_text.h"
#include "sim/base/error.h"
#include "sim/path/pose_csv.h"

namespace clothid {
namespace {

RigidPath ReadPoses(const std::string& path) {
  if (!IsRosCsv(path)) return ReadPoseCsv(path);
  const PoseTrack poses = ReadRosPoses(path);
  return RigidPath(poses.times, poses.positions, poses.rotations);
}

// In another frame of reference, its times later by `shift` s, those that frames at `times` need.
RigidPath Moved(const RigidPath& path, const Eigen::Isometry3d& transform, double shift, const Eigen::VectorXd& times) {
  const Eigen::VectorXd knots = path.times().array() + shift;
  const KnotRange needed = NeededKnots(knots, times);
  const Eigen::Matrix3Xd positions = path.positions().middleCols(needed.first, needed.count);
  Eigen::Matrix4Xd rotations = path.rotations().middleCols(needed.first, needed.count);
  for (auto rotation : rotations.colwise()) {
    const Eigen::Quaterniond own(Eigen::Vector4d{rotation});
    rotation = (Eigen::Quaterniond(transform.linear()) * own).coeffs();
  }
  return RigidPath(knots.segment(needed.first, needed.count),
                   (transform.linear() * positions).colwise() + transform.translation(), rotations);
}

std::size_t ObstacleNamed(const Scene& scene, const ObstacleFile& file) {
  const std::vector<std::string> names = scene.obstacle_names();
  const auto found = std::find(names.begin(), names.end(), file.name);
  if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
  std::string known;
  for (const std::string& name : names) known += (known.empty() ? "" : ", ") + name;
  throw Error(ErrorKind::kUsage, file.path + ": a path of the obstacle '" + file.name + "'; expected one of the scene" +
                                     (known.empty() ? ", which has none" : ": " + known));
}

using NewPaths = std::map<std::size_t, std::shared_ptr<const RigidPath>>;  // by the number of their obstacle

// Puts paths into the scene text of a recording.
void WritePaths(const NewPaths& paths, RecordedMotion recorded, MotionTensors* motion) {
  if (paths.empty()) return;
  auto json = nlohmann::ordered_json::parse(recorded.scene_text);
  for (const auto& [i, path] : paths) {
    recorded.scene.obstacles[i].path = path;
    json["obstacles"][i]["path"] = "a file";  // which gives way to what it holds
  }
  motion->scene_text = WithInlineLists(json.dump(2), recorded.scene);
}

RecordedMotion Interpreted(const MotionTensors& motion, const std::string& source) {
  ReadMotionOptions options;
  options.smooth_handles = false;
  return InterpretMotion(motion, source, options);
}

}  // namespace

RigidPath ReadObstaclePath(const ObstacleFile& file, const Eigen::VectorXd& times, double time_shift) {
  const double shift = time_shift - file.time_offset;
  try {
    const RigidPath path = ReadPoses(file.path);
    ExpectCovered(path.times().array() + shift, times, file.path);
    return Moved(path, file.transform, shift, times);
  } catch (const Error& error) {
    const std::string message = error.what();
    if (message.rfind(file.path, 0) == 0) throw;
    throw Error(error.kind(), file.path + ": " + message);
  }
}

void SetObstaclePaths(const std::vector<ObstacleFile>& files, double time_shift, const std::string& source,
                      MotionTensors* motion) {
  if (files.empty()) return;
  RecordedMotion recorded = Interpreted(*motion, source);
  NewPaths paths;
  for (const ObstacleFile& file : files) {
    const std::size_t i = ObstacleNamed(recorded.scene, file);
    if (paths.count(i) > 0) {
      throw Error(ErrorKind::kUsage, file.path + ": a second path of the obstacle '" + file.name + "'; expected one");
    }
    paths[i] = std::make_shared<RigidPath>(ReadObstaclePath(file, motion->times, time_shift));
  }
  WritePaths(paths, std::move(recorded), motion);
}

void EditObstacleClocks(const TrackEdit& edit, double time_shift, const std::string& source, MotionTensors* motion) {
  const bool has_new_times = edit.times.size() > 0 || edit.frame_rate > 0.0;
  if (!has_new_times && edit.time_scale == 1.0 && time_shift == 0.0) return;
  RecordedMotion recorded = Interpreted(*motion, source);
  NewPaths paths;
  for (std::size_t i = 0; i < recorded.scene.obstacles.size(); ++i) {
    const RigidPath* path = recorded.scene.obstacles[i].path.get();
    if (path == nullptr) continue;
    if (has_new_times) {
      throw Error(ErrorKind::kUsage, source +
                                         ": its obstacles have paths with times of their own; expected no new "
                                         "times for its frames alone");
    }
    paths[i] = std::make_shared<RigidPath>((path->times() * edit.time_scale).array() + time_shift, path->positions(),
                                           path->rotations());
  }
  WritePaths(paths, std::move(recorded), motion);
}

}  // namespace clothid
