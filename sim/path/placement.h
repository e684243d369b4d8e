// How a path is not quite where it was measured: shifted, turned, and on another clock.
#ifndef CLOTHID_SIM_PATH_PLACEMENT_H_
#define CLOTHID_SIM_PATH_PLACEMENT_H_

#include <Eigen/Core>

#include "sim/path/rigid_path.h"

namespace clothid {

// x(t) = c + exp(turn) (A(t + time_offset) p - c) + shift, c where the path has the body's origin first; of a surface
// that deforms (sim/obstacle/surface_sequence.h) the middle of its vertices then.
struct Placement {
  double time_offset = 0.0;                         // s
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();  // m
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();   // axis times angle, rad

  bool operator==(const Placement& other) const {
    return time_offset == other.time_offset && shift == other.shift && turn == other.turn;
  }
};

// One number of a placement.
enum class PlacementPart { kTimeOffset, kShiftX, kShiftY, kShiftZ, kTurnX, kTurnY, kTurnZ };

// `jet`, that of an affine map at t + time_offset, shifted, and turned about c. PlacedChange is its derivative by a
// part of the placement, without the acceleration.
PoseJet Placed(PoseJet jet, const Placement& placement, const Eigen::Vector3d& centre);
PoseJet PlacedChange(const PoseJet& jet, const Placement& placement, const Eigen::Vector3d& centre, PlacementPart part);

// The path at `placement`.
PoseJet PlacedPose(const RigidPath& path, const Placement& placement, double time);

// d/d(part) of its pose and rate; the acceleration is not given.
PoseJet PlacedPoseChange(const RigidPath& path, const Placement& placement, PlacementPart part, double time);

}  // namespace clothid

#endif  // CLOTHID_SIM_PATH_PLACEMENT_H_
