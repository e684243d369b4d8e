#include "sim/path/placement.h"

#include "sim/path/rotation_vector.h"

namespace clothid {

PoseJet PlacedPose(const RigidPath& path, const Placement& placement, double time) {
  PoseJet jet = path.At(time + placement.time_offset);
  if (!placement.turn.isZero(0.0)) {
    const Eigen::Matrix3d turn = RotationByVector(placement.turn).rotation;
    const Eigen::Vector3d centre = path.positions().col(0);
    jet.pose = turn * jet.pose;
    jet.pose.col(3) += centre - turn * centre;
    jet.rate = turn * jet.rate;
    jet.acceleration = turn * jet.acceleration;
  }
  jet.pose.col(3) += placement.shift;
  return jet;
}

PoseJet PlacedPoseChange(const RigidPath& path, const Placement& placement, PlacementPart part, double time) {
  PoseJet change;
  change.pose.setZero();
  const PoseJet jet = PlacedPose(path, placement, time);
  const int index = static_cast<int>(part);
  if (part == PlacementPart::kTimeOffset) {
    change.pose = jet.rate;
    change.rate = jet.acceleration;
  } else if (index < static_cast<int>(PlacementPart::kTurnX)) {
    change.pose(index - static_cast<int>(PlacementPart::kShiftX), 3) = 1.0;
  } else {
    const Eigen::Matrix3d spin = CrossMatrix(
        RotationByVector(placement.turn).left_jacobian.col(index - static_cast<int>(PlacementPart::kTurnX)));
    const Eigen::Vector3d centre = path.positions().col(0);
    change.pose = spin * jet.pose;
    change.pose.col(3) -= spin * (centre + placement.shift);
    change.rate = spin * jet.rate;
  }
  return change;
}

}  // namespace clothid
