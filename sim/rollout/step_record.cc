#include "sim/rollout/step_record.h"

#include <cstdio>

#include "sim/cloth/cloth_model.h"
#include "sim/step/obstacle_motions.h"
#include "sim/step/step_problem.h"

namespace clothid {

ContactSet RestoreContacts(const StepRecord& record, const Eigen::VectorXd& start_positions,
                           const std::vector<ObstacleMotion>& motions, const Parameters& parameters,
                           const ClothModel& model) {
  const Scene& scene = model.scene();
  const double gap_time = record.times().gap_time();
  const auto weight = [&](int node) { return SystemDiagonal(model, parameters.material, record.time_step, node); };
  ContactSet contacts;
  contacts.nodes.reserve(record.contacts.nodes.size());
  for (const ContactRecord& kept : record.contacts.nodes) {
    ContactCandidate candidate;
    FindCandidate(model, kept.node, start_positions, gap_time, motions, &candidate);
    const double mu = parameters.friction_coefficients[kept.obstacle];
    contacts.nodes.push_back(
        {candidate, EvaluateContactLaw(kept.force, candidate.normal, mu), kept.force, weight(kept.node),
         ObstacleGain(motions, candidate.obstacle, start_positions.segment<3>(3 * candidate.node)), mu});
  }
  for (const PairContactRecord& kept : record.contacts.pairs) {
    PairCandidate candidate = MakePairCandidate(kept.features, start_positions, model.free_index(),
                                                scene.self_contact->thickness, gap_time, scene.depenetration_speed);
    Eigen::Vector4d weights = Eigen::Vector4d::Zero();
    for (int i = 0; i < kept.features.num_nodes(); ++i) weights[i] = weight(kept.features.nodes[i]);
    candidate.SetNodes(record.velocities, weights);
    candidate.has_friction = kept.has_friction;
    const double mu = candidate.FrictionOf(parameters.self_friction);
    contacts.pairs.push_back(
        {candidate, EvaluateContactLaw(kept.force, candidate.geometry.normal, mu), kept.force, mu});
  }
  return contacts;
}

std::string StepFailure::ToString() const {
  const std::string what = "step " + std::to_string(step) + " " + reason;
  if (tolerance == 0.0) return what;
  char numbers[160];
  std::snprintf(numbers, sizeof(numbers), ": relative residual %.2e, tolerance %.2e, %d stick, %d slip, %d free",
                residual, tolerance, num_stick, num_slip, num_take_off);
  return what + numbers;
}

}  // namespace clothid
