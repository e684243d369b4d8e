#include "sim/contact/impulse_blocks.h"

#include <vector>

namespace clothid {
namespace {

using Triplets = std::vector<Eigen::Triplet<double>>;

// `block` as rows and columns from `row` and `column` on.
void Add(const Eigen::Matrix3d& block, Eigen::Index row, Eigen::Index column, Triplets* triplets) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) triplets->emplace_back(row + i, column + j, block(i, j));
  }
}

}  // namespace

// R = r - Pi(a) with da = -d w_i dv_i and dPi/da = -S.
ImpulseBlocks DifferentiateImpulses(const ContactSet& contacts, const Eigen::VectorXd& start_positions,
                                    const Eigen::VectorXd& velocities) {
  const std::vector<PairContact>& pairs = contacts.pairs;
  if (pairs.empty()) return {};
  const Eigen::Index size = start_positions.size(), num_rows = 3 * static_cast<Eigen::Index>(pairs.size());
  ImpulseBlocks derivative{
      {size, num_rows}, {size, size}, {num_rows, size}, {num_rows, size}, Eigen::VectorXd(num_rows)};
  Triplets spread, weights, geometry, speeds;
  for (Eigen::Index row = 0; row < num_rows; row += 3) {
    const PairContact& contact = pairs[row / 3];
    const PairCandidate& pair = contact.candidate;
    const PairGeometryGradient gradient = DifferentiatePair(pair.features, start_positions);
    const Eigen::Matrix<double, 3, 12> position = PairPositionJacobian(contact, gradient, velocities);
    const Eigen::Matrix3d speed =
        -pair.weight * ImpulseForceJacobian(contact.response, pair.geometry.normal, contact.friction_coefficient);
    derivative.friction.segment<3>(row) = pair.FrictionOf(1.0) * PairFrictionDerivative(contact.response);
    for (int i = 0; i < pair.features.num_nodes(); ++i) {
      const int node = 3 * pair.features.nodes[i];
      Add(pair.geometry.weights[i] * Eigen::Matrix3d::Identity(), node, row, &spread);
      Add(pair.geometry.weights[i] * speed, row, node, &speeds);
      Add(position.middleCols<3>(3 * i), row, node, &geometry);
      for (int j = 0; j < pair.features.num_nodes(); ++j) {
        Add(-contact.response.impulse * gradient.weights.block<1, 3>(i, 3 * j), node, 3 * pair.features.nodes[j],
            &weights);
      }
    }
  }
  derivative.spread.setFromTriplets(spread.begin(), spread.end());
  derivative.weights.setFromTriplets(weights.begin(), weights.end());
  derivative.geometry.setFromTriplets(geometry.begin(), geometry.end());
  derivative.speeds.setFromTriplets(speeds.begin(), speeds.end());
  return derivative;
}

}  // namespace clothid
