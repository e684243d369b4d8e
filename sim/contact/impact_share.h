// What of the impulse of a contact has stopped an impact, and its derivatives.
//
// A solve took a node of mass m from v_n to v_1, with the impulse r of a contact of normal n, r_N = n . r > 0, and the
// impulse p = m (v_1 - v_n) - r of all other forces. Of r_N the share s = -n . p/r_N balances what presses the node on;
// what is left has changed its normal velocity. With c = v_1 - v_n, less what the velocity of its obstacle there has
// changed by (`Contact::obstacle_gain`), this is
//   1 - s = L = m n . c/r_N, held within 0 and 1:   0 for a node that rests or slides on a plane,
//                                                  1 where nothing presses it on
//   u = L r/m = (n . c) e, e = r/r_N, while 0 < L < 1:   the change of velocity that stopped the impact, m/s
// u is continuous: between its branches, and at take-off, where r vanishes. A second-order step leaves it out of what
// it carries over from its first stage (sim/step/second_start.h).
//
// A pair of the cloth with itself, of weights w, acts on its nodes as one body of the mass m = (sum w_i^2/m_i)^-1 over
// free nodes, of which the relative velocity changes by c = sum w_i (v_1 - v_n)_i, handles with their own way:
//   u_i = L w_i r/m_i = p_i B
//   0 < L < 1:   p_i = w_i m/m_i,     B = (n . c) e
//   L = 1:       p_i = w_i/m_i,       B = r
#ifndef CLOTHID_SIM_CONTACT_IMPACT_SHARE_H_
#define CLOTHID_SIM_CONTACT_IMPACT_SHARE_H_

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "sim/cloth/cloth_model.h"
#include "sim/contact/contact_set.h"

namespace clothid {

// L of a sticking or slipping node; `velocity_change` is v_1 - v_n.
double ImpactShare(const Contact& contact, double mass, const Eigen::Vector3d& velocity_change);

// u.
Eigen::Vector3d ImpactVelocity(const Contact& contact, double mass, const Eigen::Vector3d& velocity_change);

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

// du = U_c d(v_1 - v_n) + U_r dr + U_x dx_n + U_m dm, one node after the other; U_c at fixed weights.
template <int kNodes>
struct ImpactDerivative {
  template <int kColumns>
  using Columns = Eigen::Matrix<double, 3 * kNodes, kColumns>;
  Columns<3 * kNodes> change = Columns<3 * kNodes>::Zero();    // U_c
  Columns<3> impulse = Columns<3>::Zero();                     // U_r, 1/kg
  Columns<3 * kNodes> position = Columns<3 * kNodes>::Zero();  // U_x, 1/s
  Columns<kNodes> masses = Columns<kNodes>::Zero();            // U_m, m/(s kg)
};

// At an obstacle, with N' = dn/dx; `motion` of the obstacle, null where it stands still:
//   0 < L < 1:   U_c = e n^T,   U_r = (n . c)/r_N (I - e n^T),   U_n = e (c - (n . c) e)^T,   U_m = 0
//   L = 1:       U_c = 0,       U_r = I/m,                       U_n = 0,                     U_m = -r/m^2
// U_x = U_n N' - U_c G, G the gradient of the obstacle's gain of velocity.
struct ObstacleImpactDerivative : ImpactDerivative<1> {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();  // U_n, m/s
};
ObstacleImpactDerivative DifferentiateImpact(const Contact& contact, double mass,
                                             const Eigen::Vector3d& velocity_change,
                                             const AffineMotion* motion = nullptr);
// Of a pair: du_i = p_i dB + B dp_i.
ImpactDerivative<4> DifferentiateImpact(const PairContact& contact, const PairGeometryGradient& gradient,
                                        const PairImpactNodes& nodes);

// A solve, from v_n to v_1 [3N] m/s, those of handles of their way over it; as long as all of these live.
struct SolveMotion {
  const ClothModel& model;
  const Material& material;
  const Eigen::VectorXd& start_velocities;
  const Eigen::VectorXd& end_velocities;

  Eigen::Vector3d ChangeOf(int node) const {
    return end_velocities.segment<3>(3 * node) - start_velocities.segment<3>(3 * node);
  }
};

// What the impact of a pair counts of its nodes.
PairImpactNodes ImpactNodes(const PairCandidate& pair, const SolveMotion& motion);

// Takes `factor` times u of every contact off `velocities` [3N].
void SubtractImpacts(const ContactSet& contacts, const SolveMotion& motion, double factor, Eigen::VectorXd* velocities);

// The derivatives of the pairs whose impact counts.
struct ClothImpactDerivative {
  std::array<int, 4> nodes;   // -1: unused
  std::array<int, 4> blocks;  // among the free ones, or -1
  std::size_t contact;        // among the pairs
  ImpactDerivative<4> derivative;
};
std::vector<ClothImpactDerivative> DifferentiateClothImpacts(const ContactSet& contacts, const SolveMotion& motion,
                                                             const Eigen::VectorXd& start_positions);

}  // namespace clothid

#endif  // CLOTHID_SIM_CONTACT_IMPACT_SHARE_H_
