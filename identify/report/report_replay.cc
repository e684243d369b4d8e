#include "identify/report/report_replay.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "identify/page/page_template.h"
#include "identify/report/packed_array.h"
#include "sim/obstacle/box.h"
#include "sim/obstacle/round_shapes.h"
#include "sim/obstacle/surface_sequence.h"
#include "sim/obstacle/triangulated_surface.h"

namespace clothid {
namespace {

using Json = nlohmann::ordered_json;

// What is quantised at once, whatever is left of it when it is packed.
constexpr double kMaxRawBytes = 1.0e8;
// More than that is not to be expected of its compression.
constexpr double kBestCompression = 8.0;
constexpr int kReplayDigits = 7;

Json VectorJson(const Eigen::VectorXd& vector) { return RoundedJson(vector, kReplayDigits); }

// As many digits of a time as tell a `digits`-digit part of the recording: clocks count from 1970.
int TimeDigits(const Eigen::VectorXd& times, int digits) {
  const double length = times[times.size() - 1] - times[0], largest = times.cwiseAbs().maxCoeff();
  return length > 0.0 && largest > length ? digits + static_cast<int>(std::ceil(std::log10(largest / length))) : digits;
}

template <typename Scalar>
std::string PackMatrix(const Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>& matrix) {
  return PackBytes({reinterpret_cast<const char*>(matrix.data()), sizeof(Scalar) * matrix.size()});
}

std::string PackFaces(const Eigen::Matrix3Xi& faces) { return PackMatrix<std::int32_t>(faces.cast<std::int32_t>()); }

Json AxesJson(const Eigen::Matrix3d& axes) {
  return {VectorJson(axes.col(0)), VectorJson(axes.col(1)), VectorJson(axes.col(2))};
}

Json RoundShapeJson(const Obstacle* shape) {
  if (const auto* cylinder = dynamic_cast<const Cylinder*>(shape)) {
    return {{"type", "cylinder"},
            {"from", VectorJson(cylinder->from())},
            {"to", VectorJson(cylinder->to())},
            {"radius", cylinder->radius()}};
  }
  if (const auto* torus = dynamic_cast<const Torus*>(shape)) {
    return {{"type", "torus"},
            {"center", VectorJson(torus->center())},
            {"axis", VectorJson(torus->axis())},
            {"radius", torus->radius()},
            {"tube_radius", torus->tube_radius()}};
  }
  if (const auto* bowl = dynamic_cast<const Bowl*>(shape)) {
    return {{"type", "bowl"},
            {"center", VectorJson(bowl->center())},
            {"axis", VectorJson(bowl->axis())},
            {"radius", bowl->radius()},
            {"angle", bowl->angle()},
            {"thickness", bowl->thickness()}};
  }
  return Json::object();
}

// The numbers that a shape is made of, with its type; of lengths in m and angles in rad. Empty where it is none of
// these.
Json ShapeJson(const Obstacle* shape) {
  if (const auto* plane = dynamic_cast<const Plane*>(shape)) {
    return {{"type", "plane"}, {"point", VectorJson(plane->point())}, {"normal", VectorJson(plane->normal())}};
  }
  if (const auto* sphere = dynamic_cast<const Sphere*>(shape)) {
    return {{"type", "sphere"}, {"center", VectorJson(sphere->center())}, {"radius", sphere->radius()}};
  }
  if (const auto* capsule = dynamic_cast<const Capsule*>(shape)) {
    return {{"type", "capsule"},
            {"from", VectorJson(capsule->from())},
            {"to", VectorJson(capsule->to())},
            {"radius", capsule->radius()}};
  }
  if (const auto* box = dynamic_cast<const Box*>(shape)) {
    return {{"type", "box"},
            {"center", VectorJson(box->center())},
            {"axes", AxesJson(box->rotation().toRotationMatrix())},
            {"size", VectorJson(box->size())},
            {"radius", box->radius()}};
  }
  if (const auto* surface = dynamic_cast<const TriangulatedSurface*>(shape)) {
    return {{"type", "mesh"},
            {"vertices", PackMatrix<float>(surface->vertices().cast<float>())},
            {"faces", PackFaces(surface->faces())}};
  }
  return RoundShapeJson(shape);
}

// Without a "type" where it cannot be drawn.
Json ObstacleJson(const SceneObstacle& obstacle) {
  Json json = Json::object({{"name", obstacle.name}});
  json.update(ShapeJson(obstacle.shape.get()));
  return json;
}

void AddPoints(const Eigen::MatrixXd& positions, Eigen::AlignedBox3d* box) {
  for (Eigen::Index frame = 0; frame < positions.cols(); ++frame) {
    for (Eigen::Index row = 0; row + 3 <= positions.rows(); row += 3) {
      const Eigen::Vector3d point = positions.block<3, 1>(row, frame);
      if (point.allFinite()) box->extend(point);
    }
  }
}

// Of all that moves but recorded points that are astray.
Eigen::AlignedBox3d BoundsOf(const ReplaySource& source) {
  Eigen::AlignedBox3d middle = source.middle, recorded;
  for (const Eigen::MatrixXd* own : {source.predicted, source.nodes, source.handles, source.start}) {
    if (own != nullptr) AddPoints(*own, &middle);
  }
  AddPoints(source.motion->positions, &recorded);
  if (middle.isEmpty() || recorded.isEmpty()) return middle.merged(recorded);
  const Eigen::Vector3d margin = Eigen::Vector3d::Constant(middle.diagonal().norm());
  const Eigen::AlignedBox3d near(middle.min() - margin, middle.max() + margin);
  return middle.merged(recorded.intersection(near));
}

double Largest(const Eigen::MatrixXd& errors) {
  double largest = 0.0;
  for (const double error : errors.reshaped()) largest = std::max(largest, std::isnan(error) ? 0.0 : error);
  return largest;
}

// [x, y, z, qx, qy, qz, qw] of an obstacle that moves, at every one of `frames`.
Json PosesJson(const RigidPath& path, const RecordedMotion& motion, const std::vector<int>& frames) {
  Json poses = Json::array();
  for (const int frame : frames) {
    const AffineMap pose = path.At(motion.times[frame]).pose;
    Eigen::VectorXd numbers(7);
    numbers << pose.col(3), Eigen::Quaterniond(Eigen::Matrix3d(pose.leftCols<3>())).coeffs();
    poses.push_back(RoundedJson(numbers, kReplayDigits));
  }
  return poses;
}

// The vertices of an obstacle that deforms at every one of `frames`, over a grid of its own.
Json SurfaceJson(const SurfaceSequence& sequence, const RecordedMotion& motion, const std::vector<int>& frames) {
  Eigen::MatrixXd places(3 * sequence.num_vertices(), static_cast<Eigen::Index>(frames.size()));
  std::vector<int> all;
  for (const int frame : frames) {
    places.col(static_cast<Eigen::Index>(all.size())) = sequence.At({}, motion.times[frame]).pose.reshaped();
    all.push_back(static_cast<int>(all.size()));
  }
  Eigen::AlignedBox3d box;
  AddPoints(places, &box);
  const PositionGrid grid = GridOver(box);
  return {{"origin", VectorJson(grid.origin)},
          {"step", grid.step},
          {"positions", PackPositions(Quantize(grid, places, all))}};
}

// What changes over time.
Json FramesJson(const ReplaySource& source, const PositionGrid& grid, double largest_error, int every) {
  const RecordedMotion& motion = *source.motion;
  std::vector<int> frames;
  for (int frame = 0; frame < motion.num_frames(); frame += every) frames.push_back(frame);
  Json json = {{"every", every}, {"times", RoundedJson(motion.times(frames), TimeDigits(motion.times, kReplayDigits))}};
  json["recorded"] = PackPositions(Quantize(grid, motion.positions, frames));
  const auto add = [&](const char* name, const Eigen::MatrixXd* positions) {
    if (positions != nullptr) json[name] = PackPositions(Quantize(grid, *positions, frames));
  };
  add("predicted", source.predicted);
  add("nodes", source.nodes);
  add("handle_path", source.handles);
  for (const SceneObstacle& obstacle : motion.scene.obstacles) {
    if (obstacle.path != nullptr) json["poses"][obstacle.name] = PosesJson(*obstacle.path, motion, frames);
    if (obstacle.sequence != nullptr) {
      json["surfaces"][obstacle.name] = SurfaceJson(*obstacle.sequence, motion, frames);
    }
  }
  if (source.missing_force != nullptr) {
    json["missing_force"] =
        PackMagnitudes((*source.missing_force)(Eigen::all, frames).reshaped(), Largest(*source.missing_force));
  }
  if (source.point_errors != nullptr) {
    json["errors"] = PackMagnitudes((*source.point_errors)(Eigen::all, frames).reshaped(), largest_error);
  }
  return json;
}

Json CommonJson(const ReplaySource& source, const PositionGrid& grid, double largest_error) {
  const RecordedMotion& motion = *source.motion;
  const Eigen::Vector3d up = -motion.scene.gravity;
  Json json = {{"points", motion.num_points()},
               {"points_are_nodes", PointsAreNodes(motion)},
               {"node_count", motion.scene.mesh.num_nodes()},
               {"origin", VectorJson(grid.origin)},
               {"step", grid.step},
               {"largest_error", largest_error},
               {"up", VectorJson(up.norm() > 0.0 ? Eigen::Vector3d(up.normalized()) : Eigen::Vector3d::UnitZ())},
               {"face_list", PackFaces(motion.scene.mesh.faces)},
               {"handles", motion.scene.handles.nodes},
               {"obstacles", Json::array()},
               {"notes", Json::array()}};
  if (source.missing_force != nullptr) json["largest_force"] = Largest(*source.missing_force);
  if (source.start != nullptr) json["start"] = PackPositions(Quantize(grid, *source.start, {0}));
  if (!source.middle.isEmpty()) {
    json["middle"] = {VectorJson(source.middle.min()), VectorJson(source.middle.max())};
  }
  for (const SceneObstacle& obstacle : motion.scene.obstacles) {
    const Json shape = ObstacleJson(obstacle);
    if (shape.contains("type")) {
      json["obstacles"].push_back(shape);
    } else {
      json["notes"].push_back("The obstacle " + obstacle.name + " is of a shape that cannot be drawn here.");
    }
  }
  return json;
}

Json LeftOut(const std::string& reason) { return Json::object({{"left_out", reason}}); }

}  // namespace

bool PointsAreNodes(const RecordedMotion& motion) {
  if (motion.num_points() != motion.scene.mesh.num_nodes()) return false;
  for (int p = 0; p < motion.num_points(); ++p) {
    if (motion.points[static_cast<std::size_t>(p)].num_nodes != 1) return false;
    if (motion.points[static_cast<std::size_t>(p)].nodes[0] != p) return false;
  }
  return true;
}

nlohmann::ordered_json ReplayJson(const ReplaySource& source, std::size_t max_bytes) {
  const std::string too_large = "The cloth is too large for a replay in a page of this size.";
  const RecordedMotion& motion = *source.motion;
  const Eigen::AlignedBox3d box = BoundsOf(source);
  if (box.isEmpty()) return LeftOut("There is nothing to replay.");
  const PositionGrid grid = GridOver(box);
  const double largest_error = source.point_errors != nullptr ? Largest(*source.point_errors) : 0.0;
  double frame_bytes = 2.0 * static_cast<double>(motion.positions.rows());
  for (const Eigen::MatrixXd* more : {source.predicted, source.nodes, source.handles}) {
    if (more != nullptr) frame_bytes += 2.0 * static_cast<double>(more->rows());
  }
  if (frame_bytes > kBestCompression * static_cast<double>(max_bytes)) return LeftOut(too_large);
  Json json = CommonJson(source, grid, largest_error);
  const std::size_t common = json.dump(-1, ' ', false, Json::error_handler_t::replace).size();

  int every = static_cast<int>(std::ceil(frame_bytes * motion.num_frames() / kMaxRawBytes));
  while (common < max_bytes) {
    const Json frames = FramesJson(source, grid, largest_error, every);
    const std::size_t size = frames.dump().size(), room = max_bytes - common;
    if (size <= room) {
      json.update(frames);
      return json;
    }
    const double ratio = static_cast<double>(size) / static_cast<double>(room);
    every = static_cast<int>(std::max(every + 1.0, std::min(std::ceil(every * ratio), 1e9)));
    if (every >= motion.num_frames()) break;  // of which there would be one
  }
  return LeftOut(too_large);
}

Json ForcesJson(const ForceReadings& forces, const Eigen::MatrixXd* predicted, std::size_t max_bytes) {
  constexpr std::size_t kBytesPerNumber = 13;
  constexpr int kForceDigits = 6;
  const auto num_numbers = static_cast<std::size_t>((2 * forces.values.rows() + 1) * forces.num_readings());
  const auto every = static_cast<Eigen::Index>(num_numbers * kBytesPerNumber / max_bytes + 1);
  const auto shown = Eigen::seq(0, forces.num_readings() - 1, every);
  Json components = Json::array();
  for (Eigen::Index row = 0; row < forces.values.rows(); ++row) {
    if (forces.values.row(row).array().isNaN().all()) continue;
    components.push_back({{"group", row / 3 + 1},
                          {"axis", std::string(1, "xyz"[row % 3])},
                          {"measured", RoundedJson(forces.values.row(row).transpose()(shown), kForceDigits)}});
    if (predicted != nullptr)
      components.back()["predicted"] = RoundedJson(predicted->row(row).transpose()(shown), kForceDigits);
  }
  return {{"times", RoundedJson(forces.times(shown), TimeDigits(forces.times, kForceDigits))},
          {"groups", forces.num_groups()},
          {"components", components}};
}

}  // namespace clothid
