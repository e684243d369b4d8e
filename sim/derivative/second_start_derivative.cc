#include "sim/derivative/second_start_derivative.h"

namespace clothid {

SecondStartDerivative::SecondStartDerivative(const StepRecord& first, const SolveStart& start,
                                             const StepDerivative& step, const Parameters& parameters,
                                             const ClothModel& model) {
  for (std::size_t i = 0; i < step.contacts().size(); ++i) {
    const Contact& contact = step.contacts()[i];
    const int node = contact.candidate.node;
    const double mass = model.mass(parameters.material, node);
    const Eigen::Vector3d change = first.velocities.segment<3>(3 * node) - start.velocities.segment<3>(3 * node);
    if (ImpactShare(contact, mass, change) == 0.0) continue;
    ImpactVelocityDerivative derivative = DifferentiateImpactVelocity(contact, mass, change, step.motion_of(contact));
    derivative.change *= kSecondStageReach;
    derivative.impulse *= kSecondStageReach;
    derivative.normal *= kSecondStageReach;
    derivative.position *= kSecondStageReach;
    derivative.mass *= kSecondStageReach;
    impacts_.push_back({node, 3 * model.free_index()[node], i, derivative});
  }
  num_rows_ = 3 * model.num_free();
}

StateColumns SecondStartDerivative::Times(const StateColumns& start, const StateColumns& first) const {
  return {start.positions + kSecondStageReach * (first.positions - start.positions),
          start.velocities + kSecondStageReach * (first.velocities - start.velocities)};
}

void SecondStartDerivative::SubtractImpacts(const StateColumns& start, const StateColumns& first,
                                            const Eigen::MatrixXd& impulse, StateColumns* second) const {
  for (const auto& [node, row, contact, impact] : impacts_) {
    second->velocities.middleRows<3>(row) -=
        impact.change * (first.velocities.middleRows<3>(row) - start.velocities.middleRows<3>(row)) +
        impact.impulse * impulse.middleRows<3>(row) + impact.position * start.positions.middleRows<3>(row);
  }
}

void SecondStartDerivative::SubtractMasses(int column, const Eigen::VectorXd& masses, StateColumns* second) const {
  for (const auto& [node, row, contact, impact] : impacts_) {
    second->velocities.col(column).segment<3>(row) -= masses[node] * impact.mass;
  }
}

void SecondStartDerivative::AddTransposed(const StateColumns& second, StateColumns* start, StateColumns* first) const {
  start->positions += (1.0 - kSecondStageReach) * second.positions;
  start->velocities += (1.0 - kSecondStageReach) * second.velocities;
  first->positions += kSecondStageReach * second.positions;
  first->velocities += kSecondStageReach * second.velocities;
}

Eigen::MatrixXd SecondStartDerivative::AddImpactsTransposed(const StateColumns& second, StateColumns* start,
                                                            StateColumns* first) const {
  Eigen::MatrixXd impulse = Eigen::MatrixXd::Zero(second.velocities.rows(), second.velocities.cols());
  for (const auto& [node, row, contact, impact] : impacts_) {
    const Eigen::MatrixXd rows = second.velocities.middleRows<3>(row);
    const Eigen::MatrixXd by_change = impact.change.transpose() * rows;
    first->velocities.middleRows<3>(row) -= by_change;
    start->velocities.middleRows<3>(row) += by_change;
    start->positions.middleRows<3>(row) -= impact.position.transpose() * rows;
    impulse.middleRows<3>(row) = -(impact.impulse.transpose() * rows);
  }
  return impulse;
}

Eigen::VectorXd SecondStartDerivative::MotionDerivative(const std::vector<MotionChange>& changes) const {
  Eigen::VectorXd derivative = Eigen::VectorXd::Zero(num_rows_);
  for (const auto& [node, row, contact, impact] : impacts_) {
    derivative.segment<3>(row) =
        impact.normal * changes[contact].normal - impact.change * changes[contact].velocity_change;
  }
  return derivative;
}

Eigen::RowVectorXd SecondStartDerivative::MassGradient(const Eigen::VectorXd& slopes,
                                                       const StateColumns& second) const {
  Eigen::RowVectorXd gradient = Eigen::RowVectorXd::Zero(second.velocities.cols());
  for (const auto& [node, row, contact, impact] : impacts_) {
    gradient -= slopes[node] * (impact.mass.transpose() * second.velocities.middleRows<3>(row));
  }
  return gradient;
}

void SecondStartDerivative::AddMassGradient(const StateColumns& second, Eigen::MatrixXd* gradient) const {
  for (const auto& [node, row, contact, impact] : impacts_) {
    gradient->row(node) -= impact.mass.transpose() * second.velocities.middleRows<3>(row);
  }
}

}  // namespace clothid
