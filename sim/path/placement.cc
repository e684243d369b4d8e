#include "sim/path/placement.h"

#include "sim/path/rotation_vector.h"

namespace clothid {

PoseJet Placed(PoseJet jet, const Placement& placement, const Eigen::Vector3d& centre) {
  if (!placement.turn.isZero(0.0)) {
    const Eigen::Matrix3d turn = RotationByVector(placement.turn).rotation;
    jet.pose = turn * jet.pose;
    jet.pose.col(3) += centre - turn * centre;
    jet.rate = turn * jet.rate;
    jet.acceleration = turn * jet.acceleration;
  }
  jet.pose.col(3) += placement.shift;
  return jet;
}

PoseJet PlacedChange(const PoseJet& unplaced, const Placement& placement, const Eigen::Vector3d& centre,
                     PlacementPart part) {
  PoseJet change;
  change.pose.setZero();
  const PoseJet jet = Placed(unplaced, placement, centre);
  const int index = static_cast<int>(part);
  if (part == PlacementPart::kTimeOffset) {
    change.pose = jet.rate;
    change.rate = jet.acceleration;
  } else if (index < static_cast<int>(PlacementPart::kTurnX)) {
    change.pose(index - static_cast<int>(PlacementPart::kShiftX), 3) = 1.0;
  } else {
    const Eigen::Matrix3d spin = CrossMatrix(
        RotationByVector(placement.turn).left_jacobian.col(index - static_cast<int>(PlacementPart::kTurnX)));
    change.pose = spin * jet.pose;
    change.pose.col(3) -= spin * (centre + placement.shift);
    change.rate = spin * jet.rate;
  }
  return change;
}

PoseJet PlacedPose(const RigidPath& path, const Placement& placement, double time) {
  return Placed(path.At(time + placement.time_offset), placement, path.positions().col(0));
}

PoseJet PlacedPoseChange(const RigidPath& path, const Placement& placement, PlacementPart part, double time) {
  return PlacedChange(path.At(time + placement.time_offset), placement, path.positions().col(0), part);
}

}  // namespace clothid
