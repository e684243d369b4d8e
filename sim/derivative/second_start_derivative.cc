#include "sim/derivative/second_start_derivative.h"

#include "sim/step/second_start.h"

namespace clothid {
namespace {

// A number of every node [N], of those of a pair.
Eigen::Vector4d OfPairNodes(const PairCandidate& pair, const Eigen::VectorXd& values) {
  Eigen::Vector4d result = Eigen::Vector4d::Zero();
  for (int i = 0; i < pair.features.num_nodes(); ++i) result[i] = values[pair.features.nodes[i]];
  return result;
}

}  // namespace

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
  if (step.pairs() != nullptr) FindPairImpacts(first, start, step, parameters, model);
}

void SecondStartDerivative::FindPairImpacts(const StepRecord& first, const SolveStart& start,
                                            const StepDerivative& step, const Parameters& parameters,
                                            const ClothModel& model) {
  const std::vector<PairContact>& contacts = step.pairs()->contacts();
  num_pairs_ = contacts.size();
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const PairCandidate& pair = contacts[c].candidate;
    const PairImpactNodes nodes = ImpactNodes(model, parameters.material, pair, start.velocities, first.velocities);
    PairImpactTerm term{&pair, step.pairs()->blocks(c, PairNodes::kHandles), c, EvaluatePairImpact(contacts[c], nodes),
                        DifferentiatePairImpact(contacts[c], step.pairs()->gradient(c), nodes)};
    if (term.impact.share == 0.0) continue;
    term.impact.velocity *= kSecondStageReach;
    term.derivative.change *= kSecondStageReach;
    term.derivative.impulse *= kSecondStageReach;
    term.derivative.position *= kSecondStageReach;
    pair_impacts_.push_back(term);
  }
}

// du_i = p_i dB + B dp_i.
Eigen::Matrix<double, 12, 12> SecondStartDerivative::PairImpactTerm::ByPosition() const {
  Eigen::Matrix<double, 12, 12> matrix;
  for (int i = 0; i < 4; ++i) {
    matrix.middleRows<3>(3 * i) =
        impact.portions[i] * derivative.position + impact.velocity * derivative.portions.row(i);
  }
  return matrix;
}

Eigen::Matrix<double, 12, 12> SecondStartDerivative::PairImpactTerm::ByChange() const {
  Eigen::Matrix<double, 12, 12> matrix;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      matrix.block<3, 3>(3 * i, 3 * j) = impact.portions[i] * pair->geometry.weights[j] * derivative.change;
    }
  }
  return matrix;
}

Eigen::Matrix<double, 12, 3> SecondStartDerivative::PairImpactTerm::ByImpulse() const {
  Eigen::Matrix<double, 12, 3> matrix;
  for (int i = 0; i < 4; ++i) matrix.middleRows<3>(3 * i) = impact.portions[i] * derivative.impulse;
  return matrix;
}

Eigen::Matrix<double, 12, 4> SecondStartDerivative::PairImpactTerm::ByMasses() const {
  Eigen::Matrix<double, 12, 4> matrix;
  for (int i = 0; i < 4; ++i) matrix.middleRows<3>(3 * i) = impact.velocity * derivative.masses.row(i);
  return matrix;
}

StateColumns SecondStartDerivative::Times(const StateColumns& start, const StateColumns& first) const {
  return {start.positions + kSecondStageReach * (first.positions - start.positions),
          start.velocities + kSecondStageReach * (first.velocities - start.velocities)};
}

void SecondStartDerivative::SubtractImpacts(const StateColumns& start, const StateColumns& first,
                                            const Eigen::MatrixXd& impulse, const Eigen::MatrixXd& pair_impulses,
                                            StateColumns* second) const {
  for (const auto& [node, row, contact, impact] : impacts_) {
    second->velocities.middleRows<3>(row) -=
        impact.change * (first.velocities.middleRows<3>(row) - start.velocities.middleRows<3>(row)) +
        impact.impulse * impulse.middleRows<3>(row) + impact.position * start.positions.middleRows<3>(row);
  }
  for (const PairImpactTerm& term : pair_impacts_) {
    const Eigen::Index row = 3 * static_cast<Eigen::Index>(term.contact);
    ScatterToPair(term.pair->blocks,
                  term.ByChange() * GatherFromPair(term.pair->blocks, start.velocities - first.velocities) -
                      term.ByImpulse() * pair_impulses.middleRows<3>(row) -
                      term.ByPosition() * GatherFromPair(term.pair->blocks, start.positions),
                  &second->velocities);
  }
}

