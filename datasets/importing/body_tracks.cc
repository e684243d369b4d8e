#include "datasets/importing/body_tracks.h"

#include <Eigen/Geometry>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <system_error>
#include <vector>

#include "sim/base/row_error.h"
#include "sim/base/text_file.h"
#include "sim/matrix/dense.h"

namespace clothid {
namespace {

constexpr double kMarkersOnALine = 1e-2;  // of the length of a line of markers
constexpr double kMostMisfit = 0.1;       // root mean square, of the root mean square distance from the middle

[[noreturn]] void FailOnTracks(const PointTracks& tracks, const std::string& message) {
  throw Error(ErrorKind::kBadData, tracks.name + ": " + message);
}

// In small letters.
std::string Extension(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

// What the first frame and another one both show.
struct SharedMarkers {
  Eigen::Matrix3Xd first, other;

  bool tell_a_pose() const {
    return first.cols() >= 3 && !IsCollinear(first, kMarkersOnALine) && !IsCollinear(other, kMarkersOnALine);
  }
};

SharedMarkers MarkersOf(const PointTracks& markers, Eigen::Index frame) {
  std::vector<Eigen::Index> seen;
  const auto first = markers.positions.col(0).reshaped(3, markers.num_points());
  const auto other = markers.positions.col(frame).reshaped(3, markers.num_points());
  for (Eigen::Index i = 0; i < first.cols(); ++i) {
    if (first.col(i).allFinite() && other.col(i).allFinite()) seen.push_back(i);
  }
  return {first(Eigen::all, seen), other(Eigen::all, seen)};
}

double RootMeanSquare(const Eigen::Matrix3Xd& offsets) {
  return std::sqrt(offsets.squaredNorm() / static_cast<double>(offsets.cols()));
}

}  // namespace

bool IsBodySequence(const std::string& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) return true;
  const std::string extension = Extension(path);
  return extension == ".npy" || extension == ".pc2" || extension == ".obj" || extension == ".ply";
}

bool IsMarkerFile(const std::string& path) { return Extension(path) == ".trc"; }

RigidPath PathOfMarkers(const PointTracks& markers) {
  std::vector<double> times;
  std::vector<Eigen::Isometry3d> poses;
  std::vector<Eigen::Index> frames;
  for (Eigen::Index frame = 0; frame < markers.num_frames(); ++frame) {
    const SharedMarkers shared = MarkersOf(markers, frame);
    if (!shared.tell_a_pose()) {
      if (frame > 0) continue;
      FailOnTracks(markers,
                   "frame 0: expected three markers that are not on a line, of the body as it is at the start");
    }
    const Eigen::Isometry3d pose = RigidMotion(shared.first, shared.other);
    const double misfit = RootMeanSquare(pose * shared.first - shared.other);
    const double size = RootMeanSquare(shared.first.colwise() - Eigen::Vector3d(shared.first.rowwise().mean()));
    if (misfit > kMostMisfit * size) {
      FailOnTracks(markers, "frame " + std::to_string(frame) + ": its markers are " + ShortestText(misfit) +
                                " m off a rigid body (root mean square); expected those of one body, in one order");
    }
    frames.push_back(frame);
    times.push_back(markers.times[frame]);
    poses.push_back(pose);
  }
  const auto count = static_cast<Eigen::Index>(poses.size());
  Eigen::Matrix3Xd positions(3, count);
  Eigen::Matrix4Xd rotations(4, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    positions.col(i) = poses[static_cast<std::size_t>(i)].translation();
    rotations.col(i) = Eigen::Quaterniond(poses[static_cast<std::size_t>(i)].linear()).coeffs();
  }
  try {
    return RigidPath(Eigen::Map<const Eigen::VectorXd>(times.data(), count), positions, rotations);
  } catch (const RowError& error) {
    const Eigen::Index frame = frames[static_cast<std::size_t>(error.row())];
    FailOnTracks(markers, "frame " + std::to_string(frame) + ": " + error.what());
  }
}

SurfaceSequence SequenceOfVertices(const PointTracks& tracks, const TriangulatedSurface& surface,
                                   const Eigen::VectorXd& frame_times, double time_shift) {
  Eigen::VectorXd times = tracks.times;
  if (times.size() == 0 && tracks.num_frames() == frame_times.size()) times = frame_times.array() - time_shift;
  if (times.size() == 0) {
    throw Error(ErrorKind::kUsage, tracks.name + ": has " + std::to_string(tracks.num_frames()) +
                                       " frames without times; expected the " + std::to_string(frame_times.size()) +
                                       " of the recording, or a .npy with times beside it");
  }
  if (tracks.faces.cols() > 0 && tracks.num_points() == surface.vertices().cols() &&
      (tracks.faces.cols() != surface.faces().cols() || tracks.faces != surface.faces())) {
    FailOnTracks(tracks, "has other triangles than the mesh of the obstacle; expected its " +
                             std::to_string(surface.faces().cols()) + ", in their order");
  }
  return SurfaceSequence(surface, times, tracks.positions);
}

}  // namespace clothid
