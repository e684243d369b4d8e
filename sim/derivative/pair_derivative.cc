#include "sim/derivative/pair_derivative.h"

#include <algorithm>

namespace clothid {

PairColumns GatherFromPair(const PairBlocks& blocks, const Eigen::MatrixXd& columns) {
  PairColumns values = PairColumns::Zero(12, columns.cols());
  for (int i = 0; i < 4; ++i) {
    if (blocks[i] >= 0) values.middleRows<3>(3 * i) = columns.middleRows<3>(3 * blocks[i]);
  }
  return values;
}

void ScatterToPair(const PairBlocks& blocks, const PairColumns& values, Eigen::MatrixXd* columns) {
  for (int i = 0; i < 4; ++i) {
    if (blocks[i] >= 0) columns->middleRows<3>(3 * blocks[i]) += values.middleRows<3>(3 * i);
  }
}

PairDerivative::PairDerivative(const ClothModel& model, const std::vector<PairContact>& contacts,
                               const Eigen::VectorXd& start_positions, const Eigen::VectorXd& velocities)
    : model_(model), contacts_(contacts) {
  const std::vector<int>& handles = model.scene().handles.nodes;
  for (const PairContact& contact : contacts_) {
    const PairFeatures& features = contact.candidate.features;
    gradients_.push_back(DifferentiatePair(features, start_positions));
    jacobians_.push_back(PairPositionJacobian(contact, gradients_.back(), velocities));
    handle_blocks_.push_back({-1, -1, -1, -1});
    for (int i = 0; i < features.num_nodes(); ++i) {
      const auto handle = std::find(handles.begin(), handles.end(), features.nodes[i]);
      if (handle != handles.end()) handle_blocks_.back()[i] = static_cast<int>(handle - handles.begin());
    }
  }
}

Eigen::Index PairDerivative::NumRows(PairNodes nodes) const {
  return nodes == PairNodes::kFree ? 3 * model_.num_free()
                                   : 3 * static_cast<Eigen::Index>(model_.scene().handles.nodes.size());
}

Eigen::MatrixXd PairDerivative::TimesWeights(const Eigen::MatrixXd& columns, PairNodes nodes, PairNodes rows) const {
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(NumRows(rows), columns.cols());
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const Eigen::MatrixXd weights = gradients_[c].weights * GatherFromPair(blocks(c, nodes), columns);  // [4 x s]
    PairColumns values(12, columns.cols());
    for (int i = 0; i < 4; ++i) values.middleRows<3>(3 * i) = -contacts_[c].response.impulse * weights.row(i);
    ScatterToPair(blocks(c, rows), values, &result);
  }
  return result;
}

Eigen::MatrixXd PairDerivative::TimesWeightsTransposed(const Eigen::MatrixXd& columns, PairNodes nodes,
                                                       PairNodes rows) const {
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(NumRows(nodes), columns.cols());
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const PairColumns values = GatherFromPair(blocks(c, rows), columns);
    Eigen::MatrixXd weights(4, columns.cols());
    for (int i = 0; i < 4; ++i) {
      weights.row(i) = -contacts_[c].response.impulse.transpose() * values.middleRows<3>(3 * i);
    }
    ScatterToPair(blocks(c, nodes), gradients_[c].weights.transpose() * weights, &result);
  }
  return result;
}

Eigen::MatrixXd PairDerivative::TimesGeometry(const Eigen::MatrixXd& columns, PairNodes nodes) const {
  Eigen::MatrixXd result(3 * static_cast<Eigen::Index>(contacts_.size()), columns.cols());
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    result.middleRows<3>(3 * static_cast<Eigen::Index>(c)) = jacobians_[c] * GatherFromPair(blocks(c, nodes), columns);
  }
  return result;
}

Eigen::MatrixXd PairDerivative::TimesGeometryTransposed(const Eigen::MatrixXd& rows, PairNodes nodes) const {
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(NumRows(nodes), rows.cols());
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    ScatterToPair(blocks(c, nodes), jacobians_[c].transpose() * rows.middleRows<3>(3 * static_cast<Eigen::Index>(c)),
                  &result);
  }
  return result;
}

// R = r - Pi(a) with da = -d w_i dv_i and dPi/da = -S.
Eigen::Matrix<double, 3, 12> PairDerivative::ByVelocities(std::size_t contact) const {
  const PairCandidate& pair = contacts_[contact].candidate;
  const Eigen::Matrix3d slope = -pair.weight * ImpulseForceJacobian(contacts_[contact].response, pair.geometry.normal,
                                                                    contacts_[contact].friction_coefficient);
  Eigen::Matrix<double, 3, 12> jacobian;
  for (int i = 0; i < 4; ++i) jacobian.middleCols<3>(3 * i) = pair.geometry.weights[i] * slope;
  return jacobian;
}

Eigen::MatrixXd PairDerivative::TimesHandleVelocities(const Eigen::MatrixXd& columns) const {
  Eigen::MatrixXd result(3 * static_cast<Eigen::Index>(contacts_.size()), columns.cols());
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    result.middleRows<3>(3 * static_cast<Eigen::Index>(c)) =
        ByVelocities(c) * GatherFromPair(handle_blocks_[c], columns);
  }
  return result;
}

Eigen::MatrixXd PairDerivative::TimesHandleVelocitiesTransposed(const Eigen::MatrixXd& rows) const {
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(NumRows(PairNodes::kHandles), rows.cols());
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    ScatterToPair(handle_blocks_[c], ByVelocities(c).transpose() * rows.middleRows<3>(3 * static_cast<Eigen::Index>(c)),
                  &result);
  }
  return result;
}

Eigen::MatrixXd PairDerivative::Spread(const Eigen::MatrixXd& impulses, PairNodes nodes) const {
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(NumRows(nodes), impulses.cols());
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const Eigen::MatrixXd impulse = impulses.middleRows<3>(3 * static_cast<Eigen::Index>(c));
    PairColumns values(12, impulses.cols());
    for (int i = 0; i < 4; ++i) {
      values.middleRows<3>(3 * i) = contacts_[c].candidate.geometry.weights[i] * impulse;
    }
    ScatterToPair(blocks(c, nodes), values, &result);
  }
  return result;
}

Eigen::MatrixXd PairDerivative::SpreadTransposed(const Eigen::MatrixXd& columns, PairNodes nodes) const {
  Eigen::MatrixXd result(3 * static_cast<Eigen::Index>(contacts_.size()), columns.cols());
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const PairColumns values = GatherFromPair(blocks(c, nodes), columns);
    auto sum = result.middleRows<3>(3 * static_cast<Eigen::Index>(c));
    sum.setZero();
    for (int i = 0; i < 4; ++i) sum += contacts_[c].candidate.geometry.weights[i] * values.middleRows<3>(3 * i);
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
