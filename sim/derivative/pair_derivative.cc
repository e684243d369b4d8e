#include "sim/derivative/pair_derivative.h"

#include <utility>

namespace clothid {

PairColumns GatherFromPair(const PairCandidate& pair, const Eigen::MatrixXd& columns) {
  PairColumns values = PairColumns::Zero(12, columns.cols());
  for (int i = 0; i < 4; ++i) {
    if (pair.blocks[i] >= 0) values.middleRows<3>(3 * i) = columns.middleRows<3>(3 * pair.blocks[i]);
  }
  return values;
}

void ScatterToPair(const PairCandidate& pair, const PairColumns& values, Eigen::MatrixXd* columns) {
  for (int i = 0; i < 4; ++i) {
    if (pair.blocks[i] >= 0) columns->middleRows<3>(3 * pair.blocks[i]) += values.middleRows<3>(3 * i);
  }
}

PairDerivative::PairDerivative(const ClothModel& model, std::vector<PairContact> contacts,
                               const Eigen::VectorXd& start_positions, const Eigen::VectorXd& velocities,
                               double friction_coefficient)
    : model_(model), contacts_(std::move(contacts)) {
  for (const PairContact& contact : contacts_) {
    gradients_.push_back(DifferentiatePair(contact.candidate.features, start_positions));
    jacobians_.push_back(PairPositionJacobian(contact, gradients_.back(), velocities,
                                              contact.candidate.FrictionOf(friction_coefficient)));
  }
}

Eigen::MatrixXd PairDerivative::TimesWeights(const Eigen::MatrixXd& columns) const {
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(3 * model_.num_free(), columns.cols());
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const PairCandidate& pair = contacts_[c].candidate;
    const Eigen::MatrixXd weights = gradients_[c].weights * GatherFromPair(pair, columns);  // [4 x s]
    PairColumns values(12, columns.cols());
    for (int i = 0; i < 4; ++i) values.middleRows<3>(3 * i) = -contacts_[c].response.impulse * weights.row(i);
    ScatterToPair(pair, values, &result);
  }
  return result;
}

Eigen::MatrixXd PairDerivative::TimesWeightsTransposed(const Eigen::MatrixXd& columns) const {
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(3 * model_.num_free(), columns.cols());
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const PairCandidate& pair = contacts_[c].candidate;
    const PairColumns values = GatherFromPair(pair, columns);
    Eigen::MatrixXd weights(4, columns.cols());
    for (int i = 0; i < 4; ++i) {
      weights.row(i) = -contacts_[c].response.impulse.transpose() * values.middleRows<3>(3 * i);
    }
    ScatterToPair(pair, gradients_[c].weights.transpose() * weights, &result);
  }
  return result;
}

Eigen::MatrixXd PairDerivative::TimesGeometry(const Eigen::MatrixXd& columns) const {
  Eigen::MatrixXd result(3 * static_cast<Eigen::Index>(contacts_.size()), columns.cols());
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    result.middleRows<3>(3 * static_cast<Eigen::Index>(c)) =
        jacobians_[c] * GatherFromPair(contacts_[c].candidate, columns);
  }
  return result;
}

Eigen::MatrixXd PairDerivative::TimesGeometryTransposed(const Eigen::MatrixXd& rows) const {
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(3 * model_.num_free(), rows.cols());
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    ScatterToPair(contacts_[c].candidate,
                  jacobians_[c].transpose() * rows.middleRows<3>(3 * static_cast<Eigen::Index>(c)), &result);
  }
  return result;
}

Eigen::VectorXd PairDerivative::FrictionDerivative() const {
  Eigen::VectorXd derivative(3 * static_cast<Eigen::Index>(contacts_.size()));
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    derivative.segment<3>(3 * static_cast<Eigen::Index>(c)) =
        contacts_[c].candidate.FrictionOf(1.0) * PairFrictionDerivative(contacts_[c].response);
  }
  return derivative;
}

}  // namespace clothid
