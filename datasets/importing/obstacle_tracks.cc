#include "datasets/importing/obstacle_tracks.h"

#include <algorithm>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "datasets/formats/ros_csv.h"
#include "datasets/formats/track_file.h"
#include "datasets/importing/body_tracks.h"
#include "datasets/importing/path_times.h"
#include "datasets/motion/scene_text.h"
#include "sim/base/error.h"
#include "sim/base/row_error.h"
#include "sim/obstacle/surface_sequence.h"
#include "sim/obstacle/triangulated_surface.h"
#include "sim/path/pose_csv.h"

namespace clothid {
namespace {

// Polygons are cut into the triangles `like` (may be null).
PointTracks ReadMoved(const ObstacleFile& file, const Eigen::Matrix3Xi* like = nullptr) {
  PointTracks tracks = ReadTracks(file.path, like);
  for (auto point : tracks.positions.reshaped(3, tracks.positions.size() / 3).colwise()) {
    point = (file.transform * Eigen::Vector3d(point)).eval();
  }
  return tracks;
}

RigidPath ReadPoses(const std::string& path) {
  if (!IsRosCsv(path)) return ReadPoseCsv(path);
  const PoseTrack poses = ReadRosPoses(path);
  return NamingLines(path, poses.lines, [&] { return RigidPath(poses.times, poses.positions, poses.rotations); });
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

// One of the two.
struct NewMotion {
  std::shared_ptr<const RigidPath> path;
  std::shared_ptr<const SurfaceSequence> sequence;
};
using NewMotions = std::map<std::size_t, NewMotion>;  // by the number of their obstacle

// Puts them into the scene text of a recording and its tensors.
void WriteMotions(const NewMotions& motions, RecordedMotion recorded, MotionTensors* motion) {
  if (motions.empty()) return;
  auto json = nlohmann::ordered_json::parse(recorded.scene_text);
  for (const auto& [i, own] : motions) {
    recorded.scene.obstacles[i].path = own.path;
    recorded.scene.obstacles[i].sequence = own.sequence;
    for (const char* key : {"path", "sequence"}) json["obstacles"][i].erase(key);
    // Gives way to what it holds.
    json["obstacles"][i][own.path != nullptr ? "path" : "sequence"] = "a file";
  }
  motion->scene_text = WithInlineLists(json.dump(2), recorded.scene);
  motion->sequences = SequencesOf(recorded.scene);
}

RecordedMotion Interpreted(const MotionTensors& motion, const std::string& source) {
  ReadMotionOptions options;
  options.smooth_handles = false;
  return InterpretMotion(motion, source, options);
}

}  // namespace

namespace {

// What `read` makes of a file, whose name leads every message.
template <typename Read>
auto Named(const ObstacleFile& file, const Read& read) {
  try {
    return read();
  } catch (const Error& error) {
    const std::string message = error.what();
    if (message.rfind(file.path, 0) == 0) throw;
    throw Error(error.kind(), file.path + ": " + message);
  }
}

// Those frames that frames of the recording at `times` need, all of which are checked.
std::shared_ptr<const SurfaceSequence> ReadObstacleSequence(const ObstacleFile& file, const SceneObstacle& obstacle,
                                                            const Eigen::VectorXd& times, double time_shift) {
  const auto* surface = dynamic_cast<const TriangulatedSurface*>(obstacle.shape.get());
  if (surface == nullptr) {
    throw Error(ErrorKind::kUsage,
                file.path + ": a body that deforms; expected a mesh, and the obstacle '" + obstacle.name + "' is none");
  }
  const double shift = time_shift - file.time_offset;
  const SurfaceSequence all = SequenceOfVertices(ReadMoved(file, &surface->faces()), *surface, times, shift);
  ExpectSeconds(all.times(), file.path);
  const Eigen::VectorXd knots = all.times().array() + shift;
  ExpectCovered(knots, times, file.path);
  const KnotRange needed = NeededKnots(knots, times);
  return std::make_shared<SurfaceSequence>(*surface, knots.segment(needed.first, needed.count),
                                           all.positions().middleCols(needed.first, needed.count));
}

}  // namespace

RigidPath ReadObstaclePath(const ObstacleFile& file, const Eigen::VectorXd& times, double time_shift) {
  const double shift = time_shift - file.time_offset;
  return Named(file, [&] {
    const bool has_markers = IsMarkerFile(file.path);
    const RigidPath path = has_markers ? PathOfMarkers(ReadMoved(file)) : ReadPoses(file.path);
    ExpectSeconds(path.times(), file.path);
    ExpectCovered(path.times().array() + shift, times, file.path);
    return Moved(path, has_markers ? Eigen::Isometry3d::Identity() : file.transform, shift, times);
  });
}

void SetObstaclePaths(const std::vector<ObstacleFile>& files, double time_shift, const std::string& source,
                      MotionTensors* motion) {
  if (files.empty()) return;
  RecordedMotion recorded = Interpreted(*motion, source);
  NewMotions motions;
  for (const ObstacleFile& file : files) {
    const std::size_t i = ObstacleNamed(recorded.scene, file);
    if (motions.count(i) > 0) {
      throw Error(ErrorKind::kUsage, file.path + ": a second path of the obstacle '" + file.name + "'; expected one");
    }
    if (IsBodySequence(file.path)) {
      motions[i].sequence = Named(
          file, [&] { return ReadObstacleSequence(file, recorded.scene.obstacles[i], motion->times, time_shift); });
    } else {
      motions[i].path = std::make_shared<RigidPath>(ReadObstaclePath(file, motion->times, time_shift));
    }
  }
  WriteMotions(motions, std::move(recorded), motion);
}

void EditObstacleClocks(const TrackEdit& edit, double time_shift, const std::string& source, MotionTensors* motion) {
  const bool has_new_times = edit.times.size() > 0 || edit.frame_rate > 0.0;
  if (!has_new_times && edit.time_scale == 1.0 && time_shift == 0.0) return;
  RecordedMotion recorded = Interpreted(*motion, source);
  NewMotions motions;
  for (std::size_t i = 0; i < recorded.scene.obstacles.size(); ++i) {
    const SceneObstacle& obstacle = recorded.scene.obstacles[i];
    if (!obstacle.moves()) continue;
    if (has_new_times) {
      throw Error(ErrorKind::kUsage, source +
                                         ": its obstacles have paths with times of their own; expected no new "
                                         "times for its frames alone");
    }
    const auto edited = [&](const Eigen::VectorXd& times) -> Eigen::VectorXd {
      return (times * edit.time_scale).array() + time_shift;
    };
    if (const RigidPath* path = obstacle.path.get()) {
      motions[i].path = std::make_shared<RigidPath>(edited(path->times()), path->positions(), path->rotations());
    } else {
      const auto& surface = dynamic_cast<const TriangulatedSurface&>(*obstacle.shape);
      motions[i].sequence = std::make_shared<SurfaceSequence>(surface, edited(obstacle.sequence->times()),
                                                              obstacle.sequence->positions());
    }
  }
  WriteMotions(motions, std::move(recorded), motion);
}

}  // namespace clothid
