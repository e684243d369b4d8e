#include "sim/contact/impact_share.h"

#include <algorithm>

namespace clothid {

double ImpactShare(const Contact& contact, double mass, const Eigen::Vector3d& velocity_change) {
  const double gain =
      mass * contact.candidate.normal.dot(velocity_change - contact.obstacle_gain);  // of normal momentum
  const double normal_impulse = -contact.response.normal_force;
  return gain >= normal_impulse ? 1.0 : std::max(0.0, gain / normal_impulse);
}

Eigen::Vector3d ImpactVelocity(const Contact& contact, double mass, const Eigen::Vector3d& velocity_change) {
  return ImpactShare(contact, mass, velocity_change) / mass * contact.response.impulse;
}

ImpactVelocityDerivative DifferentiateImpactVelocity(const Contact& contact, double mass,
                                                     const Eigen::Vector3d& velocity_change,
                                                     const AffineMotion* motion) {
  ImpactVelocityDerivative derivative;
  const double share = ImpactShare(contact, mass, velocity_change);
  if (share == 0.0) return derivative;
  if (share == 1.0) {
    derivative.impulse = Eigen::Matrix3d::Identity() / mass;
    derivative.mass = -contact.response.impulse / (mass * mass);
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

}  // namespace clothid
