#include "sim/contact/pair_impact.h"

#include <algorithm>

namespace clothid {
namespace {

double PairMass(const PairGeometry& geometry, const PairImpactNodes& nodes) {
  return 1.0 / geometry.weights.cwiseAbs2().dot(nodes.inverse_masses);
}

}  // namespace

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

PairImpactDerivative DifferentiatePairImpact(const PairContact& contact, const PairGeometryGradient& gradient,
                                             const PairImpactNodes& nodes) {
  PairImpactDerivative derivative;
  const PairImpact impact = EvaluatePairImpact(contact, nodes);
  if (impact.share == 0.0) return derivative;
  const Eigen::Vector4d& w = contact.candidate.geometry.weights;
  const Eigen::Vector4d& inverse = nodes.inverse_masses;
  if (impact.share == 1.0) {
    derivative.impulse.setIdentity();
    derivative.portions = inverse.asDiagonal() * gradient.weights;
    derivative.masses.diagonal() = -w.cwiseProduct(inverse.cwiseAbs2());
    return derivative;
  }
  const Eigen::Vector3d& n = contact.candidate.geometry.normal;
  const Eigen::Vector3d& r = contact.response.impulse;
  const double normal_impulse = -contact.response.normal_force;
  const Eigen::Vector3d change = nodes.velocity_changes * w, direction = r / normal_impulse;
  const double ratio = n.dot(change) / normal_impulse;
  derivative.change = direction * n.transpose();
  derivative.impulse = ratio * (Eigen::Matrix3d::Identity() - derivative.change);
  derivative.position = direction * ((change - ratio * r).transpose() * gradient.normal) +
                        derivative.change * (nodes.velocity_changes * gradient.weights);
  const double mass = PairMass(contact.candidate.geometry, nodes);
  const Eigen::Vector4d per_weight = w.cwiseProduct(inverse);  // w_i/m_i
  derivative.portions = mass * (inverse.asDiagonal() * gradient.weights) -
                        (2.0 * mass * mass) * per_weight * (per_weight.transpose() * gradient.weights);
  derivative.masses = (mass * mass) * per_weight * per_weight.cwiseAbs2().transpose();
  derivative.masses.diagonal() -= mass * per_weight.cwiseProduct(inverse);
  return derivative;
}

}  // namespace clothid
