// The part of RecordingModel that is about forces at handles.
#include <algorithm>
#include <cstddef>

#include "costs/prediction/force_prediction.h"
#include "costs/prediction/recording_model.h"
#include "sim/cloth/cloth_model.h"

namespace clothid {

int RecordingModel::num_steps() const {
  const ForceObservation& forces = observation_.forces();
  if (forces.is_empty()) return interpolation_.num_steps();
  return std::max({interpolation_.num_steps(), forces.last_step(), kFewestForceSteps});
}

std::optional<ForcePrediction> RecordingModel::ForcesAt(const Eigen::VectorXd& coordinates) {
  const ForceObservation& forces = observation_.forces();
  if (forces.is_empty()) return std::nullopt;
  const Parameters parameters = ParametersAt(coordinates);
  simulator_.UseParameters(parameters);
  return ForcePrediction(&forces, simulator_.model(), parameters, num_steps(),
                         values_.AlignmentAt(coordinates).ForceBias(forces.num_groups()), values_.IdsOf(ParameterTerm::kSize));
}

Eigen::VectorXd RecordingModel::ForceBiasDerivative(ParameterId id) const {
  const ForceObservation& forces = observation_.forces();
  Eigen::VectorXd derivative = Eigen::VectorXd::Zero(observation_.num_residuals());
  if (id.part >= forces.num_groups()) return derivative;
  Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(3 * forces.num_groups(), forces.num_readings());
  unit.row(3 * static_cast<Eigen::Index>(id.part) + id.axis).setOnes();
  derivative.tail(forces.num_residuals()) = forces.Whiten(unit);
  return derivative;
}

Eigen::MatrixXd RecordingModel::ForcesWithDerivatives(const Eigen::MatrixXd& swept, const SortedBlocks& blocks) {
  Eigen::MatrixXd all = Arranged(swept, blocks);
  for (std::size_t i = 0; i < blocks.corrections.size(); ++i) {
    const ParameterId id = blocks.corrections[i];
    const Eigen::Index row = 3 * static_cast<Eigen::Index>(id.part) + id.axis;
    if (id.kind == ParameterKind::kForceBias && row < all.rows()) all(row, 1 + blocks.correction_places[i]) = 1.0;
  }
  return all;
}

}  // namespace clothid
