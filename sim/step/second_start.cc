#include "sim/step/second_start.h"

#include "sim/contact/impact_share.h"

namespace clothid {

SecondStart StartSecondStage(const ClothModel& model, const Material& material, const SolveStart& start,
                             const Eigen::VectorXd& first_positions, const Eigen::VectorXd& first_velocities,
                             double time_step, const std::vector<Contact>& contacts) {
  SecondStart second;
  second.positions = start.positions + kSecondStageReach * (first_positions - start.positions);
  for (const int node : model.free_nodes()) {  // not from a difference of positions, which is rounded more
    second.positions.segment<3>(3 * node) =
        start.positions.segment<3>(3 * node) + (kSecondStageReach * time_step) * first_velocities.segment<3>(3 * node);
  }
  second.velocities = start.velocities + kSecondStageReach * (first_velocities - start.velocities);
  for (const Contact& contact : contacts) {
    const int node = contact.candidate.node;
    const Eigen::Vector3d change = first_velocities.segment<3>(3 * node) - start.velocities.segment<3>(3 * node);
    second.velocities.segment<3>(3 * node) -=
        kSecondStageReach * ImpactVelocity(contact, model.mass(material, node), change);
  }
  return second;
}

void SetStartMetrics(const ClothModel& model, const SolveStart& start, std::vector<MetricBatch>* metrics) {
  if (start.first_positions == nullptr) {
    model.damping()->SetMetrics(start.positions, metrics);
  } else {
    model.damping()->ExtrapolateMetrics(*start.step_positions, *start.first_positions, kSecondStageReach, metrics);
  }
}

}  // namespace clothid
