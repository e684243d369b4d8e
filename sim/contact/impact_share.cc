#include "sim/contact/impact_share.h"

#include <algorithm>

namespace clothid {
namespace {

double PairMass(const PairGeometry& geometry, const PairImpactNodes& nodes) {
  return 1.0 / geometry.weights.cwiseAbs2().dot(nodes.inverse_masses);
}

// dB = change dc + impulse dr + position dx_n, and dp by x_n and by the masses.
struct PairImpactParts {
  Eigen::Matrix3d change = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d impulse = Eigen::Matrix3d::Identity();
  Eigen::Matrix<double, 3, 12> position = Eigen::Matrix<double, 3, 12>::Zero();
  Eigen::Matrix<double, 4, 12> portions;
  Eigen::Matrix4d masses = Eigen::Matrix4d::Zero();  // dp_i/dm_j
};

PairImpactParts WholeImpact(const PairGeometry& geometry, const PairGeometryGradient& gradient,
                            const PairImpactNodes& nodes) {
  PairImpactParts parts;
  parts.portions = nodes.inverse_masses.asDiagonal() * gradient.weights;
  parts.masses.diagonal() = -geometry.weights.cwiseProduct(nodes.inverse_masses.cwiseAbs2());
  return parts;
}

PairImpactParts SharedImpact(const PairContact& contact, const PairGeometryGradient& gradient,
                             const PairImpactNodes& nodes) {
  const PairGeometry& geometry = contact.candidate.geometry;
  const Eigen::Vector4d &w = geometry.weights, &inverse = nodes.inverse_masses;
  const Eigen::Vector3d &n = geometry.normal, &r = contact.response.impulse;
  const double normal_impulse = -contact.response.normal_force;
  const Eigen::Vector3d change = nodes.velocity_changes * w, direction = r / normal_impulse;
  const double ratio = n.dot(change) / normal_impulse;
  PairImpactParts parts;
  parts.change = direction * n.transpose();
  parts.impulse = ratio * (Eigen::Matrix3d::Identity() - parts.change);
  parts.position = direction * ((change - ratio * r).transpose() * gradient.normal) +
                   parts.change * (nodes.velocity_changes * gradient.weights);
  const double mass = PairMass(geometry, nodes);
  const Eigen::Vector4d per_weight = w.cwiseProduct(inverse);  // w_i/m_i
  parts.portions = mass * (inverse.asDiagonal() * gradient.weights) -
                   (2.0 * mass * mass) * per_weight * (per_weight.transpose() * gradient.weights);
  parts.masses = (mass * mass) * per_weight * per_weight.cwiseAbs2().transpose();
  parts.masses.diagonal() -= mass * per_weight.cwiseProduct(inverse);
  return parts;
}

}  // namespace

double ImpactShare(const Contact& contact, double mass, const Eigen::Vector3d& velocity_change) {
  const double gain =
      mass * contact.candidate.normal.dot(velocity_change - contact.obstacle_gain);  // of normal momentum
  const double normal_impulse = -contact.response.normal_force;
  return gain >= normal_impulse ? 1.0 : std::max(0.0, gain / normal_impulse);
}

Eigen::Vector3d ImpactVelocity(const Contact& contact, double mass, const Eigen::Vector3d& velocity_change) {
  return ImpactShare(contact, mass, velocity_change) / mass * contact.response.impulse;
}

PairImpact EvaluatePairImpact(const PairContact& contact, const PairImpactNodes& nodes) {
  const PairGeometry& geometry = contact.candidate.geometry;
  const double mass = PairMass(geometry, nodes), normal_impulse = -contact.response.normal_force;
  const double speed = geometry.normal.dot(nodes.velocity_changes * geometry.weights);
  PairImpact impact;
  impact.portions = geometry.weights.cwiseProduct(nodes.inverse_masses);
  if (mass * speed >= normal_impulse) {
    impact.share = 1.0;
    impact.velocity = contact.response.impulse;
  } else if (speed > 0.0) {
    impact.share = mass * speed / normal_impulse;
    impact.portions *= mass;
    impact.velocity = speed / normal_impulse * contact.response.impulse;
  }
  return impact;
}

ObstacleImpactDerivative DifferentiateImpact(const Contact& contact, double mass,
                                             const Eigen::Vector3d& velocity_change, const AffineMotion* motion) {
  ObstacleImpactDerivative derivative;
  const double share = ImpactShare(contact, mass, velocity_change);
  if (share == 0.0) return derivative;
  if (share == 1.0) {
    derivative.impulse = Eigen::Matrix3d::Identity() / mass;
    derivative.masses = -contact.response.impulse / (mass * mass);
    return derivative;
  }
  const Eigen::Vector3d& n = contact.candidate.normal;
  const Eigen::Vector3d change = velocity_change - contact.obstacle_gain;
  const double normal_impulse = -contact.response.normal_force, speed = n.dot(change);
  const Eigen::Vector3d direction = contact.response.impulse / normal_impulse;
  derivative.change = direction * n.transpose();
  derivative.impulse = speed / normal_impulse * (Eigen::Matrix3d::Identity() - derivative.change);
  derivative.normal = direction * (change - speed * direction).transpose();
  derivative.position = derivative.normal * contact.candidate.normal_gradient;
  if (motion != nullptr) derivative.position -= derivative.change * motion->velocity_change().gradient;
  return derivative;
}

ImpactDerivative<4> DifferentiateImpact(const PairContact& contact, const PairGeometryGradient& gradient,
                                        const PairImpactNodes& nodes) {
  ImpactDerivative<4> derivative;
  const PairImpact impact = EvaluatePairImpact(contact, nodes);
  if (impact.share == 0.0) return derivative;
  const PairGeometry& geometry = contact.candidate.geometry;
  const PairImpactParts parts =
      impact.share == 1.0 ? WholeImpact(geometry, gradient, nodes) : SharedImpact(contact, gradient, nodes);
  for (int i = 0; i < 4; ++i) {
    const double portion = impact.portions[i];
    derivative.impulse.middleRows<3>(3 * i) = portion * parts.impulse;
    derivative.position.middleRows<3>(3 * i) = portion * parts.position + impact.velocity * parts.portions.row(i);
    derivative.masses.middleRows<3>(3 * i) = impact.velocity * parts.masses.row(i);
    for (int j = 0; j < 4; ++j) {
      derivative.change.block<3, 3>(3 * i, 3 * j) = portion * geometry.weights[j] * parts.change;
    }
  }
  return derivative;
}

PairImpactNodes ImpactNodes(const PairCandidate& pair, const SolveMotion& motion) {
  PairImpactNodes nodes;
  for (int i = 0; i < pair.features.num_nodes(); ++i) {
    const int node = pair.features.nodes[i];
    if (pair.blocks[i] >= 0) nodes.inverse_masses[i] = 1.0 / motion.model.mass(motion.material, node);
    nodes.velocity_changes.col(i) = motion.ChangeOf(node);
  }
  return nodes;
}

void SubtractImpacts(const ContactSet& contacts, const SolveMotion& motion, double factor,
                     Eigen::VectorXd* velocities) {
  for (const Contact& contact : contacts.nodes) {
    const int node = contact.candidate.node;
    velocities->segment<3>(3 * node) -=
        factor * ImpactVelocity(contact, motion.model.mass(motion.material, node), motion.ChangeOf(node));
  }
  for (const PairContact& pair : contacts.pairs) {
    const PairImpact impact = EvaluatePairImpact(pair, ImpactNodes(pair.candidate, motion));
    for (int i = 0; i < pair.candidate.features.num_nodes(); ++i) {
      velocities->segment<3>(3 * pair.candidate.features.nodes[i]) -= factor * impact.portions[i] * impact.velocity;
    }
  }
}

std::vector<ClothImpactDerivative> DifferentiateClothImpacts(const ContactSet& contacts, const SolveMotion& motion,
                                                             const Eigen::VectorXd& start_positions) {
  std::vector<ClothImpactDerivative> impacts;
  for (std::size_t c = 0; c < contacts.pairs.size(); ++c) {
    const PairCandidate& pair = contacts.pairs[c].candidate;
    const PairImpactNodes nodes = ImpactNodes(pair, motion);
    if (EvaluatePairImpact(contacts.pairs[c], nodes).share == 0.0) continue;
    const PairGeometryGradient gradient = DifferentiatePair(pair.features, start_positions);
    impacts.push_back({pair.features.nodes, pair.blocks, c, DifferentiateImpact(contacts.pairs[c], gradient, nodes)});
  }
  return impacts;
}

}  // namespace clothid
