#include "datasets/importing/import_motion.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "datasets/importing/path_times.h"
#include "datasets/motion/motion_validation.h"
#include "datasets/motion/scene_text.h"
#include "sim/base/error.h"
#include "sim/base/json_document.h"
#include "sim/base/text_file.h"
#include "sim/scene/scene_json.h"

namespace clothid {
namespace {

using Json = nlohmann::ordered_json;

[[noreturn]] void FailUsage(const std::string& message) { throw Error(ErrorKind::kUsage, message); }

std::string SceneText(const ImportOptions& options) {
  return options.scene_text.empty() ? ReadText(options.scene_path, kMaxJsonBytes) : options.scene_text;
}

// Of a scene that may leave out its duration, because a recording has its own.
Mesh MeshOfScene(const std::string& path, std::string text) {
  const JsonValue document = ParseJson(text, path);
  const JsonNode root(document, path);
  if (!root.Find("mesh")) {
    throw Error(ErrorKind::kUsage, path + ": has no key 'mesh'; expected one, or a mesh from a grid or an OBJ file");
  }
  if (!root.Find("duration")) {
    Json json = Json::parse(text);
    json["duration"] = 1.0;
    text = json.dump();
  }
  return ParseScene(text, path, std::filesystem::path(path).parent_path().string()).mesh;
}

// The text without the names of files: what they hold is in the tensors. Unchanged where it names none.
std::string WithoutFiles(const std::string& text, const std::string& source, bool mesh_replaced) {
  const std::string recorded = WithRecordedHandles(text);
  Json scene = Json::parse(recorded);
  bool changed = false;
  if (scene.contains("mesh") && (mesh_replaced || scene["mesh"].contains("obj"))) changed = scene.erase("mesh") > 0;
  if (scene.contains("initial") && scene["initial"].contains("positions") && scene["initial"]["positions"] != "rest") {
    throw Error(ErrorKind::kBadData,
                source +
                    ": key 'initial.positions': expected \"rest\" or nothing; a recording starts from its first "
                    "frame");
  }
  return changed ? scene.dump(2) : recorded;
}

// The text with these handles, clamped.
std::string WithClamp(const std::string& text, const std::vector<int>& nodes) {
  Json scene = Json::parse(text);
  scene["handles"] = {{"nodes", nodes}, {"clamp", true}};
  return scene.dump(2);
}

void SetPoints(const PointTracks& tracks, const PointMap& map, MotionTensors* tensors) {
  tensors->node_index = map.node_index;
  tensors->face_index = map.face_index;
  tensors->barycentric = map.barycentric;
  tensors->point_kind.clear();
  tensors->positions.resize(3 * static_cast<Eigen::Index>(map.points.size()), tracks.num_frames());
  for (std::size_t q = 0; q < map.points.size(); ++q) {
    tensors->positions.middleRows<3>(3 * static_cast<Eigen::Index>(q)) =
        tracks.positions.middleRows<3>(3 * map.points[q]);
  }
}

PointMap MakeMap(const PointTracks& tracks, const Mesh& mesh, const ImportOptions& options) {
  if (options.given_map) return *options.given_map;
  switch (options.map) {
    case PointMapKind::kNodes:
      return MapToNodes(tracks, mesh);
    case PointMapKind::kNearest:
      return MapToNearest(tracks, mesh, {false, options.map_distance});
    case PointMapKind::kMarkers:
      return MapToNearest(tracks, mesh, {true, options.map_distance});
    case PointMapKind::kFile:
      break;
  }
  return ReadPointMap(options.map_path, tracks, mesh);
}

// The point that observes a node.
int PointAt(const MotionTensors& tensors, int node, const std::string& source) {
  if (tensors.face_index.empty()) {
    if (tensors.node_index.empty()) return node;
    const auto found = std::find(tensors.node_index.begin(), tensors.node_index.end(), node);
    if (found != tensors.node_index.end()) return static_cast<int>(found - tensors.node_index.begin());
  }
  throw Error(ErrorKind::kBadData, source + ": no point is measured at the handle " + std::to_string(node) +
                                       "; expected its path from another file");
}

void SetHandles(const ImportOptions& options, double time_shift, const std::string& source, MotionTensors* tensors) {
  if (options.handle_nodes.empty()) {
    if (options.handle_file)
      FailUsage(options.handle_file->path + ": a path of handles; expected the nodes that it moves");
    if (options.handle_path) FailUsage("a path of handles; expected the nodes that it moves");
    return;
  }
  std::vector<int> sorted = options.handle_nodes;
  std::sort(sorted.begin(), sorted.end());
  if (sorted.front() < 0 || sorted.back() >= tensors->mesh.num_nodes() ||
      std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end()) {
    FailUsage("handles: expected different nodes from 0 to " + std::to_string(tensors->mesh.num_nodes() - 1));
  }
  if (options.handle_file) {
    const HandlePath path = ReadHandlePath(*options.handle_file, options.handle_nodes, tensors->times, time_shift);
    KeepHandlePaths({options.handle_nodes, path}, tensors);
    return;
  }
  if (options.handle_path) {
    if (options.handle_path->num_handles() != static_cast<int>(options.handle_nodes.size())) {
      FailUsage("the path of the handles: expected that of " + std::to_string(options.handle_nodes.size()) +
                " nodes, got " + std::to_string(options.handle_path->num_handles()));
    }
    KeepHandlePaths({options.handle_nodes, *options.handle_path}, tensors);
    return;
  }
  tensors->handle_index = options.handle_nodes;
  tensors->handle_times.resize(0);
  std::vector<int> points;
  for (const int node : options.handle_nodes) points.push_back(PointAt(*tensors, node, source));
  tensors->handle_positions = MeasuredHandlePositions(tensors->times, tensors->positions, points, source);
}

void SetForces(const ImportOptions& options, double time_shift, MotionTensors* tensors) {
  if (options.force_file) tensors->forces = ReadForces(*options.force_file, tensors->times, time_shift);
}

// Forces go with the handles: turned with the points, on the clock of the recording.
void EditForces(double time_shift, const std::string& name, const ImportOptions& options, MotionTensors* tensors) {
  ForceReadings& forces = tensors->forces;
  if (forces.is_empty() || options.force_file) return;
  const TrackEdit& edit = options.edit;
  if (edit.times.size() > 0 || edit.frame_rate > 0.0) {
    FailUsage(name + ": its forces have times of their own; expected no new times for its frames alone");
  }
  if (edit.time_scale != 1.0) forces.times *= edit.time_scale;
  forces.times.array() += time_shift;
  TurnForces(edit.transform.linear(), name, &forces);
  KeepReadingsWithin(tensors->times, &forces);
  if (forces.is_empty()) forces = ForceReadings();
}

void SetSigma(double sigma, MotionTensors* tensors) {
  if (sigma == 0.0) return;
  if (!std::isfinite(sigma) || sigma < 0.0) FailUsage("sigma: expected a number > 0 (m)");
  tensors->sigma = Eigen::VectorXd::Constant(tensors->positions.rows() / 3, sigma);
}

// Puts the scene of `scene_path` into the tensors; the path of its handles where these have none.
void SetScene(const ImportOptions& options, const std::string& source, MotionTensors* tensors) {
  ReadMotionOptions read;
  read.smooth_handles = false;
  if (options.clamps_handles) {
    read.change_scene = [&](const std::string& text) { return WithClamp(text, options.handle_nodes); };
  }
  if (options.scene_text.empty()) {
    read.scene_path = options.scene_path;
  } else {
    tensors->scene_text = options.scene_text;
  }
  const RecordedMotion motion =
      InterpretMotion(*tensors, options.scene_text.empty() ? source : options.scene_path, read);
  if (tensors->handle_index.empty()) {
    ExpectOneClock(motion.scene.handles, tensors->times, options.scene_path);
    KeepHandlePaths(motion.scene.handles, tensors);
  }
  tensors->mesh = motion.scene.mesh;  // with the rest shape and the seams that the scene gives it
  tensors->sequences = SequencesOf(motion.scene);
  tensors->scene_text = WithoutFiles(motion.scene_text, options.scene_path, options.mesh.has_value());
}

void SetKinds(const SurfaceMarks& marks, const std::string& source, MotionTensors* tensors) {
  if (marks.as_surface) tensors->point_kind = MarkSurfacePoints(*tensors, marks, source);
}

// Whatever cannot be read back is found here.
void Verify(const MotionTensors& tensors, const std::string& source) {
  ValidateMotionTensors(tensors, source);
  InterpretMotion(tensors, source);
}

// The paths of the handles, in place of what stands in them for "not seen" a smooth curve. A handle that never leaves
// it stands there.
Eigen::MatrixXd SeenHandles(const MissingValues& missing, const MotionTensors& tensors, const std::string& name) {
  Eigen::MatrixXd seen = tensors.handle_positions;
  for (Eigen::Index row = 0; row < seen.rows() && !missing.is_empty(); row += 3) {
    Eigen::MatrixXd path = seen.middleRows<3>(row);
    missing.Erase(1.0, &path);
    if (path.array().isNaN().all()) continue;
    const Eigen::VectorXd& times = tensors.handle_times.size() > 0 ? tensors.handle_times : tensors.times;
    seen.middleRows<3>(row) = MeasuredHandlePositions(times, path, {0}, name);
  }
  return seen;
}

// The paths of the handles of a recording go with its points: frame by frame, or, with times of their own, on its
// clock.
void EditHandles(const MotionTensors& read, double time_shift, const std::string& name, const ImportOptions& options,
                 MotionTensors* tensors) {
  if (tensors->handle_index.empty() || !options.handle_nodes.empty()) return;
  TrackEdit edit = options.edit;
  edit.missing = MissingValues();
  PointTracks handles;
  handles.name = name + ": handles";
  handles.positions = SeenHandles(options.edit.missing, read, handles.name);
  if (tensors->handle_times.size() == 0) {
    // Frames are chosen; what their times become does not matter.
    handles.times = Eigen::VectorXd::LinSpaced(handles.num_frames(), 0.0, handles.num_frames() - 1.0);
    tensors->handle_positions = EditTracks(handles, edit).tracks.positions;
    return;
  }
  if (edit.times.size() > 0 || edit.frame_rate > 0.0) {
    FailUsage(name + ": its handles have times of their own; expected no new times for its frames alone");
  }
  TrackEdit own;
  own.scale = edit.scale;
  own.transform = edit.transform;
  own.time_scale = edit.time_scale;
  handles.times = tensors->handle_times;
  const PointTracks edited = EditTracks(handles, own).tracks;
  tensors->handle_times = edited.times.array() + time_shift;
  tensors->handle_positions = edited.positions;
}

Eigen::Matrix3Xd EditedCloud(const Eigen::Matrix3Xd& cloud, const TrackEdit& edit) {
  std::vector<Eigen::Index> seen;
  for (Eigen::Index i = 0; i < cloud.cols(); ++i) {
    if (!edit.missing.Contains(cloud.col(i))) seen.push_back(i);
  }
  const Eigen::Matrix3Xd kept = cloud(Eigen::all, seen);
  return ((edit.scale * edit.transform.linear()) * kept).colwise() + edit.transform.translation();
}

// Other formats may have times that are no seconds yet, recordings not.
EditedTracks EditToRecord(const PointTracks& tracks, const TrackEdit& edit) {
  EditedTracks edited = EditTracks(tracks, edit);
  if (edit.frame_rate == 0.0) ExpectSeconds(edited.tracks.times, edited.tracks.times_name);
  return edited;
}

}  // namespace

MotionTensors ImportMotion(const PointTracks& tracks, const ImportOptions& options) {
  if (options.scene_path.empty()) FailUsage(tracks.name + ": expected a scene to make a recording of it");
  const EditedTracks edited = EditToRecord(tracks, options.edit);
  MotionTensors tensors;
  tensors.single_precision = false;
  tensors.times = edited.tracks.times;
  tensors.mesh = options.mesh ? *options.mesh : MeshOfScene(options.scene_path, SceneText(options));
  ValidateMesh(tensors.mesh, tracks.name + ": mesh");
  SetPoints(edited.tracks, MakeMap(edited.tracks, tensors.mesh, options), &tensors);
  SetHandles(options, edited.time_shift, tracks.name, &tensors);
  SetForces(options, edited.time_shift, &tensors);
  SetSigma(options.sigma, &tensors);
  SetKinds(options.surface, tracks.name, &tensors);
  tensors.provenance = options.provenance;
  tensors.scene_text = "{}";
  ValidateMotionTensors(tensors, tracks.name);
  SetScene(options, tracks.name, &tensors);
  SetObstaclePaths(options.obstacle_files, edited.time_shift, tracks.name, &tensors);
  Verify(tensors, tracks.name);
  return tensors;
}

MotionTensors ConvertMotion(const MotionTensors& tensors, const std::string& name, const ImportOptions& options) {
  const EditedTracks edited = EditToRecord(ToTracks(tensors, name), options.edit);
  MotionTensors result = tensors;
  result.times = edited.tracks.times;
  result.positions = edited.tracks.positions;
  result.clouds.clear();
  for (const int frame : edited.frames) {
    if (!tensors.clouds.empty()) result.clouds.push_back(EditedCloud(tensors.clouds[frame], options.edit));
  }
  result.cloud_sigma *= options.edit.scale;
  EditHandles(tensors, edited.time_shift, name, options, &result);
  EditForces(edited.time_shift, name, options, &result);
  if (options.mesh) {
    result.mesh = *options.mesh;
    ValidateMesh(result.mesh, name + ": mesh");
  }
  if (options.mesh || options.map != PointMapKind::kNodes) {
    result.sigma.resize(0);
    SetPoints(edited.tracks, MakeMap(edited.tracks, result.mesh, options), &result);
  }
  SetHandles(options, edited.time_shift, name, &result);
  SetForces(options, edited.time_shift, &result);
  SetSigma(options.sigma, &result);
  SetKinds(options.surface, name, &result);
  result.provenance = options.provenance;
  ValidateMotionTensors(result, name);
  if (options.scene_path.empty()) {
    EditObstacleClocks(options.edit, edited.time_shift, name, &result);
  } else {
    SetScene(options, name, &result);
  }
  SetObstaclePaths(options.obstacle_files, edited.time_shift, name, &result);
  Verify(result, name);
  return result;
}

PointTracks ToTracks(const MotionTensors& tensors, const std::string& name) {
  PointTracks tracks;
  tracks.name = name;
  tracks.times = tensors.times;
  tracks.positions = tensors.positions;
  if (tensors.node_index.empty() && tensors.face_index.empty()) tracks.faces = tensors.mesh.faces;
  return tracks;
}

}  // namespace clothid
