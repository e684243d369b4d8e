#include "sim/rollout/pair_forces.h"

#include <algorithm>
#include <vector>
namespace clothid {

Eigen::VectorXd PairForces(const ClothModel& model, const Parameters& parameters, const StepRecord& record) {
  const std::vector<int>& handles = model.scene().handles.nodes;
  Eigen::VectorXd forces = Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(handles.size()));
  if (record.contacts.pairs.empty()) return forces;
  const double h = record.time_step;
  const Eigen::VectorXd start = record.positions - h * record.velocities;
  for (const PairContact& contact : RestoreContacts(record, start, {}, parameters, model).pairs) {
    const PairCandidate& pair = contact.candidate;
    for (int i = 0; i < pair.features.num_nodes(); ++i) {
      if (pair.blocks[i] >= 0) continue;
      const auto handle = std::find(handles.begin(), handles.end(), pair.features.nodes[i]) - handles.begin();
      forces.segment<3>(3 * handle) += pair.geometry.weights[i] / h * contact.response.impulse;
    }
  }
  return forces;
}

}  // namespace clothid
