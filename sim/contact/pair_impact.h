// What impact_share.h is for a node at an obstacle, for two parts of a cloth that meet.
//
// A pair of weights w acts on its nodes as one body of the mass m_c = (sum w_i^2/m_i)^-1 over free nodes, of which the
// relative velocity changes by c = sum w_i (v_1 - v_n)_i, handles with their own way. With the impulse r, r_N = n . r,
//   L = m_c n . c/r_N, held within 0 and 1,   u_i = L w_i r/m_i = p_i B
//   0 < L < 1:   p_i = w_i m_c/m_i,   B = (n . c) e,   e = r/r_N
//   L = 1:       p_i = w_i/m_i,       B = r
#ifndef CLOTHID_SIM_CONTACT_PAIR_IMPACT_H_
#define CLOTHID_SIM_CONTACT_PAIR_IMPACT_H_

#include <Eigen/Core>

#include "sim/contact/self_contact.h"

namespace clothid {

// Of the nodes of a pair, in its order.
struct PairImpactNodes {
  Eigen::Vector4d inverse_masses = Eigen::Vector4d::Zero();  // 1/kg; zero of handles and unused places
  // v_1 - v_n, m/s.
  Eigen::Matrix<double, 3, 4> velocity_changes = Eigen::Matrix<double, 3, 4>::Zero();
};

struct PairImpact {
  double share = 0.0;                                  // L
  Eigen::Vector4d portions = Eigen::Vector4d::Zero();  // p
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // B, where L > 0
};
PairImpact EvaluatePairImpact(const PairContact& contact, const PairImpactNodes& nodes);

// dB = change dc + impulse dr + position dx_n, du_i = p_i dB + B dp_i; dp through x_n, and by the masses of the nodes.
// dc at fixed weights.
struct PairImpactDerivative {
  Eigen::Matrix3d change = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d impulse = Eigen::Matrix3d::Zero();
  Eigen::Matrix<double, 3, 12> position = Eigen::Matrix<double, 3, 12>::Zero();
  Eigen::Matrix<double, 4, 12> portions = Eigen::Matrix<double, 4, 12>::Zero();
  Eigen::Matrix4d masses = Eigen::Matrix4d::Zero();  // dp_i/dm_j
};
PairImpactDerivative DifferentiatePairImpact(const PairContact& contact, const PairGeometryGradient& gradient,
                                             const PairImpactNodes& nodes);

}  // namespace clothid

#endif  // CLOTHID_SIM_CONTACT_PAIR_IMPACT_H_
