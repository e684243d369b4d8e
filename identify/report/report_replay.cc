#include "identify/report/report_replay.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <string>
#include <string_view>
#include <vector>

#include "identify/report/packed_array.h"
#include "identify/report/page_template.h"
#include "sim/scene/triangulated_surface.h"

namespace clothid {
namespace {

using Json = nlohmann::ordered_json;

// What is quantised at once, whatever is left of it when it is packed.
constexpr double kMaxRawBytes = 1.0e8;
// More than that is not to be expected of its compression.
constexpr double kBestCompression = 8.0;
constexpr int kReplayDigits = 7;

Json VectorJson(const Eigen::VectorXd& vector) {
  Json json = Json::array();
  for (const double value : vector) json.push_back(RoundedJson(value, kReplayDigits));
  return json;
}

template <typename Scalar>
std::string PackMatrix(const Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>& matrix) {
  return PackBytes({reinterpret_cast<const char*>(matrix.data()), sizeof(Scalar) * matrix.size()});
}

std::string PackFaces(const Eigen::Matrix3Xi& faces) { return PackMatrix<std::int32_t>(faces.cast<std::int32_t>()); }

Json ObstacleJson(const SceneObstacle& obstacle) {
  Json json = Json::object();
  json["name"] = obstacle.name;
  if (const auto* plane = dynamic_cast<const Plane*>(obstacle.shape.get())) {
    json["type"] = "plane";
    json["point"] = VectorJson(plane->point());
    json["normal"] = VectorJson(plane->normal());
  } else if (const auto* sphere = dynamic_cast<const Sphere*>(obstacle.shape.get())) {
    json["type"] = "sphere";
    json["center"] = VectorJson(sphere->center());
    json["radius"] = sphere->radius();
  } else if (const auto* capsule = dynamic_cast<const Capsule*>(obstacle.shape.get())) {
    json["type"] = "capsule";
    json["from"] = VectorJson(capsule->from());
    json["to"] = VectorJson(capsule->to());
    json["radius"] = capsule->radius();
  } else if (const auto* surface = dynamic_cast<const TriangulatedSurface*>(obstacle.shape.get())) {
    json["type"] = "mesh";
    json["vertices"] = PackMatrix<float>(surface->vertices().cast<float>());
    json["faces"] = PackFaces(surface->faces());
  }
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

// Of the predicted cloth and of recorded points that are not astray: a single one far off would coarsen the grid for
// all others.
Eigen::AlignedBox3d Box(const ReplaySource& source) {
  Eigen::AlignedBox3d predicted, recorded;
  AddPoints(*source.predicted, &predicted);
  if (source.nodes != nullptr) AddPoints(*source.nodes, &predicted);
  AddPoints(source.motion->positions, &recorded);
  if (predicted.isEmpty() || recorded.isEmpty()) return predicted.merged(recorded);
  const Eigen::Vector3d margin = Eigen::Vector3d::Constant(predicted.diagonal().norm());
  const Eigen::AlignedBox3d near(predicted.min() - margin, predicted.max() + margin);
  return predicted.merged(recorded.intersection(near));
}

std::string PackErrors(const Eigen::MatrixXd& errors, double largest, const std::vector<int>& frames) {
  constexpr double kDecades = 6.0, kLargestByte = 254.0;
  std::string bytes;
  bytes.reserve(frames.size() * static_cast<std::size_t>(errors.rows()));
  for (const int frame : frames) {
    for (const double error : errors.col(frame)) {
      const double q = kLargestByte * (1.0 + std::log10(error / largest) / kDecades);  // -inf for 0
      bytes +=
          std::isnan(error) ? '\xff' : static_cast<char>(static_cast<unsigned char>(std::clamp(q, 0.0, kLargestByte)));
    }
  }
  return PackBytes(bytes);
}

double Largest(const Eigen::MatrixXd& errors) {
  double largest = 0.0;
  for (const double error : errors.reshaped()) largest = std::max(largest, std::isnan(error) ? 0.0 : error);
  return largest;
}

// The frames 0, every, 2 every, ..
std::vector<int> EveryFrame(int num_frames, int every) {
  std::vector<int> frames;
  for (int frame = 0; frame < num_frames; frame += every) frames.push_back(frame);
  return frames;
}

// What changes over time.
Json FramesJson(const ReplaySource& source, const PositionGrid& grid, double largest_error, int every) {
  const RecordedMotion& motion = *source.motion;
  const std::vector<int> frames = EveryFrame(motion.num_frames(), every);
  Json json = {{"every", every}, {"times", Json::array()}};
  for (const int frame : frames) json["times"].push_back(RoundedJson(motion.times[frame], kReplayDigits));
  json["recorded"] = PackPositions(Quantize(grid, motion.positions, frames));
  json["predicted"] = PackPositions(Quantize(grid, *source.predicted, frames));
  if (source.nodes != nullptr) json["nodes"] = PackPositions(Quantize(grid, *source.nodes, frames));
  json["errors"] = PackErrors(*source.point_errors, largest_error, frames);
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

Json LeftOut(const std::string& reason) {
  Json json = Json::object();
  json["left_out"] = reason;
  return json;
}

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
  const Eigen::AlignedBox3d box = Box(source);
  if (box.isEmpty()) return LeftOut("There is nothing to replay.");
  const PositionGrid grid = GridOver(box);
  const double largest_error = Largest(*source.point_errors);
  const double num_nodes = source.nodes != nullptr ? motion.scene.mesh.num_nodes() : 0.0;
  const double frame_bytes = 6.0 * (2.0 * motion.num_points() + num_nodes);
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

}  // namespace clothid
