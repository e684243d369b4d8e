#include "datasets/importing/handle_tracks.h"

#include <algorithm>
#include <string>

#include "datasets/formats/ros_csv.h"
#include "datasets/importing/path_times.h"
#include "sim/base/error.h"
#include "sim/base/json_document.h"
#include "sim/base/row_error.h"
#include "sim/base/text_file.h"
#include "sim/path/handle_csv.h"
#include "sim/path/handle_path.h"

namespace clothid {
namespace {

// Where the tool holds each of the nodes [3 x H] m.
Eigen::Matrix3Xd ReadOffsets(const std::string& path, const std::vector<int>& nodes) {
  Eigen::Matrix3Xd offsets(3, static_cast<Eigen::Index>(nodes.size()));
  const JsonValue document = ParseJson(ReadText(path, kMaxJsonBytes), path);
  const JsonNode root(document, path);
  for (const std::string& key : root.keys()) {
    const bool known = std::any_of(nodes.begin(), nodes.end(), [&](int node) { return std::to_string(node) == key; });
    if (!known) root.Find(key)->Fail("is not one of the handles' nodes");
  }
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    offsets.col(static_cast<Eigen::Index>(i)) =
        root.Require(std::to_string(nodes[i]), "where the tool holds this node: [x, y, z] (m)").Vector3();
  }
  return offsets;
}

HandlePath PathOfTool(const HandleFile& file, const std::vector<int>& nodes) {
  const PoseTrack poses = ReadRosPoses(file.path);
  if (file.offsets_path.empty() && nodes.size() > 1) {
    throw Error(ErrorKind::kUsage, file.path + ": one tool for " + std::to_string(nodes.size()) +
                                       " nodes; expected a file that says where it holds each of them");
  }
  const Eigen::Matrix3Xd offsets = file.offsets_path.empty() ? Eigen::Matrix3Xd(Eigen::Matrix3Xd::Zero(3, 1))
                                                             : ReadOffsets(file.offsets_path, nodes);
  Eigen::MatrixXd positions(3 * offsets.cols(), poses.times.size());
  for (Eigen::Index t = 0; t < poses.times.size(); ++t) {
    const Eigen::Vector4d xyzw = poses.rotations.col(t);
    const Eigen::Matrix3d rotation = Eigen::Quaterniond(xyzw[3], xyzw[0], xyzw[1], xyzw[2]).toRotationMatrix();
    const Eigen::Matrix3Xd held = (rotation * offsets).colwise() + poses.positions.col(t);
    positions.col(t) = held.reshaped();
  }
  return NamingLines(file.path, poses.lines, [&] { return HandlePath(poses.times, positions); });
}

}  // namespace

void ExpectOneClock(const Handles& handles, const Eigen::VectorXd& times, const std::string& source) {
  const Eigen::VectorXd& known = handles.path.times();
  if (known.size() < 2 || (times[0] <= known[known.size() - 1] && times[times.size() - 1] >= known[0])) return;
  FailOfClock(known, times, source + ": the path of its handles", "one clock for both");
}

void SetHandlePaths(const Handles& handles, MotionTensors* motion) {
  if (handles.nodes.empty() || handles.path.num_handles() == 0) return;
  const Eigen::VectorXd& times = motion->times;
  motion->handle_index = handles.nodes;
  motion->handle_times.resize(0);
  motion->handle_positions.resize(3 * static_cast<Eigen::Index>(handles.nodes.size()), times.size());
  for (Eigen::Index frame = 0; frame < times.size(); ++frame) {
    motion->handle_positions.col(frame) = handles.path.At(times[frame]);
  }
}

void KeepHandlePaths(const Handles& handles, MotionTensors* motion) {
  if (handles.nodes.empty() || handles.path.num_handles() == 0) return;
  const Eigen::VectorXd &knots = handles.path.times(), &times = motion->times;
  const KnotRange needed = NeededKnots(knots, times);
  motion->handle_index = handles.nodes;
  motion->handle_times = knots.segment(needed.first, needed.count);
  motion->handle_positions = handles.path.positions().middleCols(needed.first, needed.count);
}

HandlePath ReadHandlePath(const HandleFile& file, const std::vector<int>& nodes, const Eigen::VectorXd& times,
                          double time_shift) {
  const HandlePath own =
      IsRosCsv(file.path) ? PathOfTool(file, nodes) : ReadHandleCsv(file.path, static_cast<int>(nodes.size()));
  ExpectSeconds(own.times(), file.path);
  Eigen::MatrixXd positions = own.positions();
  for (Eigen::Index t = 0; t < positions.cols(); ++t) {
    for (Eigen::Index i = 0; i < positions.rows(); i += 3) {
      const Eigen::Vector3d position = positions.col(t).segment<3>(i);
      positions.col(t).segment<3>(i) = file.transform * position;
    }
  }
  HandlePath path((own.times().array() - file.time_offset) + time_shift, positions);
  ExpectCovered(path.times(), times, file.path);
  return path;
}

Eigen::MatrixXd MeasuredHandlePositions(const Eigen::VectorXd& times, const Eigen::MatrixXd& positions,
                                        const std::vector<int>& points, const std::string& source) {
  Eigen::MatrixXd result(3 * static_cast<Eigen::Index>(points.size()), times.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto measured = positions.middleRows<3>(3 * points[i]);
    std::vector<Eigen::Index> seen;
    for (Eigen::Index frame = 0; frame < times.size(); ++frame) {
      if (measured.col(frame).allFinite()) seen.push_back(frame);
    }
    if (seen.empty()) {
      throw Error(ErrorKind::kBadData, source + ": point " + std::to_string(points[i]) +
                                           " is never seen; expected the path of a handle from another file");
    }
    const HandlePath path(times(seen), measured(Eigen::all, seen));
    auto filled = result.middleRows<3>(3 * static_cast<Eigen::Index>(i));
    filled = measured;
    for (Eigen::Index frame = 0; frame < times.size(); ++frame) {
      if (!measured.col(frame).allFinite()) filled.col(frame) = path.At(times[frame]);
    }
  }
  return result;
}

}  // namespace clothid
