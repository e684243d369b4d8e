#include "sim/obstacle/surface_sequence.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "sim/base/error.h"
#include "sim/path/hermite.h"
#include "sim/path/rotation_vector.h"

namespace clothid {
namespace {

[[noreturn]] void FailOnFrame(Eigen::Index frame, const std::string& message, int vertex = -1) {
  throw MeshError("frame " + std::to_string(frame), message, {-1, vertex});
}

void ValidateTimes(const Eigen::VectorXd& times) {
  for (Eigen::Index i = 0; i < times.size(); ++i) {
    if (std::isfinite(times[i]) && (i == 0 || times[i] > times[i - 1])) continue;
    FailOnFrame(i, "expected a finite time above that of the frame before");
  }
}

// One frame, and how fast it is reached from the one before.
void ValidateFrame(const TriangulatedSurface& surface, const Eigen::VectorXd& times, const Eigen::MatrixXd& positions,
                   Eigen::Index frame) {
  for (Eigen::Index i = 0; i < positions.rows() / 3; ++i) {
    const Eigen::Vector3d place = positions.col(frame).segment<3>(3 * i);
    const std::string vertex = "vertex " + std::to_string(i);
    if (!place.allFinite()) FailOnFrame(frame, vertex + " is not finite", static_cast<int>(i));
    if (frame == 0) continue;
    const double speed =
        (place - positions.col(frame - 1).segment<3>(3 * i)).norm() / (times[frame] - times[frame - 1]);
    if (speed <= kMostPathSpeed) continue;
    FailOnFrame(frame,
                "the sequence jumps: " + vertex + " has a speed of " + std::to_string(speed) +
                    " m/s from the frame before; expected at most " + std::to_string(kMostPathSpeed),
                static_cast<int>(i));
  }
  surface.ExpectOutsideAt(positions.col(frame).reshaped(3, positions.rows() / 3), "frame " + std::to_string(frame));
}

// The columns of a map with corners that have the places, velocities and accelerations `corners` [3 x 3].
struct CornersJet {
  Eigen::Matrix3d place, rate, acceleration;
};

// n = c/|c| of c = (b - a) x (c - a), and its derivatives.
PoseJet FaceMap(const CornersJet& corners) {
  PoseJet jet;
  const auto fill = [](const Eigen::Matrix3d& own, AffineMap* map) {
    *map << own.col(1) - own.col(0), own.col(2) - own.col(0), Eigen::Vector3d::Zero(), own.col(0);
  };
  fill(corners.place, &jet.pose);
  fill(corners.rate, &jet.rate);
  fill(corners.acceleration, &jet.acceleration);
  const auto cross = [](const AffineMap& one, const AffineMap& other) -> Eigen::Vector3d {
    return one.col(0).cross(other.col(1));
  };
  const Eigen::Vector3d area = cross(jet.pose, jet.pose);
  const Eigen::Vector3d area_rate = cross(jet.rate, jet.pose) + cross(jet.pose, jet.rate);
  const Eigen::Vector3d area_acceleration =
      cross(jet.acceleration, jet.pose) + 2.0 * cross(jet.rate, jet.rate) + cross(jet.pose, jet.acceleration);
  const double size = area.norm();
  const Eigen::Vector3d n = area / size;
  const double growth = n.dot(area_rate);
  const Eigen::Vector3d turn = (area_rate - growth * n) / size;  // n'
  // From |c| n = c: |c| n'' = c'' - 2 |c|' n' - |c|'' n, with n . n'' = -|n'|^2.
  const Eigen::Vector3d rest = (area_acceleration - 2.0 * growth * turn) / size;
  jet.pose.col(2) = n;
  jet.rate.col(2) = turn;
  jet.acceleration.col(2) = rest - (n.dot(rest) + turn.squaredNorm()) * n;
  return jet;
}

}  // namespace

SurfaceSequence::SurfaceSequence(const TriangulatedSurface& surface, const Eigen::VectorXd& times,
                                 const Eigen::MatrixXd& positions)
    : surface_(surface), times_(times), positions_(positions) {
  if (times.size() == 0 || positions.cols() != times.size()) {
    throw Error(ErrorKind::kBadData, "expected at least one frame and a time of each, and there are " +
                                         std::to_string(positions.cols()) + " frames and " +
                                         std::to_string(times.size()) + " times");
  }
  if (positions.rows() != surface.vertices().size()) {
    throw Error(ErrorKind::kBadData, "frames of " + std::to_string(positions.rows() / 3) + " vertices; expected the " +
                                         std::to_string(surface.vertices().cols()) + " of the mesh");
  }
  ValidateTimes(times_);
  for (Eigen::Index frame = 0; frame < times_.size(); ++frame) ValidateFrame(surface_, times_, positions_, frame);
  slopes_ = ParabolaSlopes(times_, positions_);
  centre_ = positions_.col(0).reshaped(3, num_vertices()).rowwise().mean();
}

VerticesJet SurfaceSequence::At(const Placement& placement, double time) const {
  const HermiteWeights at(times_, time + placement.time_offset);
  const auto combine = [&](const Eigen::Vector3d& weights) {
    return weights[0] * (positions_.col(at.second) - positions_.col(at.first)) + weights[1] * slopes_.col(at.first) +
           weights[2] * slopes_.col(at.second);
  };
  VerticesJet jet;
  jet.pose = (positions_.col(at.first) + combine(at.value)).reshaped(3, num_vertices());
  jet.rate = combine(at.rate).reshaped(3, num_vertices());
  if (!placement.turn.isZero(0.0)) {
    const Eigen::Matrix3d turn = RotationByVector(placement.turn).rotation;
    jet.pose = ((turn * jet.pose).colwise() + (centre_ - turn * centre_)).eval();
    jet.rate = (turn * jet.rate).eval();
  }
  jet.pose.colwise() += placement.shift;
  return jet;
}

PoseJet SurfaceSequence::UnplacedFace(int face, double time) const {
  const HermiteWeights at(times_, time);
  CornersJet corners;
  for (int k = 0; k < 3; ++k) {
    const Eigen::Index row = 3 * static_cast<Eigen::Index>(surface_.faces()(k, face));
    const Eigen::Vector3d start = positions_.col(at.first).segment<3>(row);
    Eigen::Matrix3d parts;
    parts << positions_.col(at.second).segment<3>(row) - start, slopes_.col(at.first).segment<3>(row),
        slopes_.col(at.second).segment<3>(row);
    corners.place.col(k) = start + parts * at.value;
    corners.rate.col(k) = parts * at.rate;
    corners.acceleration.col(k) = parts * at.acceleration;
  }
  return FaceMap(corners);
}

PoseJet SurfaceSequence::FaceAt(int face, const Placement& placement, double time) const {
  return Placed(UnplacedFace(face, time + placement.time_offset), placement, centre_);
}

PoseJet SurfaceSequence::FaceChange(int face, const Placement& placement, PlacementPart part, double time) const {
  return PlacedChange(UnplacedFace(face, time + placement.time_offset), placement, centre_, part);
}

}  // namespace clothid