void SecondStartDerivative::SubtractHandleImpacts(const Eigen::MatrixXd& positions, const Eigen::MatrixXd& changes,
                                                  Eigen::MatrixXd* velocities) const {
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(velocities->rows(), positions.cols());
  for (const PairImpactTerm& term : pair_impacts_) {
    ScatterToPair(term.pair->blocks,
                  term.ByPosition() * GatherFromPair(term.handles, positions) +
                      term.ByChange() * GatherFromPair(term.handles, changes),
                  &sum);
  }
  velocities->rightCols(sum.cols()) -= sum;
}

void SecondStartDerivative::AddHandleImpactsTransposed(const StateColumns& second, Eigen::MatrixXd* positions,
                                                       Eigen::MatrixXd* changes) const {
  for (const PairImpactTerm& term : pair_impacts_) {
    const Eigen::MatrixXd rows = -GatherFromPair(term.pair->blocks, second.velocities);
    ScatterToPair(term.handles, term.ByPosition().transpose() * rows, positions);
    ScatterToPair(term.handles, term.ByChange().transpose() * rows, changes);
  }
}

void SecondStartDerivative::SubtractMasses(int column, const Eigen::VectorXd& masses, StateColumns* second) const {
  for (const auto& [node, row, contact, impact] : impacts_) {
    second->velocities.col(column).segment<3>(row) -= masses[node] * impact.mass;
  }
  for (const PairImpactTerm& term : pair_impacts_) {
    const Eigen::Matrix<double, 12, 1> change = -term.ByMasses() * OfPairNodes(*term.pair, masses);
    for (int i = 0; i < 4; ++i) {
      if (term.pair->blocks[i] < 0) continue;
      second->velocities.col(column).segment<3>(3 * term.pair->blocks[i]) += change.segment<3>(3 * i);
    }
  }
}

void SecondStartDerivative::AddTransposed(const StateColumns& second, StateColumns* start, StateColumns* first) const {
  start->positions += (1.0 - kSecondStageReach) * second.positions;
  start->velocities += (1.0 - kSecondStageReach) * second.velocities;
  first->positions += kSecondStageReach * second.positions;
  first->velocities += kSecondStageReach * second.velocities;
}

Eigen::MatrixXd SecondStartDerivative::AddImpactsTransposed(const StateColumns& second, StateColumns* start,
                                                            StateColumns* first, Eigen::MatrixXd* pair_impulses) const {
  Eigen::MatrixXd impulse = Eigen::MatrixXd::Zero(second.velocities.rows(), second.velocities.cols());
  for (const auto& [node, row, contact, impact] : impacts_) {
    const Eigen::MatrixXd rows = second.velocities.middleRows<3>(row);
    const Eigen::MatrixXd by_change = impact.change.transpose() * rows;
    first->velocities.middleRows<3>(row) -= by_change;
    start->velocities.middleRows<3>(row) += by_change;
    start->positions.middleRows<3>(row) -= impact.position.transpose() * rows;
    impulse.middleRows<3>(row) = -(impact.impulse.transpose() * rows);
  }
  *pair_impulses = Eigen::MatrixXd::Zero(3 * static_cast<Eigen::Index>(num_pairs_), second.velocities.cols());
  for (const PairImpactTerm& term : pair_impacts_) {
    const Eigen::MatrixXd rows = GatherFromPair(term.pair->blocks, second.velocities);
    const Eigen::MatrixXd by_change = term.ByChange().transpose() * rows;
    ScatterToPair(term.pair->blocks, -by_change, &first->velocities);
    ScatterToPair(term.pair->blocks, by_change, &start->velocities);
    ScatterToPair(term.pair->blocks, -term.ByPosition().transpose() * rows, &start->positions);
    pair_impulses->middleRows<3>(3 * static_cast<Eigen::Index>(term.contact)) = -term.ByImpulse().transpose() * rows;
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
  for (const PairImpactTerm& term : pair_impacts_) {
    gradient -= (term.ByMasses() * OfPairNodes(*term.pair, slopes)).transpose() *
                GatherFromPair(term.pair->blocks, second.velocities);
  }
  return gradient;
}

void SecondStartDerivative::AddMassGradient(const StateColumns& second, Eigen::MatrixXd* gradient) const {
  for (const auto& [node, row, contact, impact] : impacts_) {
    gradient->row(node) -= impact.mass.transpose() * second.velocities.middleRows<3>(row);
  }
  for (const PairImpactTerm& term : pair_impacts_) {
    const Eigen::MatrixXd by_masses =
        term.ByMasses().transpose() * GatherFromPair(term.pair->blocks, second.velocities);
    for (int i = 0; i < term.pair->features.num_nodes(); ++i) {
      gradient->row(term.pair->features.nodes[i]) -= by_masses.row(i);
    }
  }
}

}  // namespace clothid
