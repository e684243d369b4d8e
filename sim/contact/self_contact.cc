#include "sim/contact/self_contact.h"

#include <algorithm>

namespace clothid {
namespace {

// Thicknesses in which layers that start too near are pushed apart, 1/s: slower than they would fall by one.
constexpr double kPushRate = 20.0;

}  // namespace

void PairCandidate::SetNodes(const Eigen::VectorXd& velocities, const Eigen::Vector4d& weights) {
  held_velocity.setZero();
  double compliance = 0.0;
  for (int i = 0; i < features.num_nodes(); ++i) {
    const double w = geometry.weights[i];
    if (blocks[i] >= 0) {
      compliance += w * w / weights[i];
    } else {
      held_velocity += w * velocities.segment<3>(3 * features.nodes[i]);
    }
  }
  weight = 1.0 / compliance;
}

Eigen::Vector3d PairCandidate::RelativeVelocity(const Eigen::VectorXd& velocities) const {
  Eigen::Vector3d velocity = held_velocity;
  for (int i = 0; i < 4; ++i) {
    if (blocks[i] >= 0) velocity += geometry.weights[i] * velocities.segment<3>(3 * blocks[i]);
  }
  return velocity;
}

PairCandidate MakePairCandidate(const PairFeatures& features, const Eigen::VectorXd& positions,
                                const std::vector<int>& free_index, double thickness, double gap_time,
                                double depenetration_speed) {
  PairCandidate candidate;
  candidate.features = features;
  candidate.geometry = EvaluatePair(features, positions);
  for (int i = 0; i < features.num_nodes(); ++i) candidate.blocks[i] = free_index[features.nodes[i]];
  candidate.gap = candidate.geometry.distance - thickness;
  // What is nearer than pairs that are left out may be is pushed back there at once, what is not so near slowly.
  const double near = std::max(candidate.gap, (kLeastPairDistance - 1.0) * thickness), deep = candidate.gap - near;
  const double near_speed = std::max(near / gap_time, -kPushRate * thickness), speed = near_speed + deep / gap_time;
  const bool limited = speed < -depenetration_speed || (deep == 0.0 && near_speed > near / gap_time);
  candidate.gap_speed = std::max(speed, -depenetration_speed);
  candidate.gap_speed_slope = limited ? 0.0 : 1.0 / gap_time;
  return candidate;
}

// With S of contact_law.h, dPi/da = -S, and da = -d (V dw + dgap_speed n + gap_speed dn).
Eigen::Matrix<double, 3, 12> PairPositionJacobian(const PairContact& contact, const PairGeometryGradient& gradient,
                                                  const Eigen::VectorXd& velocities) {
  const PairCandidate& candidate = contact.candidate;
  const Eigen::Vector3d& n = candidate.geometry.normal;
  Eigen::Matrix<double, 3, 12> target =
      candidate.gap_speed_slope * n * gradient.distance + candidate.gap_speed * gradient.normal;
  for (int i = 0; i < candidate.features.num_nodes(); ++i) {
    target += velocities.segment<3>(3 * candidate.features.nodes[i]) * gradient.weights.row(i);
  }
  Eigen::Matrix<double, 3, 12> jacobian =
      -candidate.weight * (ImpulseForceJacobian(contact.response, n, contact.friction_coefficient) * target);
  for (int i = 0; i < candidate.features.num_nodes(); ++i) {
    const Eigen::Matrix3d turn = gradient.normal.middleCols<3>(3 * i);
    jacobian.middleCols<3>(3 * i) -=
        ImpulsePositionJacobian(contact.response, contact.force, n, turn, contact.friction_coefficient);
  }
  return jacobian;
}

Eigen::Vector3d PairFrictionDerivative(const ContactResponse& response) {
  if (response.branch != ContactBranch::kSlip) return Eigen::Vector3d::Zero();
  return -response.normal_force * response.slip_direction;
}

}  // namespace clothid
