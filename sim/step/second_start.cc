#include "sim/step/second_start.h"

#include "sim/contact/impact_share.h"

namespace clothid {

SecondStart StartSecondStage(const ClothModel& model, const Material& material, const SolveStart& start,
                             const Eigen::VectorXd& first_positions, const Eigen::VectorXd& first_velocities,
                             double time_step, const ContactSet& contacts) {
  SecondStart second;
  second.positions = start.positions + kSecondStageReach * (first_positions - start.positions);
  for (const int node : model.free_nodes()) {  // not from a difference of positions, which is rounded more
    second.positions.segment<3>(3 * node) =
        start.positions.segment<3>(3 * node) + (kSecondStageReach * time_step) * first_velocities.segment<3>(3 * node);
  }
  second.velocities = start.velocities + kSecondStageReach * (first_velocities - start.velocities);
  SubtractImpacts(contacts, {model, material, start.velocities, first_velocities}, kSecondStageReach,
                  &second.velocities);
  return second;
}

void SetForceStart(const ForceSet& forces, const SolveStart& start, double time_step, const std::vector<int>& handles,
                   const Eigen::VectorXd& end_positions, ForceStart* force_start) {
  if (forces.needs_origins()) {
    force_start->origins.clear();
    if (start.first_positions == nullptr) {
      force_start->origins.push_back({&start.positions, 1.0});
    } else {
      force_start->origins.push_back({start.step_positions, 1.0 - kSecondStageReach});
      force_start->origins.push_back({start.first_positions, kSecondStageReach});
    }
  }
  if (!forces.needs_prediction()) return;
  force_start->predicted = start.positions + time_step * start.velocities;
  for (const int node : handles) force_start->predicted.segment<3>(3 * node) = end_positions.segment<3>(3 * node);
}

}  // namespace clothid
