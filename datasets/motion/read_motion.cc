// From the tensors of a motion file to a recording: what the points are, where the cloth starts, which way its handles
// go.
#include <Eigen/Geometry>
#include <filesystem>
#include <limits>
#include <utility>

#include "datasets/motion/handle_measurements.h"
#include "datasets/motion/motion_container.h"
#include "datasets/motion/motion_file.h"
#include "datasets/motion/noise_estimate.h"
#include "datasets/motion/scene_text.h"
#include "datasets/motion/start_state.h"
#include "sim/base/error.h"
#include "sim/base/json_document.h"
#include "sim/base/text_file.h"
#include "sim/matrix/dense.h"
#include "sim/scene/scene_json.h"

namespace clothid {
namespace {

// Points whose second extent is less than this share of their first lie on a line, which leaves a rotation open.
constexpr double kCollinear = 1e-3;
// The least sigma that is estimated, relative to the cloth's size: a recording without noise has rounding.
constexpr double kLeastRelativeSigma = 1e-7;

std::vector<ObservedPoint> MakePoints(const MotionTensors& tensors) {
  std::vector<ObservedPoint> points(static_cast<std::size_t>(tensors.positions.rows() / 3));
  for (std::size_t p = 0; p < points.size(); ++p) {
    ObservedPoint& point = points[p];
    if (!tensors.point_kind.empty()) point.kind = static_cast<PointKind>(tensors.point_kind[p]);
    if (tensors.face_index.empty()) {
      point.nodes[0] = tensors.node_index.empty() ? static_cast<int>(p) : tensors.node_index[p];
      continue;
    }
    point.num_nodes = 3;
    for (int k = 0; k < 3; ++k) {
      point.nodes[k] = tensors.mesh.faces(k, tensors.face_index[p]);
      point.weights[k] = tensors.barycentric(k, static_cast<Eigen::Index>(p));
    }
  }
  return points;
}

Eigen::Vector3d RestPosition(const ObservedPoint& point, const Mesh& mesh) {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  for (int k = 0; k < point.num_nodes; ++k) position += point.weights[k] * mesh.rest_positions.col(point.nodes[k]);
  return position;
}

// The rest shape, moved as a rigid body to where it is closest to the points seen in `frame` [3 x P]; empty where these
// leave its place open.
Eigen::Matrix3Xd FitRestShape(const MotionTensors& tensors, const std::vector<ObservedPoint>& points,
                              const Eigen::MatrixXd& frame) {
  Eigen::Matrix3Xd rest(3, tensors.positions.rows() / 3), measured = rest;
  Eigen::Index num_seen = 0;
  for (std::size_t p = 0; p < points.size(); ++p) {
    const Eigen::Vector3d position = frame.col(static_cast<Eigen::Index>(p));
    if (!position.allFinite()) continue;
    rest.col(num_seen) = RestPosition(points[p], tensors.mesh);
    measured.col(num_seen++) = position;
  }
  const Eigen::Matrix3Xd seen_rest = rest.leftCols(num_seen), seen = measured.leftCols(num_seen);
  if (num_seen < 3 || IsCollinear(seen_rest, kCollinear) || IsCollinear(seen, kCollinear)) return {};
  return RigidMotion(seen_rest, seen) * tensors.mesh.rest_positions;
}

// The first frame where its points are the nodes; its gaps come from the fitted rest shape. Where the points are
// others, all comes from that: a cloth measured in places and guessed between them would start torn. Empty where the
// frame shows too little.
Eigen::VectorXd StartPositions(const MotionTensors& tensors, const std::vector<ObservedPoint>& points,
                               const Eigen::MatrixXd& frame) {
  const Eigen::Index num_nodes = tensors.mesh.num_nodes();
  const bool points_are_nodes = tensors.face_index.empty() && static_cast<Eigen::Index>(points.size()) == num_nodes;
  if (!points_are_nodes) return FitRestShape(tensors, points, frame).reshaped();
  Eigen::Matrix3Xd first = Eigen::Matrix3Xd::Constant(3, num_nodes, std::numeric_limits<double>::quiet_NaN());
  for (std::size_t p = 0; p < points.size(); ++p) {
    first.col(points[p].nodes[0]) = frame.col(static_cast<Eigen::Index>(p));
  }
  if (first.allFinite()) return first.reshaped();
  const Eigen::Matrix3Xd fitted = FitRestShape(tensors, points, frame);
  if (fitted.size() == 0) return {};
  for (Eigen::Index i = 0; i < num_nodes; ++i) {
    if (!first.col(i).allFinite()) first.col(i) = fitted.col(i);
  }
  return first.reshaped();
}

Handles MakeHandles(const MotionTensors& tensors, bool smooth, const std::string& path) {
  Handles handles;
  handles.nodes = tensors.handle_index;
  if (handles.nodes.empty()) return handles;
  const Eigen::VectorXd& times = tensors.handle_times.size() > 0 ? tensors.handle_times : tensors.times;
  try {
    handles.path = HandlePath(times, smooth ? SmoothPath(times, tensors.handle_positions) : tensors.handle_positions);
  } catch (const Error& error) {
    throw Error(error.kind(), path + ": " + error.what());
  }
  return handles;
}

// The sigma that the recording is to have; empty: not known. `is_needed`: as a start that is not known needs it, which
// is estimated from measurements and from what is believed of it.
Eigen::VectorXd ChooseSigma(const MotionTensors& tensors, const ReadMotionOptions& options, bool is_needed,
                            SigmaSource* source) {
  const Eigen::Index num_points = tensors.positions.rows() / 3;
  *source = tensors.sigma.size() > 0 ? SigmaSource::kRecorded : SigmaSource::kUnknown;
  if (options.sigma_source == SigmaSource::kGiven) {
    *source = SigmaSource::kGiven;
    return Eigen::VectorXd::Constant(num_points, options.sigma);
  }
  const bool is_wanted = options.sigma_source == SigmaSource::kEstimated || is_needed;
  if (tensors.sigma.size() > 0 || !is_wanted) return tensors.sigma;
  const double least = kLeastRelativeSigma * ClothSize(tensors.mesh);
  const Eigen::VectorXd sigma = EstimateSigma(tensors.times, tensors.positions, least);
  if (sigma.size() > 0) *source = SigmaSource::kEstimated;
  return sigma;
}

// Sigma, or an estimate of it where it is not known.
Eigen::VectorXd LikelySigma(const MotionTensors& tensors, Eigen::VectorXd sigma) {
  const double least = kLeastRelativeSigma * ClothSize(tensors.mesh);
  if (sigma.size() == 0) sigma = EstimateSigma(tensors.times, tensors.positions, least);
  // Too few frames for an estimate: a thousandth of the cloth, as for residuals.
  if (sigma.size() == 0) sigma.setConstant(tensors.positions.rows() / 3, 1e-3 * ClothSize(tensors.mesh));
  return sigma;
}

// What is asked for, or what the first frames say of it. A trend that needs one frame alone has followed none.
StartSource ChooseStart(StartSource asked, const FrameTrend& trend) {
  if (asked != StartSource::kEstimated) return asked;
  return trend.velocities.size() > 0 || trend.num_frames == 1 ? StartSource::kMoving : StartSource::kRest;
}

// From the first frames to a start that the cloth can have, where the scene leaves it to them.
void SetSmoothStart(const MotionTensors& tensors, const FrameTrend& trend, const Eigen::VectorXd& sigma,
                    bool is_velocity_open, RecordedMotion* motion) {
  const Handles& handles = motion->scene.handles;
  if (!IsUnknown(motion->start_source) || handles.nodes.empty()) {
    // Nothing is measured, or nothing is to be made of it.
  } else if (!tensors.handle_index.empty()) {
    const Eigen::VectorXd& times = tensors.handle_times.size() > 0 ? tensors.handle_times : motion->times;
    motion->handle_measurements = MeasureHandlePath(times, tensors.handle_positions, motion->scene);
  } else if (handles.path.num_handles() == 0) {
    motion->handle_measurements = MeasureStandingHandles(sigma, motion);
  }
  motion->scene.initial_positions = SmoothStartPositions(motion->scene, motion->points, trend);
  if (is_velocity_open && motion->start_source != StartSource::kRest) {
    motion->scene.initial_velocities = SmoothStartVelocities(motion->scene, motion->points, trend);
  }
}

// Whether the scene leaves the start to the recording, and which of its parts.
struct OpenStart {
  bool positions = true, velocity = true;
};

OpenStart FindOpenStart(const std::string& scene_text, const std::string& source) {
  const JsonValue document = ParseJson(scene_text, source);
  const auto initial = JsonNode(document, source).Find("initial");
  if (!initial) return {};
  return {!initial->Find("positions"), !initial->Find("velocity")};
}

SceneDefaults MakeDefaults(const MotionTensors& tensors, const std::vector<ObservedPoint>& points,
                           const Eigen::MatrixXd& first_frame, bool smooth, const std::string& path) {
  SceneDefaults defaults;
  defaults.has_mesh = true;
  defaults.mesh = tensors.mesh;
  defaults.initial_positions = StartPositions(tensors, points, first_frame);
  defaults.start_time = tensors.times[0];
  defaults.duration = tensors.times[tensors.times.size() - 1] - tensors.times[0];
  defaults.handles = MakeHandles(tensors, smooth, path);
  defaults.sequences = tensors.sequences;
  return defaults;
}

std::string FolderOf(const std::string& path) { return std::filesystem::path(path).parent_path().string(); }

}  // namespace

RecordedMotion InterpretMotion(MotionTensors tensors, const std::string& path, const ReadMotionOptions& options) {
  RecordedMotion motion;
  motion.name = path;
  motion.points = MakePoints(tensors);
  const bool embedded = options.scene_path.empty();
  motion.scene_text = embedded ? tensors.scene_text : ReadText(options.scene_path, kMaxJsonBytes);
  if (options.change_scene) motion.scene_text = options.change_scene(motion.scene_text);
  const std::string scene_name = embedded ? path + ": scene" : options.scene_path;
  const OpenStart open = FindOpenStart(motion.scene_text, scene_name);
  motion.sigma = ChooseSigma(tensors, options, IsUnknown(options.start) && open.positions, &motion.sigma_source);
  FrameTrend trend;
  trend.positions = tensors.positions.col(0).reshaped(3, motion.num_points());
  const bool is_smooth = options.start == StartSource::kSmoothed || IsUnknown(options.start);
  const Eigen::VectorXd sigma = is_smooth ? LikelySigma(tensors, motion.sigma) : Eigen::VectorXd();
  if (is_smooth) trend = FitFrameTrend(tensors.times, tensors.positions, sigma);
  const SceneDefaults defaults = MakeDefaults(tensors, motion.points, trend.positions, options.smooth_handles, path);
  motion.scene = ParseScene(motion.scene_text, scene_name, FolderOf(embedded ? path : options.scene_path), defaults);
  motion.start_source = open.positions ? ChooseStart(options.start, trend) : StartSource::kScene;
  motion.times = std::move(tensors.times);
  motion.positions = std::move(tensors.positions);
  if (is_smooth && open.positions) SetSmoothStart(tensors, trend, sigma, open.velocity, &motion);
  motion.scene_text = WithInlineLists(motion.scene_text, motion.scene);
  motion.clouds = std::move(tensors.clouds);
  const bool is_given = options.sigma_source == SigmaSource::kGiven;
  motion.cloud_sigma = is_given ? options.sigma : tensors.cloud_sigma;
  motion.forces = std::move(tensors.forces);
  motion.provenance = std::move(tensors.provenance);
  return motion;
}

RecordedMotion ReadMotion(const std::string& path, const ReadMotionOptions& options) {
  VerifiedMotion file = ReadVerifiedMotion(path);
  RecordedMotion motion = InterpretMotion(std::move(file.tensors), path, options);
  motion.sha256 = std::move(file.sha256);
  return motion;
}

}  // namespace clothid
