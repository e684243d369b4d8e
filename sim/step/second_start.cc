#include "sim/step/second_start.h"

namespace clothid {

PairImpactNodes ImpactNodes(const ClothModel& model, const Material& material, const PairCandidate& pair,
                            const Eigen::VectorXd& start_velocities, const Eigen::VectorXd& end_velocities) {
  PairImpactNodes nodes;
  for (int i = 0; i < pair.features.num_nodes(); ++i) {
    const int node = pair.features.nodes[i];
    if (pair.blocks[i] >= 0) nodes.inverse_masses[i] = 1.0 / model.mass(material, node);
    nodes.velocity_changes.col(i) = end_velocities.segment<3>(3 * node) - start_velocities.segment<3>(3 * node);
  }
  return nodes;
}

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
  for (const Contact& contact : contacts.nodes) {
    const int node = contact.candidate.node;
    const Eigen::Vector3d change = first_velocities.segment<3>(3 * node) - start.velocities.segment<3>(3 * node);
    second.velocities.segment<3>(3 * node) -=
        kSecondStageReach * ImpactVelocity(contact, model.mass(material, node), change);
  }
  for (const PairContact& pair : contacts.pairs) {
    const PairImpact impact =
        EvaluatePairImpact(pair, ImpactNodes(model, material, pair.candidate, start.velocities, first_velocities));
    for (int i = 0; i < pair.candidate.features.num_nodes(); ++i) {
      second.velocities.segment<3>(3 * pair.candidate.features.nodes[i]) -=
          kSecondStageReach * impact.portions[i] * impact.velocity;
    }
  }
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
